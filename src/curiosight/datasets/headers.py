"""Read how large a picture says it is, before anything makes room for its pixels."""

from __future__ import annotations

import io
import struct
import warnings
from pathlib import Path
from typing import IO

from curiosight.datasets.palette import FAULTS, PNG_SIGNATURE, TIFF_SIGNATURES
from curiosight.errors.inputs import check_file

Size = tuple[int, int]

# More than any camera has: 400 MB of colour.
MAX_PIXELS = 2**27
# BMP, TIFF, WebP, and the formats of Netpbm.
OTHERS = (b"BM", *TIFF_SIGNATURES, b"RIFF", *(b"P%d" % kind for kind in range(1, 7)))
FORMATS = ("BMP", "TIFF", "WEBP", "PPM")
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
    return _size_by_pillow(file) if head.startswith(OTHERS) else None


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


def _size_by_pillow(file: IO[bytes]) -> Size | None:
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(file, formats=FORMATS) as image:
                return image.size
    except Image.DecompressionBombError:
        return MAX_PIXELS, MAX_PIXELS
    except FAULTS:
        return None
