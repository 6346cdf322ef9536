"""Read how large a picture says it is, before anything makes room for its pixels."""

from __future__ import annotations

import io
import re
import struct
from pathlib import Path
from typing import IO

from curiosight.datasets.palette import PNG_SIGNATURE
from curiosight.datasets.tiff_tags import HEIGHT, TIFF_SIGNATURES, WIDTH, tiff_tags
from curiosight.errors.inputs import check_file

Size = tuple[int, int]

# More than any camera has: 400 MB of colour.
MAX_PIXELS = 2**27
# Width and height stand among the first bytes, after remarks of any length.
NETPBM_STARTS = tuple(b"P%d" % kind for kind in range(1, 7))
_NETPBM_BYTES = 4096
_OS2_HEADER = 12  # bytes; of BMP
JPEG_START = b"\xff\xd8"
# Start of frame: all of these markers but those of tables.
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xD8)))


def size_in_header(file: IO[bytes]) -> Size | None:
    """Return (width, height) as an open file's header has it; None where that is not found."""
    head = file.read(24)
    if head.startswith(PNG_SIGNATURE):
        return struct.unpack_from(">II", head, 16) if len(head) == 24 else None
    file.seek(0)
    if head.startswith(JPEG_START):
        return _jpeg_size(file)
    if head.startswith(TIFF_SIGNATURES):
        return _tiff_size(file)
    if head.startswith(NETPBM_STARTS):
        return _netpbm_size(file.read(_NETPBM_BYTES))
    head = file.read(30)
    if len(head) < 30:
        return None
    if head.startswith(b"BM"):
        return _bmp_size(head)
    return _webp_size(head) if head.startswith(b"RIFF") and head[8:12] == b"WEBP" else None


def size_in_file(path: Path) -> Size | None:
    """Do as `size_in_header` of a file; None, too, where it cannot be read."""
    try:
        check_file(path)
        with path.open("rb") as file:
            return size_in_header(file)
    except OSError:
        return None


def is_too_large(content: bytes) -> bool:
    """Tell whether a picture says that it has more than `MAX_PIXELS`."""
    size = size_in_header(io.BytesIO(content))
    return size is not None and size[0] * size[1] > MAX_PIXELS


def _jpeg_size(file: IO[bytes]) -> Size | None:
    """Go from segment to segment to the one that says it."""
    file.seek(2)
    while len(start := file.read(2)) == 2 and start[0] == 0xFF:
        marker = start[1]
        if marker == 0xFF:  # padding
            file.seek(-1, io.SEEK_CUR)
        elif marker not in _WITHOUT_LENGTH:
            segment = file.read(7)
            if len(segment) < 7:
                return None
            length, _, height, width = struct.unpack(">HBHH", segment)
            if marker in _FRAMES:
                return width, height
            file.seek(max(length, 2) - 7, io.SEEK_CUR)
    return None


def _tiff_size(file: IO[bytes]) -> Size | None:
    tags = tiff_tags(file)
    if WIDTH not in tags or HEIGHT not in tags:
        return None
    return tags[WIDTH].values[0], tags[HEIGHT].values[0]


def _bmp_size(head: bytes) -> Size | None:
    if struct.unpack_from("<I", head, 14)[0] == _OS2_HEADER:
        return struct.unpack_from("<HH", head, 18)
    width, height = struct.unpack_from("<ii", head, 18)
    return (width, abs(height)) if width > 0 else None  # below 0: rows from top to bottom


def _webp_size(head: bytes) -> Size | None:
    kind = head[12:16]
    if kind == b"VP8X":
        return 1 + int.from_bytes(head[24:27], "little"), 1 + int.from_bytes(head[27:30], "little")
    if kind == b"VP8L" and head[20] == 0x2F:
        bits = int.from_bytes(head[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    if kind == b"VP8 " and head[23:26] == b"\x9d\x01\x2a":
        width, height = struct.unpack_from("<HH", head, 26)
        return width & 0x3FFF, height & 0x3FFF
    return None


def _netpbm_size(head: bytes) -> Size | None:
    words = re.sub(rb"#[^\r\n]*", b" ", head[2:]).split(maxsplit=2)[:2]
    if len(words) < 2 or not all(word.isdigit() and len(word) < 10 for word in words):
        return None
    return int(words[0]), int(words[1])
