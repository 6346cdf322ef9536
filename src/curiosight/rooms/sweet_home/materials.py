"""Make the materials of a furniture library's model: its colours, and its pictures if sound."""

from __future__ import annotations

import struct

import cv2
import numpy as np

from curiosight.rooms.mesh import Material, Texture
from curiosight.rooms.sweet_home.wavefront import ModelError, Paint

MAX_IMAGE_SIDE = 4096
TEXTURE_SIDE = 256
PNG_START = b"\x89PNG\r\n\x1a\n"
JPEG_START = b"\xff\xd8"
MAX_JPEG_SEGMENTS = 1000
# Exporters write strong highlights for everything; this is what they mean of them.
SHINE_TO_GLOSS = 0.3
SOLID = 0.6
CLEAR_INFRARED = 0.03


def material_of(paint: Paint, image: bytes | None) -> Material:
    """Return the material of a paint; image: its picture, PNG or JPEG, None = plain colour.

    Raises `ModelError` on a picture that cannot be used.
    """
    if image is None:
        texture = np.rint(255 * np.array([[paint.colour]])).astype(np.uint8)
    else:
        # OBJ counts v from the bottom of the picture.
        texture = np.ascontiguousarray(read_texture(image)[::-1])
    brightness = float(texture.mean()) / 255
    return Material(
        texture,
        gloss=SHINE_TO_GLOSS * paint.shine,
        sharpness=paint.sharpness,
        # Dark things send little of any light back, clear ones hardly anything.
        infrared=min(0.1 + 2 * brightness, 1.0) if paint.opacity > SOLID else CLEAR_INFRARED,
    )


def read_texture(image: bytes) -> Texture:
    """Return a picture as (h, w, 3) uint8 sRGB of at most `TEXTURE_SIDE`; raises `ModelError`."""
    size = image_size(image)
    if size is None:
        raise ModelError("a picture that is neither PNG nor JPEG, or a damaged one")
    if not 0 < min(size) <= max(size) <= MAX_IMAGE_SIDE:
        raise ModelError(f"a picture of {size[0]}x{size[1]} pixels")
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        bgr = cv2.imdecode(np.frombuffer(image, np.uint8), flags)
    except cv2.error:
        bgr = None
    if bgr is None:
        raise ModelError("a picture that cannot be decoded")
    shrink = min(TEXTURE_SIDE / max(size), 1.0)
    small = [max(round(side * shrink), 1) for side in size]
    texture: Texture = cv2.cvtColor(
        cv2.resize(bgr, small, interpolation=cv2.INTER_AREA), cv2.COLOR_BGR2RGB
    )
    return texture


def image_size(image: bytes) -> tuple[int, int] | None:
    """Return width and height by the head of a PNG or JPEG, without decoding it; None = neither."""
    if image.startswith(PNG_START) and len(image) >= 24:
        width, height = struct.unpack_from(">II", image, 16)
        return width, height
    return _jpeg_size(image) if image.startswith(JPEG_START) else None


def _jpeg_size(image: bytes) -> tuple[int, int] | None:
    position = 2
    for _ in range(MAX_JPEG_SEGMENTS):
        if position + 9 > len(image):
            return None
        start, kind, length = struct.unpack_from(">BBH", image, position)
        if start != 0xFF:
            return None
        # Frame headers, but for three other marks among their numbers.
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from(">HH", image, position + 5)
            return width, height
        position += 2 + length
    return None
