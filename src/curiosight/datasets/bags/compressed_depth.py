"""Decode what compressed_depth_image_transport writes: PNG or RVL behind a header of 12 bytes."""

from __future__ import annotations

import struct

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.decoding import UnreadableFile, decode_content
from curiosight.datasets.depth_files import EightBitDepth, Raw
from curiosight.datasets.palette import PNG_SIGNATURE
from curiosight.errors.compiling import njit

# A number of its own kind, then the two of the quantisation of floats.
HEAD = struct.Struct("<iff")
SIZE = struct.Struct("<II")
# A pixel takes half a byte at least, unless it is in a run of zeros.
MAX_PIXELS = 100_000_000


def is_depth_format(text: str) -> bool:
    """Tell whether a compressed image's format says that it is depth."""
    return "compresseddepth" in text.lower() or text.startswith(("16UC1", "32FC1"))


def decode_depth(content: bytes, text: str, name: str) -> Raw:
    """Return (H, W) uint16 of whole numbers, or float32 metres, NaN = none; `UnreadableFile`.

    text: the message's format, such as "16UC1; compressedDepth rvl". Depth of floats is stored
    as its inverse in 16 bits.
    """
    is_rvl = "rvl" in text.lower()
    # Some write a plain PNG, without the header.
    has_head = is_rvl or not content.startswith(PNG_SIGNATURE)
    if has_head and len(content) < HEAD.size + SIZE.size:
        raise UnreadableFile(f"{name} is truncated")
    body = content[HEAD.size :] if has_head else content
    raw = _decode_rvl(body, name) if is_rvl else _decode_png(body, name)
    if not text.startswith("32FC1") or not has_head:
        return raw
    _, scale, offset = HEAD.unpack_from(content)
    with np.errstate(divide="ignore"):
        depth = np.float32(scale) / (raw.astype(np.float32) - np.float32(offset))
    depth[raw == 0] = np.nan
    return depth


def _decode_png(content: bytes, name: str) -> Raw:
    if not content.startswith(PNG_SIGNATURE):
        raise UnreadableFile(f"{name} is no PNG behind the header of compressedDepth")
    raw = decode_content(name, content, cv2.IMREAD_UNCHANGED)
    if raw.dtype == np.uint8:
        raise EightBitDepth(f"{name} has 8 bits a pixel where depth needs 16")
    if raw.ndim != 2:
        raise UnreadableFile(f"{name} has {raw.shape[2]} channels where depth has one")
    return raw


def _decode_rvl(content: bytes, name: str) -> Raw:
    width, height = SIZE.unpack_from(content)
    if not 0 < width * height <= MAX_PIXELS:
        raise UnreadableFile(f"{name} claims to be {width}x{height}")
    coded = content[SIZE.size :]
    coded += b"\0" * (-len(coded) % 4)
    flat = np.zeros(width * height, np.uint16)
    if not _unroll(np.frombuffer(coded, "<u4").astype(np.uint32), flat):
        raise UnreadableFile(f"{name} is truncated")
    return flat.reshape(height, width)


@njit(cache=True)
def _unroll(words: npt.NDArray[np.uint32], depth: npt.NDArray[np.uint16]) -> bool:
    """Fill depth from runs of zeros and of differences; False where the words do not suffice.

    RVL (Wilson 2017): numbers of 3 bits a nibble, the fourth tells that more follow, from the
    highest nibble of each word; a run of zeros' length, a run's length, then its differences
    with the sign in the last bit.
    """
    n_nibbles = len(words) * 8
    at = 0
    pixel = 0
    previous = 0
    left = 0  # numbers of the present run
    is_zeros = False
    while pixel < len(depth):
        value = 0
        shift = 0
        while True:
            if at >= n_nibbles:
                return False
            nibble = (words[at // 8] >> np.uint32(28 - 4 * (at % 8))) & np.uint32(15)
            at += 1
            value |= (int(nibble) & 7) << shift
            shift += 3
            if nibble < 8 or shift > 30:
                break
        if left > 0:
            previous += (value >> 1) ^ -(value & 1)
            depth[pixel] = np.uint16(previous & 0xFFFF)
            pixel += 1
            left -= 1
            continue
        is_zeros = not is_zeros
        if value > len(depth) - pixel:
            return False
        if is_zeros:
            pixel += value
        else:
            left = value
    return True
