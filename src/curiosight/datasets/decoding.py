"""Read the images of a recording, and say in words what is wrong with a bad one."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
JPEG_START = b"\xff\xd8"
JPEG_END = b"\xff\xd9"
# Some cameras pad a JPEG after its end; inside the coded picture the end mark cannot occur.
JPEG_TAIL_BYTES = 1024


class UnreadableFile(Exception):  # noqa: N818 - becomes a Frame's `problem`, never a user's error
    """Name a file of a recording and what is wrong with it, such as "a.png is truncated"."""


def read_rgb(path: Path) -> Rgb:
    """Read a colour image as (H, W, 3) uint8, red first; raise `UnreadableFile`."""
    return cv2.cvtColor(_decode(path, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)  # type: ignore[no-any-return]


def decode_unchanged(path: Path) -> npt.NDArray[Any]:
    """Read an image as it is stored, whatever its channels and bits; raise `UnreadableFile`."""
    return _decode(path, cv2.IMREAD_UNCHANGED)


def read_grey(path: Path) -> npt.NDArray[Any]:
    """Read a mask or label image as (H, W) uint8 or uint16; raise `UnreadableFile`."""
    return _decode(path, cv2.IMREAD_ANYDEPTH)


def _decode(path: Path, flags: int) -> npt.NDArray[Any]:
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise UnreadableFile(f"{path.name} is missing") from None
    except OSError as error:
        raise UnreadableFile(f"{path.name} cannot be read ({error.strerror})") from error
    fault = _fault(content)
    if fault:
        raise UnreadableFile(f"{path.name} {fault}")
    try:
        image: npt.NDArray[Any] | None = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except cv2.error:
        image = None
    if image is None:
        raise UnreadableFile(f"{path.name} is not an image that can be decoded")
    return image


def _fault(content: bytes) -> str | None:
    """Find damage that OpenCV would pass over: it decodes half a picture without a word."""
    if not content:
        return "is empty"
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
