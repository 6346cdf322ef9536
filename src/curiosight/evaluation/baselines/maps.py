"""What every baseline takes and gives: a colour image, and a map in [0, 1]."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb

Saliency = npt.NDArray[np.float32]


def check_rgb(rgb: Rgb) -> None:
    """Raise ValueError unless the image is (H, W, 3) uint8 with at least one pixel."""
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or rgb.size == 0:
        raise ValueError(f"rgb: expected (H, W, 3) uint8, got {rgb.shape} {rgb.dtype}")


def resized_to(rgb: Rgb, longer_side: int) -> Rgb:
    """Bring the longer side of an image to so many pixels, the other to at least one."""
    height, width = rgb.shape[:2]
    size = [max(longer_side * side // max(height, width), 1) for side in (width, height)]
    resized: Rgb = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
    return resized


def in_size_of(rgb: Rgb, grey: npt.NDArray[np.uint8]) -> Saliency:
    """Return an 8-bit map of any size as the map of an image, resized bilinearly."""
    resized = cv2.resize(grey, rgb.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    saliency: Saliency = resized / np.float32(255)
    return saliency


def to_grey(values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Return a map of any range as 8 bits, stretched to 0 … 255."""
    grey: npt.NDArray[np.uint8] = np.rint(255 * stretched(values)).astype(np.uint8)
    return grey


def stretched(values: npt.NDArray[Any], rounding: float = 0.0) -> npt.NDArray[Any]:
    """Move the smallest value to 0 and the largest to 1; what is constant becomes 0.

    Constant is what varies by no more than `rounding`.
    """
    low, high = values.min(), values.max()
    if high - low <= rounding:
        return np.zeros_like(values)
    unit: npt.NDArray[Any] = (values - low) / (high - low)
    return unit
