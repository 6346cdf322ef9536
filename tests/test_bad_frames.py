"""Bad frames in a good recording are counted, and the run goes on."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import call, succeed
from recordings import truncate, write_depth, write_folder, write_image, write_seven_scenes
from room import ROOM, kinect, poses_around, render

Capsys = pytest.CaptureFixture[str]


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A recording to spoil."""
    write_folder(tmp_path / "room", 4)
    return tmp_path / "room"


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def cut_depth(source: Path) -> None:
    truncate(source / "depth/000001.png")


def cut_colour(source: Path) -> None:
    truncate(source / "rgb/000001.png", 0.6)


def remove_depth(source: Path) -> None:
    (source / "depth/000001.png").unlink()


def shrink_depth(source: Path) -> None:
    write_depth(source / "depth/000001.png", np.ones((60, 80), np.float32))


def shrink_colour(source: Path) -> None:
    write_image(source / "rgb/000001.png", np.zeros((60, 80, 3), np.uint8))


def lose_pose(source: Path) -> None:
    lines = (source / "poses.txt").read_text().splitlines()
    lines[1] = lines[1].split()[0] + " nan" * 7
    (source / "poses.txt").write_text("\n".join(lines))


SPOILERS = (cut_depth, cut_colour, remove_depth, shrink_depth, shrink_colour, lose_pose)


@pytest.mark.parametrize("spoil", SPOILERS)
@pytest.mark.parametrize("command", ["learn", "segment", "explore --strategy chronological"])
def test_some_bad_frames(
    spoil: Callable[[Path], None], command: str, source: Path, out: Path, capsys: Capsys
) -> None:
    spoil(source)
    steps = ("--steps", 4, "--regions", "time:2") if command.startswith("explore") else ()
    outcome = succeed(capsys, *command.split(), source, *steps, "--out", out)
    (warning,) = (line for line in outcome.err.splitlines() if line.startswith("warning"))
    assert warning.startswith("warning: 1 of 4 frames t")
    assert "first 000001 (" in warning


@pytest.mark.parametrize("pose", [np.diag([2.0, 1, 1, 1]), np.full((4, 4), np.nan)])
def test_pose_that_is_none(pose: Any, out: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_seven_scenes(tmp_path / "kitchen", 4)
    np.savetxt(tmp_path / "kitchen/seq-01/frame-000002.pose.txt", pose)
    outcome = succeed(capsys, "learn", tmp_path / "kitchen", "--out", out)
    assert "warning: 1 of 4 frames taught nothing: bad frame, first frame-000002" in outcome.err


def test_truncated_jpeg(out: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_seven_scenes(tmp_path / "kitchen", 4, ending="jpg")
    truncate(tmp_path / "kitchen/seq-01/frame-000002.color.jpg", 0.6)
    outcome = succeed(capsys, "learn", tmp_path / "kitchen", "--out", out)
    assert "frame-000002 (frame-000002.color.jpg is truncated)" in outcome.err


@pytest.mark.parametrize("command", ["evaluate MODEL", "evaluate --folds 2"])
def test_bad_frames_are_not_scored(
    command: str, model: Path, source: Path, out: Path, capsys: Capsys
) -> None:
    cut_depth(source)
    truncate(source / "ground_truth/000002.png")
    words = [model if word == "MODEL" else word for word in command.split()]
    outcome = succeed(capsys, *words, source, "--out", out)
    assert "warning: 2 of 4 frames could not be used: bad frame, first 000001" in outcome.err
    metrics = json.loads((out / "metrics.json").read_text())
    assert sorted(score["id"] for score in metrics["per_frame"]) == ["000000", "000003"]


def test_bad_test_frames_are_told(source: Path, out: Path, capsys: Capsys) -> None:
    truncate(source / "depth/000002.png")
    options = ("--test-every", 2, "--gap", 0, "--steps", 2)
    outcome = succeed(capsys, "explore", source, *options, "--out", out)
    assert "without 1 test frame: bad, or nothing salient in view" in outcome.err
    assert json.loads((out / "summary.json").read_text())["test_frames"] == 1


def test_one_frame(out: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 1)
    for command in ("explore --steps 3", "learn", "segment"):
        succeed(capsys, *command.split(), tmp_path / "room", "--out", out / command[:5])
    steps = (out / "explo/steps.csv").read_text().splitlines()
    assert [line.split(",")[1] for line in steps[1:]] == ["000000"] * 3


def test_recording_without_any_object(source: Path, model: Path, out: Path, capsys: Capsys) -> None:
    for index, pose in enumerate(poses_around(4)):
        view = render(kinect(), pose, ROOM[3:])
        write_image(source / f"rgb/{index:06d}.png", view.rgb)
        write_depth(source / f"depth/{index:06d}.png", view.depth)
        write_image(source / f"ground_truth/{index:06d}.png", view.ground_truth)
    explored = call(
        capsys, "explore", source, "--steps", 4, "--test-every", 2, "--gap", 0, "--out", out / "e"
    )
    learned = call(capsys, "learn", source, "--out", out / "l")
    folded = call(capsys, "evaluate", source, "--folds", 2, "--out", out / "f")
    for outcome in (explored, learned, folded):
        assert outcome.status == 1, outcome.err
        assert "4 of 4 looks taught nothing about objects: no object (4)" in outcome.err
        assert "warning: no object: see `curiosight segment SOURCE --reasons`" in outcome.err
        assert "warning: nothing was learned" in outcome.err
    expected = {"looks": 4, "reasons": {"no object": 4}}
    for name in ("e/summary.json", "l/summary.json", "f/metrics.json"):
        assert json.loads((out / name).read_text())["taught_nothing"] == expected
    page = (out / "e/report.html").read_text()
    assert "4 of 4 looks taught nothing about objects: no object (4)" in page
    assert "try --scene floor" in page
    evaluated = succeed(capsys, "evaluate", model, source, "--out", out / "v")
    assert "warning: no frame shows anything salient" in evaluated.err
    mapped = call(capsys, "map", out / "l", source, "--out", out / "m")
    assert mapped.status == 1
    assert "every map is black" in mapped.err
    assert len(list((out / "m").glob("*.png"))) == 4
    scored = call(capsys, "evaluate", out / "l", source, "--out", out / "s")
    assert scored.status == 1
    assert "warning: nothing was learned" in scored.err


def test_recording_without_any_plane(source: Path, out: Path, capsys: Capsys) -> None:
    rng = np.random.default_rng(0)
    for path in (source / "depth").iterdir():
        write_image(path, rng.integers(500, 5000, (120, 160), np.uint16))
    for command in ("explore --steps 4 --strategy chronological", "learn", "segment"):
        outcome = call(capsys, *command.split(), source, "--out", out / command[:5])
        assert outcome.status == (0 if command == "segment" else 1)
        assert "warning: 4 of 4 frames t" in outcome.err
        assert "no support plane is in view" in outcome.err


def test_info_of_a_recording_without_a_good_frame(source: Path, capsys: Capsys) -> None:
    for path in (source / "depth").glob("*.png"):
        truncate(path)
    assert json.loads(succeed(capsys, "info", source, "--json").out)["scene"] is None
