"""SEEDS superpixels of a small image, as in the paper's features (sec. II-A.1)."""

from __future__ import annotations

import threading
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb

Superpixels = npt.NDArray[np.int32]
ColourSpace = Literal["rgb", "lab"]

WORKING_WIDTH = 320
# SEEDS reads outside its memory on images smaller than this.
MIN_SIDE = 24


def shrink(rgb: Rgb) -> Rgb:
    """Bring an (H, W, 3) image to 320 pixels of width: the paper's half size of 640x480."""
    height, width = rgb.shape[:2]
    small_height = round(WORKING_WIDTH * height / max(width, 1))
    if small_height < MIN_SIDE or small_height > 16 * WORKING_WIDTH:
        raise ValueError(f"rgb: expected an image about as high as wide, got {width}x{height}")
    if (width, height) == (WORKING_WIDTH, small_height):
        return rgb
    # Exactly half is the mean of four pixels either way; far smaller needs the area's mean.
    way = cv2.INTER_AREA if width > 2 * WORKING_WIDTH else cv2.INTER_LINEAR
    small: Rgb = cv2.resize(rgb, (WORKING_WIDTH, small_height), interpolation=way)
    return small


def to_colour_space(rgb: Rgb, colour_space: ColourSpace) -> Rgb:
    """Return an RGB image as (h, w, 3) uint8 in another colour space.

    Lab is OpenCV's 8-bit scale: L·2.55, a + 128, b + 128.
    """
    if colour_space == "rgb":
        return rgb
    if colour_space == "lab":
        lab: Rgb = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB)
        return lab
    raise ValueError(f"colour_space: expected 'rgb' or 'lab', got {colour_space!r}")


class SeedsSegmenter:
    """Cut small images into superpixels of similar colour.

    n_superpixels: for a 320x240 image. The paper's code asks for 350, and its SEEDS makes 520
        of them; OpenCV's rounds the size of a block the other way and makes 520 of 600.

    Any number of threads may call one: OpenCV's object keeps the image that it is cutting, so
    each thread has its own, made at its first image and at every change of size.
    """

    def __init__(
        self, *, n_superpixels: int = 600, n_levels: int = 3, n_bins: int = 5, n_iterations: int = 4
    ) -> None:
        self.n_superpixels = n_superpixels
        self.n_levels = n_levels
        self.n_bins = n_bins
        self.n_iterations = n_iterations
        self._of_thread = threading.local()

    def __call__(self, rgb: Rgb) -> Superpixels:
        """Return the (h, w) int32 superpixel of every pixel, 0, 1, …, of an RGB image."""
        height, width = rgb.shape[:2]
        if getattr(self._of_thread, "size", None) != (height, width):
            self._of_thread.seeds = self._make(height, width)
            self._of_thread.size = height, width
        seeds = self._of_thread.seeds
        seeds.iterate(cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV), self.n_iterations)
        labels: Superpixels = seeds.getLabels()
        return labels

    def _make(self, height: int, width: int) -> Any:
        wanted = round(self.n_superpixels * width * height / (320 * 240))
        return cv2.ximgproc.createSuperpixelSEEDS(
            width, height, 3, max(1, wanted), self.n_levels, 2, self.n_bins, False
        )

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what cannot be copied and is made anew at the next image."""
        return {name: value for name, value in vars(self).items() if name != "_of_thread"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._of_thread = threading.local()
