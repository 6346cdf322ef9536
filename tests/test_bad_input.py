"""What cannot be used is refused in one line that says what, where, and what to do."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import files, refusal, succeed
from recordings import (
    truncate,
    write_camera_file,
    write_folder,
    write_image,
)
from room import kinect

Capsys = pytest.CaptureFixture[str]
TEACHING = ("explore", "segment", "learn")  # the commands that need depth


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A recording to spoil."""
    write_folder(tmp_path / "room", 4)
    return tmp_path / "room"


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def refused(capsys: Capsys, out: Path, *arguments: str | Path | int) -> str:
    """Return the line that refuses a command; nothing may have been written."""
    line = refusal(capsys, *arguments, "--out", out)
    assert not out.exists()
    return line


# Unusable sources


@pytest.mark.parametrize("command", TEACHING)
def test_wrong_path(command: str, out: Path, tmp_path: Path, capsys: Capsys) -> None:
    line = refused(capsys, out, command, tmp_path / "nowhere")
    assert line == f"curiosight: {tmp_path}/nowhere: does not exist; check the path"


@pytest.mark.parametrize("command", TEACHING)
def test_empty_folder(command: str, out: Path, tmp_path: Path, capsys: Capsys) -> None:
    (tmp_path / "empty").mkdir()
    assert "is an empty folder" in refused(capsys, out, command, tmp_path / "empty")


@pytest.mark.parametrize("command", TEACHING)
def test_file_instead_of_a_folder(command: str, out: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_image(tmp_path / "photo.png", np.zeros((20, 20, 3), np.uint8))
    line = refused(capsys, out, command, tmp_path / "photo.png")
    assert "give the folder of a recording" in line


@pytest.mark.parametrize("command", [*TEACHING, "evaluate --folds 2"])
def test_holiday_pictures(command: str, out: Path, tmp_path: Path, capsys: Capsys) -> None:
    for name in ("beach", "mountain", "party"):
        write_image(tmp_path / f"photos/{name}.jpg", np.full((60, 80, 3), 99, np.uint8))
    line = refused(capsys, out, *command.split(), tmp_path / "photos")
    assert "has no depth to learn from" in line
    assert "`curiosight map`" in line


def test_holiday_pictures_to_evaluate_on(
    model: Path, out: Path, tmp_path: Path, capsys: Capsys
) -> None:
    write_image(tmp_path / "photos/beach.jpg", np.full((60, 80, 3), 99, np.uint8))
    line = refused(capsys, out, "evaluate", model, tmp_path / "photos")
    assert "give --ground-truth" in line


def test_intrinsics_of_another_size(source: Path, out: Path, capsys: Capsys) -> None:
    write_camera_file(source, kinect(320, 120))
    assert "for 320x120 images, but the images are 160x120" in refused(capsys, out, "learn", source)


def test_eight_bit_depth(source: Path, out: Path, capsys: Capsys) -> None:
    for path in (source / "depth").iterdir():
        write_image(path, np.full((120, 160), 90, np.uint8))
    assert "16-bit PNG" in refused(capsys, out, "explore", source)


@pytest.mark.parametrize("command", [*TEACHING, "evaluate --folds 2"])
def test_all_frames_bad(command: str, source: Path, out: Path, capsys: Capsys) -> None:
    for path in (source / "depth").iterdir():
        truncate(path)
    line = refused(capsys, out, *command.split(), source)
    assert "none of its 4 frames can be used (000000.png is truncated)" in line


# Unusable arguments


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--strategy iak", "package.module:Class, got 'iak'; did you mean iac?"),
        ("--scene kitchen", "'kitchen'"),
        ("--preset best", "default or paper, got 'best'"),
        ("--regions rooms", "got 'rooms', which is no file either"),
        ("--regions time:0", "expected time:1 to time:8"),
        ("--regions time:9", "expected time:1 to time:8"),
        ("--steps 0", "n_steps: expected 1 or more, got 0"),
        ("--steps many", "--steps"),
        ("--seed -1", "seed: expected 0 or more, got -1"),
        ("--threads 0", "n_threads: expected 1 or more, got 0"),
        ("--test-every -1", "every: expected 0 or more, got -1"),
        ("--test-every 3 --gap 3", "expected more than 7"),
        ("--test-every 3 --gap -1", "gap: expected 0 or more, got -1"),
        ("--test-every 3 --test nowhere", "expected --test or --test-every, got both"),
        ("--test nowhere", "nowhere: does not exist"),
        ("--ground-truth nowhere --test-every 8", "nowhere: is not a folder"),
        ("--ground-truth anywhere", "anywhere: is not a folder"),
        ("--from nowhere", "nowhere: does not exist"),
        ("--config nowhere.toml", "nowhere.toml: cannot be read"),
    ],
)
def test_unusable_options_of_explore(
    options: str, words: str, room: Path, out: Path, capsys: Capsys
) -> None:
    assert words in refused(capsys, out, "explore", room, *options.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("segment ROOM --every 0", "every: expected 1 or more, got 0"),
        ("evaluate ROOM", "expected RUN SOURCE, or SOURCE with --folds"),
        ("evaluate MODEL ROOM ROOM", "expected RUN SOURCE, or SOURCE with --folds"),
        ("evaluate MODEL ROOM --folds 2", "expected only SOURCE with --folds"),
        ("evaluate ROOM --folds 1", "got 1"),
        ("evaluate ROOM --folds 1000", "got 1000"),
        ("evaluate ROOM --folds 2 --split rooms", "frames or blocks, got 'rooms'"),
        ("evaluate ROOM --folds 8 --split blocks --config GAP", "gap: expected less"),
    ],
)
def test_unusable_arguments_of_other_commands(
    arguments: str, words: str, room: Path, model: Path, out: Path, tmp_path: Path, capsys: Capsys
) -> None:
    (tmp_path / "gap.toml").write_text("[test]\ngap = 8")
    names = {"ROOM": room, "MODEL": model, "GAP": tmp_path / "gap.toml"}
    words_of_command = [names.get(word, word) for word in arguments.split()]
    assert words in refused(capsys, out, *words_of_command)


def test_pose_regions_without_poses(out: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 4, with_poses=False)
    line = refused(capsys, out, "explore", tmp_path / "room", "--regions", "pose")
    assert "expected poses for `pose`, got none; use time:5" in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[explorer]\nn_stepps = 5", "unknown key `explorer.n_stepps`; did you mean"),
        ("[explorers]\nn_steps = 5", "unknown key `explorers`; did you mean `explorer`?"),
        ("[segmentation.table]\nmin_sice = 5", "unknown key `segmentation.table.min_sice`"),
        ("[segmentation.table]\nmin_size = -1", "[segmentation.table] min_size: expected"),
        ("explorer = 5", "write a section [explorer]"),
        ('[explorer]\nn_steps = "five"', "`explorer.n_steps` is 'five'; expected int"),
        ("[explorer]\nn_steps = true", "`explorer.n_steps` is True; expected int"),
        ("[explorer]\nn_steps = 0", "n_steps: expected 1 or more, got 0"),
        ('[forest]\nvote = "loud"', "`forest.vote` is 'loud'; use one of 'hard', 'soft'"),
        ("[forest]\nn_regrown = 31", "n_regrown: expected 1 to 30, got 31"),
        ("[explorer]\nn_stay = 0", "n_stay"),
        ('preset = "best"', "best"),
        ("[explorer", "is no TOML"),
        ("[run]\nseed = " + 5000 * "9", "mine.toml: is no TOML (Exceeds the limit"),
        ("[run]\nseed = 0x" + 5000 * "f", "`run.seed` is 0xfff"),
        ("[run]\nmemory_mb = " + 400 * "9", "expected a number of 64 bits"),
        ("[reading]\ndepth_scale = " + 400 * "9", "expected a number of 64 bits"),
        ("[run]\nmemory_mb = 10000001", "memory_mb: expected 1 to 10000000, got 10000001"),
        ("[run]\nn_threads = 1025", "n_threads: expected 1 to 1024, got 1025"),
        ("[test]\nevery = 1000000001", "every: expected 0 to 1000000000, got 1000000001"),
        ("[forest]\nn_trees = 1001", "n_trees: expected 1 to 1000, got 1001"),
        ("[forest]\nmax_depth = 1001", "max_depth: expected 0 to 1000, got 1001"),
        ("[learner]\nn_superpixels = 19201", "n_superpixels: expected 1 to 19200, got 19201"),
        ("[learner]\nn_pixels = 100001", "n_pixels: expected 1 to 100000, got 100001"),
        ("[learner]\nthreshold = nan", "threshold: expected 0 to below 1, got nan"),
        ("[explorer]\nn_warm_up = 10001", "n_warm_up: expected 0 to 10000, got 10001"),
        ("[explorer]\nexponent = inf", "exponent: expected 0 to 100, got inf"),
        ("[explorer]\ntheta = 100001", "theta: expected 2 to 100000, got 100001"),
        ("[segmentation]\nmax_range = 1e7", "max_range: expected no more than 1e+06"),
    ],
)
def test_unusable_config(
    text: str, words: str, room: Path, out: Path, tmp_path: Path, capsys: Capsys
) -> None:
    (tmp_path / "mine.toml").write_text(text)
    assert words in refused(capsys, out, "explore", room, "--config", tmp_path / "mine.toml")


def test_settings_nested_too_deeply(
    room: Path, out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    def give_up(text: str) -> None:
        raise RecursionError("maximum recursion depth exceeded")

    monkeypatch.setattr("curiosight.config.toml.tomllib.loads", give_up)
    (tmp_path / "deep.toml").write_text("")
    line = refused(capsys, out, "explore", room, "--config", tmp_path / "deep.toml")
    assert "deep.toml: is nested too deeply" in line


# Model files that are none


def write_text(path: Path) -> None:
    path.write_text("hello")


def write_other_archive(path: Path) -> None:
    with path.open("wb") as file:
        np.savez(file, weights=np.zeros(3))


def write_picture(path: Path) -> None:
    write_image(path.with_suffix(".png"), np.zeros((9, 9, 3), np.uint8))
    path.with_suffix(".png").rename(path)


@pytest.mark.parametrize("write", [write_text, write_other_archive, write_picture, Path.mkdir])
@pytest.mark.parametrize("command", ["map", "evaluate", "explore --from"])
def test_model_file_that_is_not_one(
    write: Callable[[Path], Any],
    command: str,
    room: Path,
    out: Path,
    tmp_path: Path,
    capsys: Capsys,
) -> None:
    path = tmp_path / "model.npz"
    write(path)
    name, *option = command.split()
    arguments = [room, *option, path] if option else [path, room]
    assert "model.npz" in refused(capsys, out, name, *arguments)


def test_truncated_model(
    model: Path, room: Path, out: Path, tmp_path: Path, capsys: Capsys
) -> None:
    shutil.copytree(model, tmp_path / "run")
    truncate(tmp_path / "run/model.npz")
    assert "run/model.npz: not a curiosight file" in refused(
        capsys, out, "map", tmp_path / "run", room
    )


# Output folders that cannot be used


@pytest.mark.parametrize("command", ["segment", "explore", "learn", "evaluate --folds 2", "map"])
def test_output_folder_in_use(
    command: str, room: Path, model: Path, out: Path, capsys: Capsys
) -> None:
    out.mkdir()
    (out / "thesis.txt").write_text("three years of work")
    arguments = [*command.split(), *([model] if command == "map" else []), room]
    line = refusal(capsys, *arguments, "--out", out)
    assert line == (
        f"curiosight: {out}: exists and is not empty; choose another --out, or add --overwrite"
    )
    assert files(out) == {"thesis.txt"}


def test_overwrite_keeps_other_files(room: Path, out: Path, capsys: Capsys) -> None:
    out.mkdir()
    (out / "thesis.txt").write_text("three years of work")
    succeed(capsys, "learn", room, "--out", out, "--overwrite")
    assert (out / "thesis.txt").read_text() == "three years of work"
    assert (out / "model.npz").is_file()


@pytest.mark.parametrize("folder", [".", "rgb", "depth", "ground_truth"])
def test_recording_is_never_overwritten(
    folder: str, model: Path, source: Path, capsys: Capsys
) -> None:
    before = {path: path.read_bytes() for path in source.rglob("*") if path.is_file()}
    line = refusal(capsys, "map", model, source, "--out", source / folder, "--overwrite")
    assert "lies inside the recording" in line
    assert before == {path: path.read_bytes() for path in source.rglob("*") if path.is_file()}


def test_output_folder_that_is_a_file(room: Path, out: Path, capsys: Capsys) -> None:
    out.write_text("a file")
    assert "is a file; choose a folder" in refusal(capsys, "learn", room, "--out", out)
    assert "cannot be written" in refusal(capsys, "learn", room, "--out", out / "inside")
    assert out.read_text() == "a file"


def test_output_folder_that_is_not_writable(
    room: Path, out: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setattr(Path, "mkdir", raising(errno.EACCES))
    line = refused(capsys, out, "explore", room)
    assert "cannot be written (Permission denied)" in line


@pytest.mark.parametrize("command", ["explore", "segment", "learn", "evaluate --folds 2"])
def test_disk_full(
    command: str, room: Path, out: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setattr(os, "replace", raising(errno.ENOSPC))
    line = refusal(capsys, *command.split(), room, "--out", out)
    assert str(out) in line
    assert "free some space" in line
    assert files(out) == set(), "half a file is left"


def test_file_that_the_system_refuses(monkeypatch: pytest.MonkeyPatch, capsys: Capsys) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", "/secret")

    monkeypatch.setattr("curiosight.cli.info.open_source", fail)
    line = refusal(capsys, "info", "/secret")
    assert line == "curiosight: /secret: Permission denied; check path and rights"


def raising(number: int) -> Callable[..., Any]:
    """Return a function that fails as the system does."""

    def fail(*_: Any, **__: Any) -> None:
        raise OSError(number, {errno.EACCES: "Permission denied"}.get(number, "No space left"))

    return fail
