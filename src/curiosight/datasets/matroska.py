"""Read a Matroska file's tracks, tags, attachments and blocks, without decoding any of them.

Its elements are walked from the beginning, so a file that was cut short is read up to its last
whole block. Blocks are passed over, and only where they lie is kept.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from curiosight.datasets.decoding import UnreadableFile

SEGMENT, CLUSTER, BLOCK_GROUP = 0x18538067, 0x1F43B675, 0xA0
INFO, TRACKS, ATTACHMENTS, TAGS = 0x1549A966, 0x1654AE6B, 0x1941A469, 0x1254C367
TRACK, ATTACHED, TAG, SIMPLE_TAG, TARGETS, VIDEO = 0xAE, 0x61A7, 0x7373, 0x67C8, 0x63C0, 0xE0
CLUSTER_TIME, SIMPLE_BLOCK, BLOCK = 0xE7, 0xA3, 0xA1
# Whose content is walked on; they may not say how long they are.
ENTERED = {SEGMENT, CLUSTER, BLOCK_GROUP}
SIGNATURE = b"\x1aE\xdf\xa3"
LACING = 0x06
USUAL_SCALE_NS = 1_000_000


class Element(NamedTuple):
    """An element: its id, and where its content lies."""

    id: int
    start: int
    end: int


class Block(NamedTuple):
    """A frame of a track as it is stored."""

    time_ns: int
    start: int
    end: int


@dataclass
class Track:
    """A track. uid: by which tags name it; private: what its codec needs to begin."""

    number: int = 0
    uid: int = 0
    name: str = ""
    codec: str = ""
    private: bytes = b""
    width: int = 0
    height: int = 0
    tags: dict[str, str] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)

    @property
    def four(self) -> str:
        """Return the four letters of a codec that is called as in AVI; "" for any other."""
        is_called_so = self.codec == "V_MS/VFW/FOURCC" and len(self.private) >= 20
        return self.private[16:20].decode("latin-1") if is_called_so else ""


class Matroska:
    """A file's tracks in their order, and its attachments by name.

    with_blocks: False = only what stands before the first of them is read.
    tags: that belong to no track. is_cut: the last element is not whole.
    """

    def __init__(self, path: Path, *, with_blocks: bool = True) -> None:
        self.path = path
        self.tracks: list[Track] = []
        self.attachments: dict[str, bytes] = {}
        self.tags: dict[str, str] = {}
        self.is_cut = False
        self._scale_ns, self._cluster_ns = USUAL_SCALE_NS, 0
        self._by_uid: list[tuple[int, str, str]] = []
        if path.stat().st_size:
            with (
                path.open("rb") as file,
                mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content,
            ):
                self._walk(content, with_blocks=with_blocks)
        for uid, name, text in self._by_uid:
            owners = [track.tags for track in self.tracks if track.uid == uid]
            (owners[0] if owners else self.tags)[name] = text

    def read(self, block: Block) -> bytes:
        """Return the bytes of a block; raises `UnreadableFile`."""
        try:
            with self.path.open("rb") as file:
                file.seek(block.start)
                return file.read(block.end - block.start)
        except OSError as error:
            raise UnreadableFile(f"{self.path.name} cannot be read ({error.strerror})") from error

    def _walk(self, content: mmap.mmap, *, with_blocks: bool) -> None:
        at, n = 0, len(content)
        if content[:4] != SIGNATURE:
            return
        while at < n:
            element = _element(content, at)
            if element is None:
                self.is_cut = True
                return
            if element.id == CLUSTER and not with_blocks:
                return
            if element.id in ENTERED:
                self.is_cut |= element.end > n
                at = element.start
                continue
            if element.end > n:
                self.is_cut = True
                return
            self._take(content, element)
            at = element.end

    def _take(self, content: mmap.mmap, element: Element) -> None:
        if element.id in (SIMPLE_BLOCK, BLOCK):
            self._take_block(content, element)
        elif element.id == CLUSTER_TIME:
            self._cluster_ns = _number(content, element) * self._scale_ns
        elif element.id == INFO:
            for child in _children(content, element):
                if child.id == 0x2AD7B1:
                    self._scale_ns = _number(content, child)
        elif element.id == TRACKS:
            self.tracks += [
                _track(content, c) for c in _children(content, element) if c.id == TRACK
            ]
        elif element.id == ATTACHMENTS:
            for child in _children(content, element):
                fields = {c.id: content[c.start : c.end] for c in _children(content, child)}
                name = fields.get(0x466E, b"").rstrip(b"\0").decode("utf-8", "replace")
                self.attachments[name] = fields.get(0x465C, b"")
        elif element.id == TAGS:
            for child in _children(content, element):
                self._by_uid += _tags(content, child)

    def _take_block(self, content: mmap.mmap, element: Element) -> None:
        number = _vint(content, element.start, keep_marker=False)
        if number is None or number[1] + 3 > element.end:
            return
        of_track, at = number
        offset, flags = struct.unpack_from(">hB", content, at)
        track = next((track for track in self.tracks if track.number == of_track), None)
        if track is not None and not flags & LACING:
            time_ns = self._cluster_ns + offset * self._scale_ns
            track.blocks.append(Block(time_ns, at + 3, element.end))


def _track(content: mmap.mmap, element: Element) -> Track:
    track = Track()
    for child in _children(content, element):
        raw = content[child.start : child.end]
        if child.id == 0xD7:
            track.number = int.from_bytes(raw, "big")
        elif child.id == 0x73C5:
            track.uid = int.from_bytes(raw, "big")
        elif child.id == 0x536E:
            track.name = raw.rstrip(b"\0").decode("utf-8", "replace")
        elif child.id == 0x86:
            track.codec = raw.rstrip(b"\0").decode("latin-1")
        elif child.id == 0x63A2:
            track.private = raw
        elif child.id == VIDEO:
            sides = {c.id: _number(content, c) for c in _children(content, child)}
            track.width, track.height = sides.get(0xB0, 0), sides.get(0xBA, 0)
    return track


def _tags(content: mmap.mmap, element: Element) -> Iterator[tuple[int, str, str]]:
    """Yield the UID of the track, 0 = of none, the name and the text of what a tag says."""
    uid = 0
    for child in _children(content, element):
        if child.id == TARGETS:
            for target in _children(content, child):
                uid = _number(content, target) if target.id == 0x63C5 else uid
        elif child.id == SIMPLE_TAG:
            fields = {c.id: content[c.start : c.end] for c in _children(content, child)}
            name, text = (
                fields.get(id, b"").rstrip(b"\0").decode("utf-8", "replace")
                for id in (0x45A3, 0x4487)
            )
            yield uid, name, text


def _children(content: mmap.mmap, parent: Element) -> Iterator[Element]:
    at = parent.start
    while at < parent.end:
        child = _element(content, at)
        if child is None or child.end > parent.end:
            return
        yield child
        at = child.end


def _number(content: mmap.mmap, element: Element) -> int:
    return int.from_bytes(content[element.start : element.end], "big")


def _element(content: mmap.mmap, at: int) -> Element | None:
    """Read the head of an element; None where it is damaged or not whole."""
    name = _vint(content, at, keep_marker=True)
    size = None if name is None else _vint(content, name[1], keep_marker=False)
    if name is None or size is None:
        return None
    n_bytes = size[1] - name[1]
    is_open = size[0] == (1 << 7 * n_bytes) - 1  # it does not say
    end = len(content) if is_open else size[1] + size[0]
    return Element(name[0], size[1], end)


def _vint(content: mmap.mmap, at: int, *, keep_marker: bool) -> tuple[int, int] | None:
    """Read a number that says by its first bits how long it is; return it, and where it ends."""
    first = content[at] if at < len(content) else 0
    n_bytes = 9 - first.bit_length()
    if not first or at + n_bytes > len(content):
        return None
    number = int.from_bytes(content[at : at + n_bytes], "big")
    return (number if keep_marker else number & ((1 << 7 * n_bytes) - 1)), at + n_bytes
