"""Bytes to walk through: those of a file, or of a chunk of it that was decompressed."""

from __future__ import annotations

import bz2
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

from curiosight.datasets.bags.messages import Messages
from curiosight.datasets.decoding import UnreadableFile

N_CHUNKS_KEPT = 2  # colour's and depth's


class Source(Protocol):
    """Bytes that are asked for by their place."""

    size: int

    def read(self, offset: int, n_bytes: int) -> bytes:
        """Return so many bytes, fewer at the end."""
        ...


class FileSource:
    """The bytes of a file; a context manager."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("rb", buffering=0)
        self.size = self._file.seek(0, 2)

    def read(self, offset: int, n_bytes: int) -> bytes:
        """Return so many bytes, fewer at the end."""
        self._file.seek(offset)
        parts = []
        # The system hands out 2 GB at once at most.
        while n_bytes > 0 and (part := self._file.read(n_bytes)):
            parts.append(part)
            n_bytes -= len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()


class BytesSource:
    """Bytes in memory."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self.size = len(content)

    def read(self, offset: int, n_bytes: int) -> bytes:
        """Return so many bytes, fewer at the end."""
        return self._content[offset : offset + n_bytes]


class BagFile(ABC):
    """One file of a bag: where its messages lie, and their bytes.

    n_announced: messages that the file itself says it holds, None if it does not say.
    faults: what is wrong with it, in words, such as "it is cut short".
    are_zstd: every message is compressed by itself.
    """

    def __init__(self, path: Path, *, are_zstd: bool = False) -> None:
        self.path = path
        self.are_zstd = are_zstd
        self.topics: dict[tuple[str, str], Messages] = {}
        self.n_announced: int | None = None
        self.faults: list[str] = []

    @abstractmethod
    def read(self, messages: Messages, number: int) -> bytes:
        """Return the bytes of a message; raises `UnreadableFile`."""

    @abstractmethod
    def contents(self, messages: Messages) -> Iterator[tuple[int, bytes]]:
        """Yield the number and bytes of each message that can be read, opening it once."""


class ChunkedFile(BagFile):
    """A file of records, some of them in compressed chunks; scanned by those that build on it.

    It keeps no file open, so it can be pickled and read by any thread or process.
    """

    def __init__(self, path: Path, *, are_zstd: bool = False) -> None:
        super().__init__(path, are_zstd=are_zstd)
        self._chunks: list[tuple[int, int, str]] = []
        self._kept: tuple[tuple[int, bytes], ...] = ()

    def read(self, messages: Messages, number: int) -> bytes:
        try:
            with FileSource(self.path) as source:
                content = self._content(messages, number, source)
        except OSError as error:
            raise UnreadableFile(f"{self.path.name} cannot be read ({error.strerror})") from error
        if len(content) < messages.lengths[number]:
            raise UnreadableFile(f"{self.path.name} breaks off inside a message")
        return unpacked(content, "zstd") if self.are_zstd else content

    def contents(self, messages: Messages) -> Iterator[tuple[int, bytes]]:
        with FileSource(self.path) as source:
            for number, length in enumerate(messages.lengths):
                with suppress(OSError, UnreadableFile):
                    content = self._content(messages, number, source)
                    if len(content) == length:
                        yield number, unpacked(content, "zstd") if self.are_zstd else content

    def add(
        self,
        messages: Messages,
        source: Source,
        place: tuple[int, int, int],
        logged_ns: int,
        head: bytes,
    ) -> None:
        """Add a message of a source. place: chunk, offset, length. head: its first bytes."""
        if self.are_zstd and messages.is_stamped:
            try:
                head = unpacked(source.read(place[1], place[2]), "zstd")
            except UnreadableFile:
                head = b""
        messages.add(*place, logged_ns, head)

    def new_chunk(self, offset: int, length: int, compression: str, source: Source) -> BytesSource:
        """Note a compressed chunk, and return as much of its content as there is."""
        self._chunks.append((offset, length, compression))
        try:
            content = unpacked(source.read(offset, length), compression)
        except UnreadableFile as fault:
            self.faults.append(str(fault))
            content = b""
        self._keep(len(self._chunks) - 1, content)
        return BytesSource(content)

    def _content(self, messages: Messages, number: int, source: FileSource) -> bytes:
        chunk, offset = messages.chunks[number], messages.offsets[number]
        length = messages.lengths[number]
        if chunk < 0:
            return source.read(offset, length)
        return self._chunk(chunk, source)[offset : offset + length]

    def _chunk(self, number: int, source: FileSource) -> bytes:
        for known, content in self._kept:
            if known == number:
                return content
        offset, length, compression = self._chunks[number]
        content = unpacked(source.read(offset, length), compression)
        self._keep(number, content)
        return content

    def _keep(self, number: int, content: bytes) -> None:
        # Replaced as a whole: another thread sees the old or the new one.
        self._kept = (*self._kept[1 - N_CHUNKS_KEPT :], (number, content))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_kept": ()}


def unpacked(content: bytes, compression: str) -> bytes:
    """Decompress as much as there is of it; raises `UnreadableFile` where it is damaged."""
    if compression in ("", "none"):
        return content
    decompressor = _decompressor(compression)
    if decompressor is None:
        raise UnreadableFile(f"a chunk is compressed by {compression}, which is not known")
    try:
        return bytes(decompressor.decompress(content))
    # Three libraries, and each has errors of its own.
    except Exception as error:
        raise UnreadableFile(f"a chunk of {compression} is damaged ({error})") from error


def _decompressor(compression: str) -> Any:
    if compression == "bz2":
        return bz2.BZ2Decompressor()
    if compression == "lz4":
        import lz4.frame

        return lz4.frame.LZ4FrameDecompressor()
    if compression == "zstd":
        return zstd_module().ZstdDecompressor()
    return None


def zstd_module() -> Any:
    """Return Python's zstd, or what stands for it before 3.14."""
    try:
        from compression import zstd
    except ImportError:
        from backports import zstd
    return zstd
