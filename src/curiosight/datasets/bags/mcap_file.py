"""Scan an MCAP file: every record from the first to the last, whether there is an index or not."""

from __future__ import annotations

import struct
import zlib
from contextlib import suppress
from pathlib import Path

from curiosight.datasets.bags.messages import HEAD_BYTES, Messages, type_name
from curiosight.datasets.bags.sources import ChunkedFile, FileSource, Source
from curiosight.errors import DataError

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS = 0x02, 0x03, 0x04, 0x05, 0x06, 0x0B
RECORD_HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<HIQQ")
CHUNK_HEAD = struct.Struct("<QQQII")


class McapFile(ChunkedFile):
    """An MCAP file. Raises `DataError` where it is none.

    Linear, so that files without indexes, of any order, and those cut short are read as well.
    """

    def __init__(self, path: Path, *, are_zstd: bool = False) -> None:
        super().__init__(path, are_zstd=are_zstd)
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, Messages] = {}
        self._is_ended = False
        with FileSource(path) as source:
            if source.read(0, len(MAGIC)) != MAGIC:
                raise DataError(path, "is no MCAP file", "copy or record it again")
            # A record that is damaged ends it, as one that is cut does.
            with suppress(struct.error):
                self._walk(source, len(MAGIC), source.size, chunk=-1)
        if not self._is_ended:
            self.faults.append("it is cut short, read to its last whole message")

    def _walk(
        self, source: Source, position: int, end: int, *, chunk: int, is_inside: bool = False
    ) -> None:
        """Note what the records of a file or chunk are about, up to the first that is cut."""
        while position + RECORD_HEAD.size <= end:
            head = source.read(position, RECORD_HEAD.size + MESSAGE_HEAD.size + HEAD_BYTES)
            kind, length = RECORD_HEAD.unpack_from(head)
            body = position + RECORD_HEAD.size
            # What was not written yet when the power went is zero.
            if kind == 0 or kind == FOOTER:
                self._is_ended |= kind == FOOTER and body + length <= end
                return
            if kind == CHUNK and not is_inside:
                self._walk_chunk(source, body, min(body + length, end))
            elif body + length <= end:
                self._note(kind, source, body, length, head[RECORD_HEAD.size :], chunk)
            position = body + length

    def _walk_chunk(self, source: Source, body: int, end: int) -> None:
        head = source.read(body, CHUNK_HEAD.size + 64)
        if len(head) < CHUNK_HEAD.size:
            return
        _, _, n_unpacked, checksum, n_name = CHUNK_HEAD.unpack_from(head)
        if len(head) < CHUNK_HEAD.size + n_name + 8:
            return
        compression = head[CHUNK_HEAD.size : CHUNK_HEAD.size + n_name].decode("utf-8", "replace")
        start = body + CHUNK_HEAD.size + n_name + 8
        if not compression:
            self._walk(source, start, end, chunk=-1, is_inside=True)
            return
        content = self.new_chunk(start, end - start, compression, source)
        whole = content.read(0, content.size)
        if checksum and content.size == n_unpacked and zlib.crc32(whole) != checksum:
            self.faults.append("a chunk is damaged and left out")
            return
        self._walk(content, 0, content.size, chunk=len(self._chunks) - 1, is_inside=True)

    def _note(
        self, kind: int, source: Source, body: int, length: int, head: bytes, chunk: int
    ) -> None:
        if kind == MESSAGE and length >= MESSAGE_HEAD.size:
            channel, _, logged_ns, _ = MESSAGE_HEAD.unpack_from(head)
            messages = self._channels.get(channel)
            if messages is not None:
                place = chunk, body + MESSAGE_HEAD.size, length - MESSAGE_HEAD.size
                first = head[MESSAGE_HEAD.size :][: place[2]]
                self.add(messages, source, place, logged_ns, first)
        elif kind == SCHEMA:
            content = source.read(body, length)
            (number,) = struct.unpack_from("<H", content)
            self._schemas[number] = _text(content, 2)[0]
        elif kind == CHANNEL:
            self._note_channel(source.read(body, length))
        elif kind == STATISTICS and length >= 8:
            (self.n_announced,) = struct.unpack_from("<Q", head)

    def _note_channel(self, content: bytes) -> None:
        channel, schema = struct.unpack_from("<HH", content)
        topic, position = _text(content, 4)
        encoding, _ = _text(content, position)
        if channel not in self._channels:
            kind = type_name(self._schemas.get(schema, ""))
            known = self.topics.setdefault((topic, kind), Messages(topic, kind, encoding))
            self._channels[channel] = known


def _text(content: bytes, position: int) -> tuple[str, int]:
    """Return a text that follows its length, and where it ends."""
    (length,) = struct.unpack_from("<I", content, position)
    end = position + 4 + length
    return content[position + 4 : end].decode("utf-8", "replace"), end
