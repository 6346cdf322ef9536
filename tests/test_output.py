"""The output folder: made late, never over other people's files, no half files."""

from __future__ import annotations

import errno
import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import files
from curiosight.errors import DataError
from curiosight.experiments.output import OutputFolder, TableFile, read_cell, written_cell
from curiosight.experiments.sole_writer import LOCK, letting_go


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "recording"
    path.mkdir()
    return path


@pytest.fixture
def tiny_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 64 kB; skipped where it cannot be mounted."""
    path = tmp_path / "disk"
    path.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(path)]
    if os.getuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount a file system")
    yield path
    subprocess.run(["umount", str(path)], check=True)


def test_folder_is_made_with_its_first_file(tmp_path: Path, source: Path) -> None:
    folder = OutputFolder(tmp_path / "a/b", "explore", source)
    assert not folder.path.exists()
    folder.write_text("notes/hello.txt", "hello")
    assert files(tmp_path / "a/b") == {"notes/hello.txt"}


def test_folder_of_its_own_is_not_shared(
    tmp_path: Path, source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = OutputFolder(None, "explore", source)
    folder.path.mkdir(parents=True)  # another run that started in the same second
    folder.write_text("hello.txt", "hello")
    assert files(folder.path) == {"hello.txt"}
    assert folder.path.name.endswith("-2")


def test_existing_folder_is_taken_only_if_empty(tmp_path: Path, source: Path) -> None:
    (source / "a.png").touch()
    with pytest.raises(DataError, match="exists and is not empty"):
        OutputFolder(source, "explore", tmp_path / "elsewhere")
    OutputFolder(source, "explore", tmp_path / "elsewhere", overwrite=True)
    for inside in (source, source / "rgb", source / "new"):
        with pytest.raises(DataError, match="lies inside the recording"):
            OutputFolder(inside, "explore", source, overwrite=True)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_images_are_written_as_they_are(
    dtype: type[np.generic], tmp_path: Path, source: Path
) -> None:
    folder = OutputFolder(tmp_path / "out", "segment", source)
    image = np.arange(12).reshape(3, 4).astype(dtype)
    folder.write_image("a.png", image)
    read = cv2.imread(str(tmp_path / "out/a.png"), cv2.IMREAD_UNCHANGED)
    assert read.dtype == dtype
    np.testing.assert_array_equal(read, image)


def test_colour_images_are_red_first(tmp_path: Path, source: Path) -> None:
    folder = OutputFolder(tmp_path / "out", "segment", source)
    folder.write_image("a.png", np.full((2, 2, 3), (255, 0, 0), np.uint8))
    assert cv2.imread(str(tmp_path / "out/a.png"))[0, 0].tolist() == [0, 0, 255]


def test_json_without_numbers_is_refused(tmp_path: Path, source: Path) -> None:
    folder = OutputFolder(tmp_path / "out", "evaluate", source)
    with pytest.raises(ValueError, match="JSON"):
        folder.write_json("a.json", {"error": float("nan")})
    folder.write_json("b.json", {"error": None})
    assert json.loads((tmp_path / "out/b.json").read_text()) == {"error": None}


def test_failed_write_keeps_the_file_that_was_there(
    tmp_path: Path, source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = OutputFolder(tmp_path / "out", "explore", source)
    folder.write_text("a.txt", "old")

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(DataError, match=r"No space left on device.*free some space"):
        folder.write_text("a.txt", "new")
    assert files(tmp_path / "out") == {"a.txt"}
    assert (tmp_path / "out/a.txt").read_text() == "old"


def test_table_can_be_read_after_every_row(tmp_path: Path) -> None:
    table = TableFile(tmp_path / "a.csv", ["step", "id", "error"])
    table.add({"step": 0, "id": "a,b", "error": None})
    assert (tmp_path / "a.csv").read_text() == 'step,id,error\n0,"a,b",\n'
    table.add({"error": 0.5, "step": 1, "id": "c"})
    table.close()
    assert (tmp_path / "a.csv").read_text().splitlines()[2] == "1,c,0.500000"


def fill(table: TableFile) -> None:
    while True:
        table.add({"text": "x" * 99})


def test_full_disk_leaves_only_whole_files_and_rows(tiny_disk: Path, source: Path) -> None:
    folder = OutputFolder(tiny_disk / "out", "explore", source)
    table = TableFile(folder.file("a.csv"), ["text"])
    with pytest.raises(DataError, match=r"No space left on device.*free some space"):
        folder.write_text("large.txt", "x" * 100_000)
    assert files(tiny_disk) == {"out/a.csv"}
    with pytest.raises(DataError, match="No space left on device"):
        fill(table)
    table.close()
    lines = (tiny_disk / "out/a.csv").read_text().split("\n")
    assert lines[-1] == ""
    assert set(lines[1:-1]) == {"x" * 99}


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("000001", "000001"),
        ("seq-01/frame", "seq-01/frame"),
        ("-12", "-12"),
        ("=cmd()", "'=cmd()"),
        ("+1+cmd()", "'+1+cmd()"),
        ("-1+cmd()", "'-1+cmd()"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("'quoted", "''quoted"),
    ],
)
def test_texts_in_a_table_are_no_formulas_and_come_back(text: str, cell: str) -> None:
    assert written_cell(text) == cell
    assert read_cell(cell) == text


def test_a_row_is_a_line_whatever_a_name_holds(tmp_path: Path) -> None:
    table = TableFile(tmp_path / "one.csv", ["id", "error"])
    table.add({"id": "=a\n\x1b[31m\t\udcff, b", "error": -0.5})
    table.close()
    assert (tmp_path / "one.csv").read_text() == (
        'id,error\n"\'=a\\n\\x1b[31m\\t\\udcff, b",-0.500000\n'
    )


def test_results_of_an_earlier_command_are_removed_first(tmp_path: Path, source: Path) -> None:
    out = tmp_path / "out"
    first = OutputFolder(out, "segment", source)
    for name in ("a", "b", "c"):
        first.write_text(f"labels/{name}.txt", name)
    first.write_json("old/summary.json", {})
    for _ in range(3):
        first.write_text("again.txt", "again")
    OutputFolder(out, "explore", source, overwrite=True).write_text("model.npz", "a model")
    (out / "mine.txt").write_text("mine")
    (out / "labels/c.txt").write_text("corrected by hand")
    second = OutputFolder(out, "segment", source, overwrite=True)
    assert "labels/a.txt" in files(out), "a command that is refused removes nothing"
    second.write_text("labels/b.txt", "new")
    assert files(out) == {"labels/b.txt", "labels/c.txt", "mine.txt", "model.npz"}
    assert not (out / "old").exists()
    assert (out / "labels/b.txt").read_text() == "new"


def test_learn_removes_what_explore_wrote_but_what_is_kept(tmp_path: Path, source: Path) -> None:
    out = tmp_path / "out"
    first = OutputFolder(out, "explore", source)
    for name in ("model.npz", "steps.csv"):
        first.file(name).write_text("of explore")
    second = OutputFolder(out, "learn", source, overwrite=True)
    second.keep("model.npz")
    second.write_text("config.toml", "")
    assert files(out) == {"model.npz", "config.toml"}
    OutputFolder(out, "demo", source, overwrite=True).write_text("report.html", "")
    assert files(out) == {"report.html"}


def test_list_of_files_names_nothing_outside_its_folder(tmp_path: Path, source: Path) -> None:
    out, outside = tmp_path / "out", tmp_path / "precious.txt"
    outside.write_text("precious")
    OutputFolder(out, "map", source).write_text("one.txt", "one")
    (list_of_files,) = out.glob(".curiosight-*.list")
    with list_of_files.open("a") as file:
        for name in ("../precious.txt", str(outside), ".", "", 7, None):
            file.write(json.dumps([name, None]) + "\n")
        file.write('["cut short')
    OutputFolder(out, "map", source, overwrite=True).write_text("two.txt", "two")
    assert outside.read_text() == "precious"
    assert files(out) == {"two.txt"}


def test_folder_is_one_commands_alone_until_it_ends(tmp_path: Path, source: Path) -> None:
    out = tmp_path / "out"
    one, other = (OutputFolder(out, "learn", source) for _ in range(2))
    with letting_go():
        one.write_text("config.toml", "one")
        with pytest.raises(DataError, match="is being written by another command, process"):
            other.write_text("config.toml", "other")
    assert not (out / LOCK).exists()
    with letting_go(), pytest.raises(DataError, match="exists and is not empty"):
        other.write_text("config.toml", "other")
    assert (out / "config.toml").read_text() == "one"


def test_lock_that_a_kill_left_stands_in_nobodys_way(tmp_path: Path, source: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / LOCK).write_text("process 1 on nowhere")
    with letting_go():
        OutputFolder(tmp_path / "out", "learn", source).write_text("config.toml", "")
    assert not (tmp_path / "out" / LOCK).exists()


def test_missing_rights_are_told_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def refuse(dir: Path) -> None:
        asked.append(dir)
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    with monkeypatch.context() as patch:
        patch.setattr("curiosight.errors.files.TemporaryFile", refuse)
        with pytest.raises(DataError, match=r"deep/run: cannot be written \(Permission denied\)"):
            OutputFolder(tmp_path / "deep" / "run", "explore", None)
    assert asked == [tmp_path]
    (tmp_path / "file").write_text("a user's")
    with pytest.raises(DataError, match=r"run: cannot be written \(Not a directory\)"):
        OutputFolder(tmp_path / "file" / "run", "explore", None)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
