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

    remedy: what a `DataError` about it advises. max_bytes: that it may unpack to, all in all.
    """

    def __init__(self, path: Path, remedy: str, max_bytes: int) -> None:
        self.path = path
        self._remedy = remedy
        self._bytes_left = max_bytes
        if not path.is_file():  # a pipe would be waited for
            found = "not a file" if path.exists() else "missing"
            raise DataError(path, found, remedy)
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

    def read(self, name: str) -> bytes:
        """Return a member's content; raises `DataError` where it is missing, large or damaged."""
        member = self._members.get(normalised(name))
        if member is None:
            raise self._error(f"{name} is missing in it")
        if member.file_size > min(MAX_MEMBER_BYTES, self._bytes_left):
            raise self._error(f"{name} in it unpacks to {member.file_size / 2**20:.0f} MB")
        if member.compress_type not in COMPRESSIONS or member.flag_bits & ENCRYPTED:
            raise self._error(f"{name} in it is packed in an unusual way")
        try:
            with self._zip.open(member) as file:
                # Asked for so many bytes it unpacks no more, whatever it says of its size.
                content = file.read(member.file_size + 1)
        except DAMAGE as error:
            raise self._error(f"{name} in it is damaged") from error
        if len(content) != member.file_size:
            raise self._error(f"{name} in it is damaged")
        self._bytes_left -= len(content)
        return content

    def _error(self, found: str) -> DataError:
        return DataError(self.path, found, self._remedy)


def normalised(name: str) -> str:
    """Return a member's name without leading slashes, dots and backslashes.

    A name that leads upwards keeps its dots, and so names no member of a sound zip.
    """
    return posixpath.normpath(name.replace("\\", "/")).lstrip("/")
