"""Scan a bag of ROS 1: every record from the first to the last, whether it is indexed or not."""

from __future__ import annotations

import struct
from pathlib import Path

from curiosight.datasets.bags.messages import (
    HEAD_BYTES,
    NS_PER_SECOND,
    Messages,
    type_name,
)
from curiosight.datasets.bags.sources import ChunkedFile, FileSource, Source
from curiosight.errors import DataError

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, BAG, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 5, 6, 7
USUAL_HEAD = 512
# Longer ones are no headers: the file is damaged there.
MAX_HEAD = 1_000_000
REMEDY = "copy or record it again"


class Ros1File(ChunkedFile):
    """A bag of ROS 1. Raises `DataError` where it is none, or of a version that is not read.

    Linear, so that a bag that was never closed (`.bag.active`) or was cut short is read as well.
    """

    def __init__(self, path: Path, *, are_zstd: bool = False) -> None:
        super().__init__(path, are_zstd=are_zstd)
        self._connections: dict[int, Messages] = {}
        self._n_infos = self._n_told = 0
        self._n_chunks = 0
        with FileSource(path) as source:
            magic = source.read(0, len(MAGIC))
            if magic != MAGIC:
                is_old = magic.startswith(b"#ROS")
                found = "is a bag of an old version" if is_old else "is no bag of ROS 1"
                remedy = "convert it with `rosbag migrate`" if is_old else REMEDY
                raise DataError(path, found, remedy)
            self._walk(source, len(MAGIC), source.size, chunk=-1)
        if self._n_infos and self._n_infos == self._n_chunks:
            self.n_announced = self._n_told
        elif self._n_chunks or self.topics:
            self.faults.append("it was not closed or is cut, read to its last whole message")

    def _walk(
        self, source: Source, position: int, end: int, *, chunk: int, is_inside: bool = False
    ) -> None:
        """Note what the records of a file or chunk are about, up to the first that is cut."""
        while position + 8 <= end:
            content = source.read(position, USUAL_HEAD)
            (n_head,) = struct.unpack_from("<I", content)
            if not 0 < n_head < MAX_HEAD:
                return
            if n_head + 8 + HEAD_BYTES > len(content):
                content = source.read(position, n_head + 8 + HEAD_BYTES)
            if len(content) < n_head + 8:
                return
            fields = _fields(content[4 : 4 + n_head])
            (length,) = struct.unpack_from("<I", content, 4 + n_head)
            body = position + 8 + n_head
            first = content[8 + n_head :][:length]
            kind = (fields.get(b"op") or b"\0")[0]
            if kind == CHUNK and not is_inside:
                self._walk_chunk(source, fields, body, min(body + length, end))
            elif body + length <= end:
                self._note(kind, fields, source, body, length, first, chunk)
            position = body + length

    def _walk_chunk(self, source: Source, fields: dict[bytes, bytes], body: int, end: int) -> None:
        self._n_chunks += 1
        compression = fields.get(b"compression", b"none").decode("ascii", "replace")
        if compression == "none":
            self._walk(source, body, end, chunk=-1, is_inside=True)
            return
        # The length is written last: a recorder that was killed leaves 0.
        end = end if end > body else source.size
        content = self.new_chunk(body, end - body, compression, source)
        self._walk(content, 0, content.size, chunk=len(self._chunks) - 1, is_inside=True)

    def _note(
        self,
        kind: int,
        fields: dict[bytes, bytes],
        source: Source,
        body: int,
        length: int,
        first: bytes,
        chunk: int,
    ) -> None:
        if kind == MESSAGE:
            messages = self._connections.get(_number(fields.get(b"conn", b"")))
            if messages is not None and len(fields.get(b"time", b"")) == 8:
                seconds, nanoseconds = struct.unpack("<II", fields[b"time"])
                logged_ns = seconds * NS_PER_SECOND + nanoseconds
                self.add(messages, source, (chunk, body, length), logged_ns, first)
        elif kind == CONNECTION:
            number = _number(fields.get(b"conn", b""))
            if number not in self._connections:
                about = _fields(source.read(body, length))
                topic = fields.get(b"topic", b"").decode("utf-8", "replace")
                name = type_name(about.get(b"type", b"").decode("utf-8", "replace"))
                known = self.topics.setdefault((topic, name), Messages(topic, name, "ros1"))
                self._connections[number] = known
        elif kind == CHUNK_INFO:
            self._n_infos += 1
            counts = source.read(body, length)
            self._n_told += sum(n for _, n in struct.iter_unpack("<II", counts[: length // 8 * 8]))
        elif kind == BAG and fields.get(b"encryptor"):
            raise DataError(self.path, "is encrypted", "decrypt it with `rosbag decrypt`")


def _fields(content: bytes) -> dict[bytes, bytes]:
    """Return the named values of a header, as far as it is whole."""
    fields: dict[bytes, bytes] = {}
    position = 0
    while position + 4 <= len(content):
        (length,) = struct.unpack_from("<I", content, position)
        name, is_named, value = content[position + 4 : position + 4 + length].partition(b"=")
        if is_named:
            fields[name] = value
        position += 4 + length
    return fields


def _number(content: bytes) -> int:
    return int.from_bytes(content, "little") if len(content) == 4 else -1
