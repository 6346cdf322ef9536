"""Read what the first picture of a TIFF says of itself, without its pixels."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import IO

TIFF_SIGNATURES = (b"II*\0", b"MM\0*")
WIDTH, HEIGHT, BITS, PHOTOMETRIC, ORIENTATION, COLOURS = 256, 257, 258, 262, 274, 320
_WANTED = {WIDTH, HEIGHT, BITS, PHOTOMETRIC, ORIENTATION, COLOURS}
# By their kind: what unpacks one, and how many bytes it has.
_KINDS = {1: ("B", 1), 3: ("H", 2), 4: ("I", 4)}
_MOST_COLOURS = 3 * 2**16


@dataclass(frozen=True, slots=True)
class Tag:
    """Whole numbers that a tag holds, and at which byte of the file the first is."""

    values: tuple[int, ...]
    place: int


def tiff_tags(file: IO[bytes]) -> dict[int, Tag]:
    """Return those tags that are read here, by their number; {} of what is no TIFF.

    A tag that lies about where its numbers are is left out.
    """
    file.seek(0)
    head = file.read(8)
    if len(head) < 8 or not head.startswith(TIFF_SIGNATURES):
        return {}
    order = "<" if head.startswith(b"II") else ">"
    (start,) = struct.unpack_from(f"{order}I", head, 4)
    file.seek(start)
    number = file.read(2)
    if len(number) < 2:
        return {}
    entries = file.read(12 * struct.unpack(f"{order}H", number)[0])
    tags = {}
    for at in range(0, len(entries) - 11, 12):
        name, kind, n_values = struct.unpack_from(f"{order}HHI", entries, at)
        if name not in _WANTED or kind not in _KINDS or not 0 < n_values <= _MOST_COLOURS:
            continue
        letter, size = _KINDS[kind]
        place = start + 2 + at + 8
        if n_values * size > 4:  # elsewhere
            (place,) = struct.unpack_from(f"{order}I", entries, at + 8)
        file.seek(place)
        content = file.read(n_values * size)
        if len(content) == n_values * size:
            tags[name] = Tag(struct.unpack(f"{order}{n_values}{letter}", content), place)
    return tags
