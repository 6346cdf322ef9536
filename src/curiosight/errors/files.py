"""Write files completely or not at all, and say in a line why one cannot be written."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from curiosight.errors import DataError


def replace_file(path: Path, content: bytes, *, is_synced: bool = False) -> None:
    """Write a file, completely or not at all; one that is there stays until the new one is.

    is_synced: wait until it is on the disk, for what must survive a power cut.
    Raises `DataError` where it cannot be written.
    """
    # Beside the target: os.replace is atomic only within one file system.
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    with writing(path):
        try:
            with partial.open("wb") as file:
                file.write(content)
                if is_synced:
                    file.flush()
                    os.fsync(file.fileno())
            os.replace(partial, path)
            if is_synced:
                _sync_folder(path.parent)
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    """Wait until a folder's new names are on the disk; not every system can tell."""
    with suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def try_to_write_in(folder: Path) -> None:
    """Raise `OSError` where no file can be made in a folder; it need not exist, and is not made.

    Told before the work: later it would be for nothing.
    """
    nearest = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    with TemporaryFile(dir=nearest):
        pass


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn what the system says against writing into a `DataError`."""
    try:
        yield
    except OSError as error:
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        remedy = "free some space" if is_full else "check the folder and its rights"
        raise DataError(path, f"cannot be written ({error.strerror})", remedy) from error
