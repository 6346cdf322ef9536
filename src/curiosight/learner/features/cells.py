"""Superpixels in a fraction of a millisecond: cells of a grid whose outlines move to edges."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb
from curiosight.learner.features.superpixel_sums import sum_colours
from curiosight.learner.features.superpixels import Superpixels

Array = npt.NDArray[Any]
# Means are kept in eighths of a grey level, so that rounding decides nothing.
PARTS = 8


class CellSegmenter:
    """Cut small images into cells of one size, whose outlines follow the image.

    n_superpixels: for a 320x240 image; their side is the whole number of pixels next to it.
    n_passes: how many pixels an outline may move. In each pass, every pixel beside another
        cell goes to the one of nearest mean colour, among its own and those beside it.

    Any number of threads may call one.
    """

    def __init__(self, *, n_superpixels: int, n_passes: int = 2) -> None:
        self.n_superpixels = n_superpixels
        self.n_passes = n_passes

    def __call__(self, image: Rgb) -> Superpixels:
        """Return the (h, w) int32 superpixel of every pixel, 0, 1, …, row by row of the grid.

        image: (h, w, 3) uint8, in whatever space distances of colour are to be taken. A cell
        all of whose pixels went elsewhere keeps its number.
        """
        side = max(1, round((320 * 240 / self.n_superpixels) ** 0.5))
        height, width = image.shape[:2]
        n_down, n_across = (max(1, round(length / side)) for length in (height, width))
        down = (np.arange(height) * n_down // height * n_across).astype(np.int32)
        across = (np.arange(width) * n_across // width).astype(np.int32)
        cells: Superpixels = down[:, None] + across
        for _ in range(self.n_passes):
            cells = move_outlines(image, cells, _mean_colours(image, cells, n_down * n_across))
        return cells


@njit(cache=True, nogil=True)
def _mean_colours(image: Array, superpixels: Array, n_superpixels: int) -> Array:
    """Return the (n, 3) int32 mean colours, in eighths, rounded."""
    sums, counts = sum_colours(image, superpixels, n_superpixels)
    means = np.zeros((n_superpixels, 3), np.int32)
    for s in range(n_superpixels):
        for c in range(3):
            if counts[s] > 0:
                means[s, c] = (PARTS * sums[s, c] + counts[s] // 2) // counts[s]
    return means


@njit(cache=True, nogil=True)
def move_outlines(image: Array, superpixels: Array, means: Array) -> Array:
    """Return superpixels whose outline pixels went to the nearest mean colour beside them.

    means: (n, 3) int32, in eighths. All pixels go at once; of equally near ones the first stays:
    their own, then that to the left, right, above, below.
    """
    height, width = superpixels.shape
    moved = superpixels.copy()
    for v in range(height):
        above, below = max(v - 1, 0), min(v + 1, height - 1)
        for u in range(width):
            own = superpixels[v, u]
            left, right = superpixels[v, max(u - 1, 0)], superpixels[v, min(u + 1, width - 1)]
            upper, lower = superpixels[above, u], superpixels[below, u]
            if left == own and right == own and upper == own and lower == own:
                continue
            first, second, third = image[v, u, 0], image[v, u, 1], image[v, u, 2]
            nearest = _distance(means, own, first, second, third)
            for other in (left, right, upper, lower):
                if other != own:
                    distance = _distance(means, other, first, second, third)
                    if distance < nearest:
                        nearest = distance
                        moved[v, u] = other
    return moved


@njit(cache=True, nogil=True, inline="always")
def _distance(means: Array, superpixel: int, first: int, second: int, third: int) -> int:
    """Return the squared distance of a pixel's colour to a mean, in 64ths."""
    a = np.int32(PARTS) * np.int32(first) - means[superpixel, 0]
    b = np.int32(PARTS) * np.int32(second) - means[superpixel, 1]
    c = np.int32(PARTS) * np.int32(third) - means[superpixel, 2]
    return int(a * a + b * b + c * c)
