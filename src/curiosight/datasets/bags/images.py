"""Turn image messages into colour and depth: any encoding, order of bytes, and padded rows."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.bags.compressed_depth import decode_depth, is_depth_format
from curiosight.datasets.decoding import UnreadableFile, decode_content
from curiosight.datasets.depth_files import EightBitDepth, Raw
from curiosight.frame import Rgb

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
IMAGE_TYPES = (IMAGE, COMPRESSED)
Pixels = npt.NDArray[Any]

# Letter of the type and channels of each encoding; "8UC3" and the like are told by their form.
_FORMS = {
    "rgb8": ("u1", 3),
    "bgr8": ("u1", 3),
    "rgba8": ("u1", 4),
    "bgra8": ("u1", 4),
    "mono8": ("u1", 1),
    "mono16": ("u2", 1),
    "rgb16": ("u2", 3),
    "bgr16": ("u2", 3),
    "yuv422": ("u1", 2),
    "uyvy": ("u1", 2),
    "yuv422_yuy2": ("u1", 2),
    "yuyv": ("u1", 2),
    **{f"bayer_{pattern}8": ("u1", 1) for pattern in ("rggb", "bggr", "gbrg", "grbg")},
}
_KINDS = {"U": "u", "S": "i", "F": "f"}
# OpenCV's names of Bayer patterns are of the second row and column.
_CONVERSIONS = {
    "bgr8": cv2.COLOR_BGR2RGB,
    "8UC3": cv2.COLOR_BGR2RGB,
    "rgba8": cv2.COLOR_RGBA2RGB,
    "bgra8": cv2.COLOR_BGRA2RGB,
    "8UC4": cv2.COLOR_BGRA2RGB,
    "mono8": cv2.COLOR_GRAY2RGB,
    "8UC1": cv2.COLOR_GRAY2RGB,
    "mono16": cv2.COLOR_GRAY2RGB,
    "bgr16": cv2.COLOR_BGR2RGB,
    "yuv422": cv2.COLOR_YUV2RGB_UYVY,
    "uyvy": cv2.COLOR_YUV2RGB_UYVY,
    "yuv422_yuy2": cv2.COLOR_YUV2RGB_YUY2,
    "yuyv": cv2.COLOR_YUV2RGB_YUY2,
    "bayer_rggb8": cv2.COLOR_BayerBG2RGB,
    "bayer_bggr8": cv2.COLOR_BayerRG2RGB,
    "bayer_gbrg8": cv2.COLOR_BayerGR2RGB,
    "bayer_grbg8": cv2.COLOR_BayerGB2RGB,
}
COLOURS = frozenset({"rgb8", "rgb16", *_CONVERSIONS})
GREYS = frozenset({"mono8", "8UC1", "mono16"})
DEPTHS = frozenset({"16UC1", "16SC1", "32FC1", "64FC1", "32UC1", "32SC1", "mono16"})


def is_compressed(message: Any) -> bool:
    """Tell a CompressedImage from an Image, whoever made the class of the message."""
    return hasattr(message, "format")


def encoding_of(message: Any) -> str:
    """Return what an image's pixels are: its encoding, or "depth", "jpeg", … where compressed.

    Of a compressed colour image only what stands before the semicolon, if it says that.
    """
    if not is_compressed(message):
        return str(message.encoding)
    return "depth" if is_depth_format(message.format) else str(message.format).partition(";")[0]


def to_rgb(message: Any, name: str) -> Rgb:
    """Return a colour image's (H, W, 3) uint8, red first; raises `UnreadableFile`."""
    if is_compressed(message):
        content = bytes(message.data)
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
        decoded = decode_content(name, content, flags)
        # The format says which order the encoder was given; what it does not say is as usual.
        if "compressed rgb" in message.format:
            return np.ascontiguousarray(decoded)
        return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB)  # type: ignore[no-any-return]
    encoding = str(message.encoding)
    if encoding not in COLOURS:
        raise UnreadableFile(f"{name} is encoded as {encoding}, which is no colour read here")
    pixels = _pixels(message, name)
    if encoding in _CONVERSIONS:
        pixels = cv2.cvtColor(pixels, _CONVERSIONS[encoding])
    return (pixels >> 8).astype(np.uint8) if pixels.dtype == np.uint16 else pixels


def to_depth(message: Any, name: str) -> Raw:
    """Return a depth image's (H, W) numbers as they are, whole or float; `UnreadableFile`."""
    if is_compressed(message):
        return decode_depth(bytes(message.data), str(message.format), name)
    encoding = str(message.encoding)
    if encoding in ("mono8", "8UC1"):
        raise EightBitDepth(f"{name} has 8 bits a pixel where depth needs 16")
    if encoding not in DEPTHS:
        raise UnreadableFile(f"{name} is encoded as {encoding}, which is no depth")
    return _pixels(message, name)


def _pixels(message: Any, name: str) -> Pixels:
    """Return (H, W) or (H, W, C) in this machine's order of bytes, without padding."""
    letter, n_channels = _form(str(message.encoding))
    dtype = np.dtype((">" if message.is_bigendian else "<") + letter)
    height, width = int(message.height), int(message.width)
    n_row = width * n_channels * dtype.itemsize
    step = int(message.step) or n_row
    content = np.asarray(message.data, np.uint8)
    if not n_row or not height or step < n_row:
        raise UnreadableFile(f"{name} is {width}x{height} in rows of {step} bytes: no such image")
    # The last row may come without its padding.
    n_needed = step * (height - 1) + n_row
    if content.size < n_needed:
        raise UnreadableFile(f"{name} holds {content.size} of its {n_needed} bytes")
    if step == n_row:
        rows = content[:n_needed].reshape(height, n_row)
    else:
        padded = np.zeros(step * height, np.uint8)
        padded[: min(content.size, padded.size)] = content[: padded.size]
        rows = padded.reshape(height, step)[:, :n_row]
    pixels = np.ascontiguousarray(rows).view(dtype).astype(dtype.newbyteorder("="))
    return pixels.reshape((height, width) if n_channels == 1 else (height, width, n_channels))


def _form(encoding: str) -> tuple[str, int]:
    """Return the type of a number and how many a pixel has: ("u2", 1) of "16UC1"."""
    if encoding in _FORMS:
        return _FORMS[encoding]
    bits, _, channels = encoding.partition("C")
    return f"{_KINDS[bits[-1]]}{int(bits[:-1]) // 8}", int(channels or 1)
