"""Read a zip that may have been made to do harm: bounded sizes, and nothing outside of it."""

from __future__ import annotations

import posixpath
import struct
import zipfile
import zlib
from pathlib import Path
from types import TracebackType
from typing import Self

from curiosight.errors import DataError

MAX_MEMBER_BYTES = 64 * 2**20
MAX_MEMBERS = 100_000
# bz2 and lzma unpack without a bound on memory, and no furniture is packed that way.
COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
ENCRYPTED = 0x1
# What zipfile and zlib raise on bytes that are not what they claim to be.
DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    ValueError,
    KeyError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    MemoryError,
    OSError,
)


class UntrustedZip:
    """An open zip whose members are found by name; use as a context manager.

    path: the file; `remedy` is what a `DataError` about it advises.
    """

    def __init__(self, path: Path, remedy: str) -> None:
        self.path = path
        self.remedy = remedy
        try:
            self._zip = zipfile.ZipFile(path)
        except DAMAGE as error:
            reason = error.strerror if isinstance(error, OSError) else None
            found = f"cannot be read ({reason})" if reason else "not a zip file, or a damaged one"
            raise DataError(path, found, remedy) from error
        members = self._zip.infolist()
        if len(members) > MAX_MEMBERS:
            self._zip.close()
            raise DataError(path, f"holds {len(members)} files", remedy)
        self._members = {normalised(member.filename): member for member in members}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._zip.close()

    def __contains__(self, name: str) -> bool:
        return normalised(name) in self._members

    def size(self, name: str) -> int:
        """Return the bytes that a member says it unpacks to."""
        return self._members[normalised(name)].file_size

    def read(self, name: str) -> bytes:
        """Return a member's content; raises `DataError` where it is missing, large or damaged."""
        member = self._members.get(normalised(name))
        if member is None:
            raise DataError(self.path, f"{name} is missing in it", self.remedy)
        if member.file_size > MAX_MEMBER_BYTES:
            found = f"{name} in it unpacks to {member.file_size / 2**20:.0f} MB"
            raise DataError(self.path, found, self.remedy)
        if member.compress_type not in COMPRESSIONS or member.flag_bits & ENCRYPTED:
            raise DataError(self.path, f"{name} in it is packed in an unusual way", self.remedy)
        try:
            with self._zip.open(member) as file:
                # Asked for so many bytes it unpacks no more, whatever it says of its size.
                content = file.read(member.file_size + 1)
        except DAMAGE as error:
            raise DataError(self.path, f"{name} in it is damaged", self.remedy) from error
        if len(content) != member.file_size:
            raise DataError(self.path, f"{name} in it is damaged", self.remedy)
        return content


def normalised(name: str) -> str:
    """Return a member's name without leading slashes, dots and backslashes.

    A name that leads upwards keeps its dots, and so names no member of a sound zip.
    """
    return posixpath.normpath(name.replace("\\", "/")).lstrip("/")
