"""Which files of a folder a command wrote, so that the next one there can remove them first."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath

from curiosight.errors.files import writing

# These write a model and what is told of it: one after the other they would make a mixture.
OF_MODEL = frozenset(("explore", "learn", "demo", "watch", "ros", "continual"))


class Written:
    """The list of what a command has written to a folder, one JSON line a file.

    command: commands that write the same kind of result share a list; what another kind has
        written stays, such as the model beside the maps that were made by it.
    """

    def __init__(self, folder: Path, command: str) -> None:
        kind = "model" if command in OF_MODEL else command
        self.path = folder / f".curiosight-{kind}.list"
        self._folder = folder
        self._checksum_of: dict[str, int | None] = {}

    def remove_all(self, kept: Collection[str]) -> None:
        """Remove what an earlier command wrote, but names that are kept, and begin anew.

        What somebody changed since stays, too.
        """
        with writing(self._folder):
            for name, checksum in dict(self._lines()).items():
                if name not in kept:
                    _remove(self._folder, name, checksum)
            self.path.unlink(missing_ok=True)
        self._checksum_of.clear()
        for name in sorted(kept):
            self.note(name)

    def note(self, name: str, content: bytes | None = None) -> None:
        """Note a file before it is written; content: all of it, None = it is not known yet.

        One that is written again and again is noted twice, the second time without its content.
        """
        if self._checksum_of.get(name, 0) is None:
            return
        is_new = name not in self._checksum_of
        checksum = zlib.crc32(content) if is_new and content is not None else None
        self._checksum_of[name] = checksum
        with writing(self.path), self.path.open("ab", buffering=0) as file:
            file.write((json.dumps([name, checksum]) + "\n").encode())

    def _lines(self) -> Iterator[tuple[str, int | None]]:
        """Yield what is listed; a line that a kill cut short, or that names no place, is none."""
        try:
            lines = self.path.read_bytes().splitlines()
        except OSError:
            return
        for line in lines:
            with suppress(ValueError, TypeError):
                name, checksum = json.loads(line)
                path = PurePosixPath(name)
                if path.parts and not path.is_absolute() and ".." not in path.parts:
                    yield str(name), checksum


def _remove(folder: Path, name: str, checksum: int | None) -> None:
    path = folder / name
    if checksum is not None and _is_changed(path, checksum):
        return
    with suppress(IsADirectoryError):
        path.unlink(missing_ok=True)
    with suppress(OSError):  # it holds other files
        for parent in path.relative_to(folder).parents[:-1]:
            os.rmdir(folder / parent)


def _is_changed(path: Path, checksum: int) -> bool:
    try:
        return path.is_file() and zlib.crc32(path.read_bytes()) != checksum
    except OSError:
        return True
