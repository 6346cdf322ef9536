"""Read what OpenCV does not give: the indices of a palette, and which way up a file is stored."""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
TIFF_SIGNATURES = (b"II*\0", b"MM\0*")
ORIENTATION = 0x0112
# What Pillow raises for files that lie about themselves.
FAULTS = (OSError, SyntaxError, ValueError, TypeError, KeyError, OverflowError, struct.error)
_PNG_COLOUR_TYPE, _PNG_PALETTE = 25, 3


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
    from PIL import Image, ImageOps

    with Image.open(io.BytesIO(content), formats=("PNG", "BMP", "TIFF")) as image:
        if image.mode != "P":
            return None
        turned = ImageOps.exif_transpose(image) if is_turned else image
        indices = np.array(turned, np.uint8)
        colours = np.array(image.getpalette("RGB"), np.uint8).reshape(-1, 3)
    if content.startswith(TIFF_SIGNATURES) and not is_turned:
        indices = as_stored(content, indices)
    used = np.unique(indices)
    if used[-1] >= len(colours):
        return indices
    greys = colours[used]
    is_grey = bool((greys == greys[:, :1]).all()) and len(np.unique(greys[:, 0])) == len(used)
    return colours[indices, 0] if is_grey else indices


def as_stored(content: bytes, image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Undo the turn by a TIFF's orientation, which decoders make whatever they are told."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content), formats=("TIFF",)) as header:
            orientation = header.getexif().get(ORIENTATION, 1)
    except FAULTS:
        return image
    match orientation:
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
