"""curiosight bench: what it times, prints and refuses."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import cv2
import pytest

from command import call, interrupt_at, refusal, succeed
from curiosight.config import load_config
from curiosight.datasets import open_dataset
from curiosight.experiments.racing import Build, Race
from curiosight.experiments.timing import STAGES, WITH_FOREST, StageTimes, Timing, one_thread
from curiosight.teacher import TemporalTeacher
from recordings import truncate, write_folder

Capsys = pytest.CaptureFixture[str]
FIGURES = {"median_ms", "p90_ms", "processor_median_ms", "processor_p90_ms"}


def test_all_stages_are_timed(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "bench.json"
    shown = succeed(capsys, "bench", room, "--frames", 3, "--json", file).out
    figures = json.loads(file.read_text())
    assert tuple(figures["stages"]) == STAGES
    assert figures["left_out"] == {}
    assert (figures["frames"], figures["image"], figures["threads"]) == (3, "160x120", 1)
    assert figures["preset"] == "default"
    for stage, spent in figures["stages"].items():
        assert set(spent) == FIGURES
        assert 0 < spent["median_ms"] <= spent["p90_ms"]
        assert f"{stage} (ms)" in shown
    # What the times depend on: a full buffer, of which a tree draws all rows or 16 000.
    forest = load_config().forest
    assert (figures["samples"], figures["places"]) == (forest.max_samples, 1)
    assert 0 < figures["rows_a_tree"] <= (forest.max_rows or 0)
    assert forest.n_regrown <= figures["trees_regrown_a_frame"] <= forest.n_trees
    assert f"rows a tree {figures['rows_a_tree']} " in " ".join(shown.split()) + " "


@pytest.mark.parametrize("stage", STAGES)
def test_one_stage_is_timed(stage: str, room: Path, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "bench.json"
    succeed(capsys, "bench", room, "--frames", 2, "--stage", stage, "--json", file, "--quiet")
    figures = json.loads(file.read_text())
    assert list(figures["stages"]) == [stage]
    assert ("rows_a_tree" in figures) == (stage in WITH_FOREST)
    assert ("trees_regrown_a_frame" in figures) == (stage in ("learn", "step"))


def test_without_poses_memory_is_left_out_and_that_is_said(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 2)
    (tmp_path / "room/poses.txt").unlink(missing_ok=True)
    file = tmp_path / "bench.json"
    told = succeed(capsys, "bench", tmp_path / "room", "--frames", 2, "--json", file).err
    figures = json.loads(file.read_text())
    assert "segment_memory is left out: the recording has no poses" in told
    assert figures["left_out"] == {"segment_memory": "the recording has no poses"}
    assert tuple(figures["stages"]) == tuple(s for s in STAGES if s != "segment_memory")


def test_stages_take_what_they_are_made_of(room: Path) -> None:
    timing = Timing(load_config(), open_dataset(room), n_frames=4)
    called: list[str] = []
    for name in ("describe", "segment", "vote", "learn"):
        note_calls(timing.learner, name, called)
    for _ in timing:
        pass
    assert isinstance(timing.learner.teacher, TemporalTeacher)
    assert called[-4:] == ["describe", "segment", "vote", "learn"]  # the step's
    assert called[-6:-4] == ["describe", "vote"]  # the map's
    assert all(len(times.wall_ms) == 4 for times in timing.times.values())


def note_calls(owner: object, name: str, called: list[str]) -> None:
    original = getattr(owner, name)

    def noted(*arguments: object) -> object:
        called.append(name)
        return original(*arguments)

    setattr(owner, name, noted)


def test_two_builds_are_timed_in_turns(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "bench.json"
    options = ("--frames", 1, "--stage", "segment", "--rounds", 1, "--json", file)
    outcome = succeed(capsys, "bench", room, *options, "--against", sys.executable)
    figures = json.loads(file.read_text())
    against = figures["against"]
    stage = against["stages"]["segment"]
    assert (against["python"], against["rounds"]) == (sys.executable, 1)
    assert stage["this"] == figures["stages"]["segment"]
    assert set(stage["this"]) == set(stage["other"]) == FIGURES
    spent = [stage[name]["processor_median_ms"] for name in ("this", "other")]
    assert stage["processor_ratio"] == pytest.approx(spent[0] / spent[1], abs=0.001)
    assert f"{stage['processor_ratio']:.2f} of the other" in outcome.out
    assert "round 1 of 1: segment" in outcome.err


def test_the_ratio_is_the_median_of_the_rounds_and_none_where_one_build_lacks_the_stage() -> None:
    def run(**spent: float) -> dict[str, Any]:
        return {"stages": {stage: dict.fromkeys(FIGURES, ms) for stage, ms in spent.items()}}

    race = Race(Path(sys.executable), [])
    race.rounds = [
        {"this": run(segment=1, step=7), "other": run(segment=2)},
        {"this": run(segment=30, step=8), "other": run(segment=40)},  # the machine was slow
        {"this": run(segment=2, step=9), "other": run(segment=2)},
    ]
    stages = race.figures()["against"]["stages"]
    assert stages["segment"]["processor_ratios"] == [0.5, 0.75, 1.0]
    assert stages["segment"]["processor_ratio"] == stages["segment"]["wall_ratio"] == 0.75
    assert stages["segment"]["this"]["median_ms"] == stages["segment"]["other"]["p90_ms"] == 2
    assert stages["step"]["this"]["median_ms"] == 8
    assert stages["step"]["other"] is stages["step"]["processor_ratio"] is None


def test_each_build_is_first_in_every_other_round(monkeypatch: pytest.MonkeyPatch) -> None:
    race = Race(Path(sys.executable), [], n_rounds=3)
    ran: list[Build] = []
    monkeypatch.setattr(Build, "bench", lambda build, _: ran.append(build) or {"stages": {}})
    assert list(race) == [{}, {}, {}]
    this, other = race.builds["this"], race.builds["other"]
    assert ran == [this, other, other, this, this, other]


def test_a_stage_that_the_other_build_does_not_know(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    other = script(tmp_path, "echo 'curiosight: stage: expected segment, got map' >&2; exit 2")
    options = ("--frames", 1, "--stage", "segment", "--rounds", 1, "--against", other)
    assert "the other does not have it" in succeed(capsys, "bench", room, *options).out


def test_a_build_that_fails_is_told_in_one_line(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    other = script(tmp_path, "echo 'curiosight: no such option' >&2; exit 2")
    options = ("--frames", 1, "--stage", "segment", "--rounds", 1, "--against", other)
    line = refusal(capsys, "bench", room, *options)
    assert f"{other}: its bench ended with status 2 (no such option)" in line


def script(folder: Path, bench: str) -> Path:
    """Write what passes for an interpreter with a build, whose bench does as is said."""
    path = folder / "python"
    path.write_text(f'#!/bin/sh\ncase "$*" in *-m*) {bench};; esac\necho /x/__init__.py; echo 1\n')
    path.chmod(0o755)
    return path


def test_the_preset_is_that_of_the_settings(room: Path, capsys: Capsys) -> None:
    arguments = ("--frames", 1, "--stage", "segment", "--preset", "paper")
    shown = succeed(capsys, "bench", room, *arguments).out
    assert "preset        paper" in shown


def test_the_result_takes_the_place_of_an_older_one(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    file = tmp_path / "bench.json"
    file.write_text("old")
    succeed(capsys, "bench", room, "--frames", 1, "--stage", "segment", "--json", file)
    assert json.loads(file.read_text())["frames"] == 1


def test_bad_frames_are_not_timed(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 4)
    truncate(tmp_path / "room/depth/000000.png")
    file = tmp_path / "bench.json"
    succeed(capsys, "bench", tmp_path / "room", "--json", file)
    assert json.loads(file.read_text())["frames"] == 3


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--stage think", f"stage: expected {', '.join(STAGES)}, got 'think'"),
        ("--stage segment_memory --preset paper", "the paper's teacher has no memory"),
        ("--against nowhere/python", "nowhere/python: is no file"),
        ("--against .", "is a folder"),
        ("--against /bin/cat", "/bin/cat: has no curiosight"),
        (f"--against {sys.executable} --rounds 0", "rounds: expected 1 or more, got 0"),
        ("--json nowhere/bench.json", "nowhere: is not a folder"),
        ("--frames 0", "frames: expected 1 or more, got 0"),
        ("--preset best", "default or paper, got 'best'"),
    ],
)
def test_unusable_options(options: str, words: str, room: Path, capsys: Capsys) -> None:
    assert words in refusal(capsys, "bench", room, *options.split())


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_it_shows_what_is_timed(
    room: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, Timing, "_run", turn=3)  # the first turn is the warm-up
    outcome = call(capsys, "bench", room, "--stage", "segment")
    assert outcome.status == 130
    assert "stopped after 2 frames" in outcome.err
    assert "segment (ms)" in outcome.out


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_before_anything_is_timed(
    room: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, Timing, "_labels")
    outcome = call(capsys, "bench", room, "--stage", "learn")
    assert outcome.status == 130
    assert outcome.out == ""


def test_times_of_a_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "perf_counter", iter([1.0, 1.5, 2.0, 2.1]).__next__)
    monkeypatch.setattr(time, "process_time", iter([0.0, 0.2, 5.0, 5.1]).__next__)
    times = StageTimes()
    assert times.run(lambda: "result") == "result"
    times.run(lambda: None)
    monkeypatch.undo()
    assert times.summary() == {
        "median_ms": 300,
        "p90_ms": 460,
        "processor_median_ms": 150,
        "processor_p90_ms": 190,
    }


def test_opencv_is_left_with_the_threads_it_had() -> None:
    n_threads = cv2.getNumThreads()
    with one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == n_threads
