"""Read the members of a zip file one at a time, also of one that was cut short."""

from __future__ import annotations

import struct
import zipfile
import zlib
from dataclasses import dataclass
from mmap import ACCESS_READ, mmap
from pathlib import Path

from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError

LOCAL_HEADER = struct.Struct("<4s5H3I2H")
LOCAL_MARK = b"PK\x03\x04"
# Behind a member that was written before its size was known.
DESCRIPTOR = struct.Struct("<4s3I")
DESCRIPTOR_MARK = b"PK\x07\x08"
STORED, DEFLATED = 0, 8
ENCRYPTED, SIZES_FOLLOW = 1, 8
# No member of a recording is as large; more would be damage, or a trap.
MAX_BYTES = 200_000_000


@dataclass(frozen=True, slots=True)
class Member:
    """Where a member's content begins in the file, and how it is packed."""

    header_at: int
    packed_bytes: int
    method: int
    checksum: int


class ZipMembers:
    """The members of a zip file by name; nothing of it is kept in memory.

    is_cut: its table of contents, which stands at the end, is not there. Its members are found
    from the beginning then, up to the last whole one. Raises `DataError` for what is no zip file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_cut = False
        try:
            with zipfile.ZipFile(path) as file:
                self.members = {
                    info.filename: Member(
                        info.header_offset, info.compress_size, info.compress_type, info.CRC
                    )
                    for info in file.infolist()
                    if not info.flag_bits & ENCRYPTED
                }
        except (zipfile.BadZipFile, ValueError, NotImplementedError):
            self.is_cut = True
            self.members = _from_the_beginning(path)
        if not self.members:
            raise DataError(path, "is no zip file that can be read", "copy it again, whole")

    def read(self, name: str) -> bytes:
        """Return what a member holds; raises `UnreadableFile`."""
        member = self.members.get(name)
        if member is None:
            raise UnreadableFile(f"{name} is missing")
        with self.path.open("rb") as file:
            file.seek(member.header_at)
            head = file.read(LOCAL_HEADER.size)
            if len(head) < LOCAL_HEADER.size or not head.startswith(LOCAL_MARK):
                raise UnreadableFile(f"{name} is damaged")
            file.seek(sum(LOCAL_HEADER.unpack(head)[-2:]), 1)
            packed = file.read(min(member.packed_bytes, MAX_BYTES))
        content = _unpacked(packed, member.method)
        if content is None or zlib.crc32(content) != member.checksum:
            raise UnreadableFile(f"{name} is damaged")
        return content


def _unpacked(packed: bytes, method: int) -> bytes | None:
    if method == STORED:
        return packed
    if method != DEFLATED:
        return None
    try:
        return zlib.decompressobj(-zlib.MAX_WBITS).decompress(packed, MAX_BYTES)
    except zlib.error:
        return None


def _from_the_beginning(path: Path) -> dict[str, Member]:
    """List whole members by their own headers, and by what follows those that were streamed."""
    found: dict[str, Member] = {}
    if not path.stat().st_size:
        return found
    with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as content:
        at = 0
        while content[at : at + 4] == LOCAL_MARK and at + LOCAL_HEADER.size <= len(content):
            fields = LOCAL_HEADER.unpack_from(content, at)
            _, _, flags, method, _, _, checksum, packed, _, n_name, n_extra = fields
            start = at + LOCAL_HEADER.size + n_name + n_extra
            name = content[at + LOCAL_HEADER.size : start - n_extra].decode("utf-8", "replace")
            end = start + packed
            if flags & SIZES_FOLLOW:
                told = _told_behind(content, start)
                if told is None:
                    return found
                checksum, packed = told
                end = start + packed + DESCRIPTOR.size
            if end > len(content):
                return found
            if not flags & ENCRYPTED:
                found[name] = Member(at, packed, method, checksum)
            at = end
    return found


def _told_behind(content: mmap, start: int) -> tuple[int, int] | None:
    """Return the checksum and size of what begins there and says them at its end; None if cut."""
    at = content.find(DESCRIPTOR_MARK, start)
    while at >= 0 and at + DESCRIPTOR.size <= len(content):
        _, checksum, packed, _ = DESCRIPTOR.unpack_from(content, at)
        if packed == at - start:
            return checksum, packed
        at = content.find(DESCRIPTOR_MARK, at + 1)
    return None
