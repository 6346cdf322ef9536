"""Read what OpenCV does not give: the indices of a palette, and which way up a file is stored.

OpenCV paints the pixels with the palette's colours. Where the file is told that its numbers are
greys, the same decoder gives the numbers.
"""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.tiff_tags import (
    BITS,
    COLOURS,
    ORIENTATION,
    PHOTOMETRIC,
    TIFF_SIGNATURES,
    tiff_tags,
)

Colours = npt.NDArray[np.uint8]

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
# What files that lie about themselves lead to.
FAULTS = (ValueError, IndexError, struct.error, cv2.error)
_PNG_DEPTH, _PNG_COLOUR_TYPE = 24, 25
_PNG_GREY, _PNG_PALETTE = 0, 3
_TIFF_GREY, _TIFF_PALETTE = 1, 3


def may_have_palette(content: bytes) -> bool:
    """Tell from the first bytes of a file whether its pixels may be indices of a palette."""
    if content.startswith(PNG_SIGNATURE):
        return content[_PNG_COLOUR_TYPE : _PNG_COLOUR_TYPE + 1] == bytes([_PNG_PALETTE])
    return content.startswith((b"BM", *TIFF_SIGNATURES))


def read_indices(content: bytes, *, is_turned: bool = False) -> npt.NDArray[np.uint8] | None:
    """Return the (H, W) numbers that an image with a palette holds; None if it has no palette.

    A palette of greys alone is how programs store a small grey image: there the greys are the
    numbers. is_turned: as the EXIF orientation asks, else as stored. Raises `FAULTS`.
    """
    if content.startswith(PNG_SIGNATURE):
        found = _grey_png(content)
    elif content.startswith(TIFF_SIGNATURES):
        found = _grey_tiff(content)
    else:
        found = _grey_bmp(content)
    if found is None:
        return None
    grey, colours, n_bits = found
    flags = cv2.IMREAD_GRAYSCALE | (0 if is_turned else cv2.IMREAD_IGNORE_ORIENTATION)
    image = cv2.imdecode(np.frombuffer(grey, np.uint8), flags)
    if image is None:
        raise ValueError("content: expected an image with a palette, got what is none")
    # Few bits are spread over the greys from black to white.
    indices = np.asarray(image // (255 // (2**n_bits - 1)), np.uint8)
    if content.startswith(TIFF_SIGNATURES) and not is_turned:
        indices = as_stored(content, indices)
    used = np.unique(indices)
    if used[-1] >= len(colours):
        return indices
    greys = colours[used]
    is_grey = bool((greys == greys[:, :1]).all()) and len(np.unique(greys[:, 0])) == len(used)
    return colours[indices, 0] if is_grey else indices


def _grey_png(content: bytes) -> tuple[bytes, Colours, int] | None:
    """Return a PNG whose numbers are greys, its palette (n, 3), and how many bits they have."""
    if content[_PNG_COLOUR_TYPE] != _PNG_PALETTE:
        return None
    kept, colours, at = [content[:8]], np.zeros((0, 3), np.uint8), 8
    while at + 12 <= len(content):
        length, kind = struct.unpack_from(">I4s", content, at)
        chunk = content[at : at + 12 + length]
        if kind == b"IHDR":
            head = chunk[4:17] + bytes([_PNG_GREY]) + chunk[18:-4]
            chunk = chunk[:4] + head + struct.pack(">I", zlib.crc32(head))
        if kind == b"PLTE":
            colours = np.frombuffer(chunk[8:-4], np.uint8).reshape(-1, 3)
        elif kind not in (b"tRNS", b"bKGD", b"hIST", b"sBIT"):  # these are of the palette
            kept.append(chunk)
        at += 12 + length
    return b"".join(kept), colours, content[_PNG_DEPTH]


def _grey_tiff(content: bytes) -> tuple[bytes, Colours, int] | None:
    """Do as `_grey_png` with a TIFF."""
    tags = tiff_tags(io.BytesIO(content))
    if PHOTOMETRIC not in tags or tags[PHOTOMETRIC].values[0] != _TIFF_PALETTE:
        return None
    if BITS not in tags or COLOURS not in tags or tags[BITS].values[0] > 8:
        raise ValueError("content: expected a palette of at most 256 colours, got none")
    grey, place = bytearray(content), tags[PHOTOMETRIC].place
    order = "<" if content.startswith(b"II") else ">"
    struct.pack_into(f"{order}H", grey, place, _TIFF_GREY)
    colours = np.array(tags[COLOURS].values, np.int64).reshape(3, -1).T // 256
    return bytes(grey), colours.astype(np.uint8), tags[BITS].values[0]


def _grey_bmp(content: bytes) -> tuple[bytes, Colours, int] | None:
    """Do as `_grey_png` with a BMP, by a palette in which the colour of a number is its grey."""
    (size,) = struct.unpack_from("<I", content, 14)
    is_old = size == 12
    (n_bits,) = struct.unpack_from("<H", content, 24 if is_old else 28)
    if n_bits > 8:
        return None
    n_bytes = 3 if is_old else 4
    n_used = 0 if is_old else struct.unpack_from("<I", content, 46)[0]
    n_colours = min(n_used or 2**n_bits, 2**n_bits)
    start = 14 + size
    end = start + n_bytes * n_colours
    colours = np.frombuffer(content[start:end], np.uint8).reshape(n_colours, n_bytes)
    greys = np.zeros_like(colours)
    greys[:, :3] = np.arange(n_colours)[:, None]
    # As they are: nothing is spread, whatever the bits.
    return content[:start] + greys.tobytes() + content[end:], colours[:, 2::-1], 8


def as_stored(content: bytes, image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Undo the turn by a TIFF's orientation, which decoders make whatever they are told."""
    tag = tiff_tags(io.BytesIO(content)).get(ORIENTATION)
    match 1 if tag is None else tag.values[0]:
        case 2:
            image = image[:, ::-1]
        case 3:
            image = image[::-1, ::-1]
        case 4:
            image = image[::-1]
        case 5:
            image = image.swapaxes(0, 1)
        case 6:
            image = np.rot90(image, 1)
        case 7:
            image = image[::-1, ::-1].swapaxes(0, 1)
        case 8:
            image = np.rot90(image, -1)
    return np.ascontiguousarray(image)
