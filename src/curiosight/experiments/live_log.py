"""The log of a watch: never over a user's file without being told to, never into a recording."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import IO

from curiosight.errors import DataError
from curiosight.errors.files import try_to_write_in, writing
from curiosight.robot.sinks.mcap_log import McapLog


def live_log(path: Path, source: Path, *, overwrite: bool = False) -> McapLog:
    """Return the log that is to be written; its file is made when it begins.

    Raises `DataError` where there is such a file and it is not to be overwritten, where it would
    lie in the source or cannot be written, or where mcap is not installed.
    """
    _require_mcap(path)
    with writing(path):
        if path.resolve().is_relative_to(source.resolve()):
            found = "lies inside the recording, which stays as it is"
            raise DataError(path, found, "choose an --mcap elsewhere")
        if path.is_dir():
            raise DataError(path, "is a folder", "name a file")
        if path.exists() and not overwrite:
            raise _exists(path)
        _try_to_write(path)
    return McapLog(str(path), partial(_open, path, overwrite=overwrite))


def _try_to_write(path: Path) -> None:
    """Raise `OSError` where a file cannot be written; leave all as it is.

    Told before a watch begins: later it could only go on without its log.
    """
    if path.exists():
        path.open("ab").close()
        return
    try_to_write_in(path.parent)


def _open(path: Path, *, overwrite: bool) -> IO[bytes]:
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            return path.open("wb" if overwrite else "xb")
        except FileExistsError:
            raise _exists(path) from None


def _require_mcap(path: Path) -> None:
    try:
        import mcap.writer  # noqa: F401
    except ImportError:
        found = "cannot be written without mcap, which is missing"
        raise DataError(path, found, "pip install 'curiosight[mcap]'") from None


def _exists(path: Path) -> DataError:
    return DataError(path, "exists", "choose another --mcap, or add --overwrite")
