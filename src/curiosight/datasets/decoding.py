"""Read the images of a recording, and say in words what is wrong with a bad one."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets import headers
from curiosight.datasets.complaints import listen
from curiosight.datasets.headers import JPEG_START, is_too_large
from curiosight.datasets.palette import FAULTS as PALETTE_FAULTS
from curiosight.datasets.palette import (
    PNG_SIGNATURE,
    as_stored,
    may_have_palette,
    read_indices,
)
from curiosight.datasets.tiff_tags import TIFF_SIGNATURES
from curiosight.errors.inputs import read_bytes
from curiosight.frame import Rgb

JPEG_END = b"\xff\xd9"
# Some cameras pad a JPEG after its end; inside the coded picture the end mark cannot occur.
JPEG_TAIL_BYTES = 1024
# Between the channels of a grey picture that was saved as a coloured JPEG.
LOSSY_SPREAD = 24


class UnreadableFile(Exception):  # noqa: N818 - becomes a Frame's `problem`, never a user's error
    """Name a file of a recording and what is wrong with it, such as "a.png is truncated"."""


class ColourCoded(UnreadableFile):
    """Name a mask that is painted in colours: no values can be read from it."""


def read_rgb(path: Path, *, is_turned: bool = False) -> Rgb:
    """Read a colour image as (H, W, 3) uint8, red first; raise `UnreadableFile`.

    is_turned: as its EXIF orientation asks and viewers show it; else as stored, pixel on pixel
    with depth, which carries no such mark.
    """
    bgr = _decode(path, cv2.IMREAD_COLOR | _turning(is_turned))
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)  # type: ignore[no-any-return]


def decode_unchanged(path: Path) -> npt.NDArray[Any]:
    """Read an image as it is stored, whatever its channels and bits; raise `UnreadableFile`."""
    return _decode(path, cv2.IMREAD_UNCHANGED)


def read_grey(path: Path, *, is_turned: bool = False) -> npt.NDArray[Any]:
    """Read a mask or label image as (H, W) uint8 or uint16; raise `UnreadableFile`.

    Pixels of a palette are its indices, and three equal channels are one. is_turned: as in
    `read_rgb`. Raises `ColourCoded` where the channels differ.
    """
    content = _content(path)
    if may_have_palette(content):
        try:
            indices = read_indices(content, is_turned=is_turned)
        except PALETTE_FAULTS:
            raise UnreadableFile(f"{path.name} is not an image that can be decoded") from None
        if indices is not None:
            return indices
    flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH | _turning(is_turned)
    values = _decoded(path, content, flags)
    if values.dtype not in (np.uint8, np.uint16):
        raise UnreadableFile(f"{path.name} is of {values.dtype}, where 8 or 16 bits hold a mask")
    if values.ndim == 2:
        return values
    spread = int(np.ptp(values, axis=2).max()) if values.size else 0
    if spread > (LOSSY_SPREAD if is_lossy(content) else 0):
        raise ColourCoded(f"{path.name} is painted in colours, where a mask is of greys")
    return cv2.cvtColor(values, cv2.COLOR_BGR2GRAY)  # type: ignore[no-any-return]


def is_lossy(content: bytes) -> bool:
    """Tell from the first bytes of a file whether its values may be smeared."""
    return content.startswith(JPEG_START) or content[8:12] == b"WEBP"


def decode_content(name: str, content: bytes, flags: int) -> npt.NDArray[Any]:
    """Decode an image that is in memory; raises `UnreadableFile`, which calls it by its name.

    flags: OpenCV's.
    """
    fault = _fault(content)
    if fault:
        raise UnreadableFile(f"{name} {fault}")
    return _decoded(Path(name), content, flags)


def _turning(is_turned: bool) -> int:
    return 0 if is_turned else int(cv2.IMREAD_IGNORE_ORIENTATION)


def _decode(path: Path, flags: int) -> npt.NDArray[Any]:
    return _decoded(path, _content(path), flags)


def _content(path: Path) -> bytes:
    try:
        content = read_bytes(path)
    except FileNotFoundError:
        raise UnreadableFile(f"{path.name} is missing") from None
    except OSError as error:
        raise UnreadableFile(f"{path.name} cannot be read ({error.strerror})") from error
    fault = _fault(content)
    if fault:
        raise UnreadableFile(f"{path.name} {fault}")
    return content


def _decoded(path: Path, content: bytes, flags: int) -> npt.NDArray[Any]:
    image, damage = listen(lambda: _decoded_by_opencv(content, flags))
    if image is None:
        raise UnreadableFile(f"{path.name} is not an image that can be decoded")
    if damage:
        raise UnreadableFile(f"{path.name} is damaged ({damage})")
    # IMREAD_UNCHANGED has all bits set, this one too.
    if content.startswith(TIFF_SIGNATURES) and flags & cv2.IMREAD_IGNORE_ORIENTATION:
        return as_stored(content, image)
    return image


def _decoded_by_opencv(content: bytes, flags: int) -> npt.NDArray[Any] | None:
    try:
        return cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except cv2.error:
        return None


def _fault(content: bytes) -> str | None:
    """Find damage that OpenCV would pass over: it decodes half a picture without a word."""
    if not content:
        return "is empty"
    if is_too_large(content):
        return f"says that it has more than {headers.MAX_PIXELS // 1_000_000} million pixels"
    if content.startswith(PNG_SIGNATURE):
        return _png_fault(content)
    if content.startswith(JPEG_START) and JPEG_END not in content[-JPEG_TAIL_BYTES:]:
        return "is truncated"
    return None


def _png_fault(content: bytes) -> str | None:
    position = len(PNG_SIGNATURE)
    while position + 12 <= len(content):
        length, kind = struct.unpack_from(">I4s", content, position)
        end = position + 12 + length
        if end > len(content):
            break
        (checksum,) = struct.unpack_from(">I", content, end - 4)
        if zlib.crc32(memoryview(content)[position + 4 : end - 4]) != checksum:
            return "is damaged"
        if kind == b"IEND":
            return None
        position = end
    return "is truncated"
