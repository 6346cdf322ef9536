"""The newest frame as pictures: colour, what the teacher says, saliency, and how unsure it is."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import LABEL_COLOURS

Array = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float32]

QUALITY = 80
MOST_PX = 640
_OPACITY = 0.6


def draw_labels(rgb: Array, labels: Array) -> Array:
    """Tint an (H, W, 3) image by its (H, W) labels."""
    table = np.zeros((256, 3), np.uint8)
    for label, colour in LABEL_COLOURS.items():
        table[label] = colour
    tinted: Array = cv2.addWeighted(rgb, 1 - _OPACITY, table[labels], _OPACITY, 0)
    return tinted


def draw_map(values: Floats, *, colours: int = cv2.COLORMAP_VIRIDIS) -> Array:
    """Draw an (H, W) map in [0, 1]: dark to bright."""
    grey = np.rint(255 * np.clip(values, 0, 1)).astype(np.uint8)
    picture: Array = cv2.cvtColor(cv2.applyColorMap(grey, colours), cv2.COLOR_BGR2RGB)
    return picture


def to_grey_png(values: npt.NDArray[Any]) -> bytes:
    """Return an (H, W) image of values from 0 to 255 as PNG; fractions are rounded."""
    grey = np.rint(values).astype(np.uint8)
    is_encoded, encoded = cv2.imencode(".png", grey, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    assert is_encoded
    png: bytes = encoded.tobytes()
    return png


def to_jpeg(picture: Array, most_px: int | None = MOST_PX) -> bytes:
    """Return an (H, W, 3) RGB picture as JPEG. most_px: wide and high; None = as it is."""
    share = min(1.0, (most_px or np.inf) / max(picture.shape[:2]))
    if share < 1:
        picture = cv2.resize(picture, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    bgr = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    is_encoded, encoded = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    assert is_encoded
    jpeg: bytes = encoded.tobytes()
    return jpeg
