"""One writer of a folder at a time, and none that is no more."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from curiosight.errors import DataError
from curiosight.experiments import sole_writer as module
from curiosight.experiments.sole_writer import LOCK, sole_writer

HOLDER = """
import sys
from pathlib import Path
from curiosight.experiments.sole_writer import sole_writer
with sole_writer(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_second_writer_is_told_who_the_first_is(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    with sole_writer(folder):
        with (
            pytest.raises(DataError, match=f"by another command, process {os.getpid()} on "),
            sole_writer(folder),
        ):
            raise AssertionError("both write")
        assert (folder / LOCK).exists()  # the refused one leaves it to the first
    assert list(folder.iterdir()) == []
    with sole_writer(folder):
        pass


def test_killed_writer_stands_in_nobodys_way(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLDER, tmp_path]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(DataError, match=f"process {holder.pid} on "), sole_writer(tmp_path):
            pass
        holder.kill()
    assert (tmp_path / LOCK).exists()
    with sole_writer(tmp_path):
        assert f"process {os.getpid()} on" in (tmp_path / LOCK).read_text()


def test_lock_on_a_file_that_was_removed_meanwhile_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    locked = []
    lock = module._lock

    def lock_late(file: int) -> None:
        if not locked:
            (tmp_path / LOCK).unlink()  # by the writer before, who ends just now
        locked.append(file)
        lock(file)

    monkeypatch.setattr(module, "_lock", lock_late)
    with sole_writer(tmp_path):
        assert len(locked) == 2
        with pytest.raises(DataError, match="is being written"), sole_writer(tmp_path):
            pass


def test_file_system_without_locks_is_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_locks(file: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(module, "_lock", no_locks)
    with pytest.warns(UserWarning, match="cannot be locked"), sole_writer(tmp_path):
        pass


def test_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="cannot be written"), sole_writer(tmp_path / "file" / "a"):
        pass
