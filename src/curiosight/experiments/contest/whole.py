"""Folders that are there whole or not at all, however the process that writes them ends."""

from __future__ import annotations

import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from curiosight.errors.files import writing

PARTIAL = ".partial"


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to write into that takes its name once it is whole.

    Its name until then is nobody else's: of two that write the same, one is kept. Raises
    `DataError` where it cannot be written.
    """
    draft = folder.with_name(f".{folder.name}.{uuid.uuid4().hex}{PARTIAL}")
    try:
        with writing(folder):
            draft.mkdir(parents=True)
        yield draft
        with writing(folder):
            _name(draft, folder)
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _name(draft: Path, folder: Path) -> None:
    try:
        draft.rename(folder)
    except OSError:
        if not folder.exists():
            raise


def remove_partial(folder: Path) -> None:
    """Remove what a process that was killed left half-written in a folder."""
    for path in folder.glob(f".*{PARTIAL}"):
        with suppress(OSError):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
