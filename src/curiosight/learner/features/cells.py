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
# A line of superpixels, that above and that below.
Lines = tuple[Array, Array, Array]
# Means are kept in eighths of a grey level, so that rounding decides nothing.
PARTS = 8
# Bits that say on which sides of a pixel there is another cell.
ACROSS, DOWN = 1, 2


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


@njit(cache=True, nogil=True, error_model="numpy")
def _mean_colours(image: Array, superpixels: Array, n_superpixels: int) -> Array:
    """Return the (n, 3) int32 mean colours, in eighths, rounded."""
    sums, counts = sum_colours(image, superpixels, n_superpixels)
    means = np.zeros((n_superpixels, 3), np.int32)
    for s in range(n_superpixels):
        for c in range(3):
            if counts[s] > 0:
                # Of numbers this small the quotient's whole part is exact, and sooner found.
                means[s, c] = np.int32((PARTS * sums[s, c] + counts[s] // 2) / counts[s])
    return means


@njit(cache=True, nogil=True)
def move_outlines(image: Array, superpixels: Array, means: Array) -> Array:
    """Return superpixels whose outline pixels went to the nearest mean colour beside them.

    means: (n, 3) int32, in eighths. All pixels go at once; of equally near ones the first stays:
    their own, then that to the left, right, above, below.
    """
    height, width = superpixels.shape
    factors, moved = _distance_factors(means), superpixels.copy()
    outline, sides = np.empty(width, np.uint32), np.empty(width, np.uint8)
    for v in range(height):
        lines = superpixels[v], superpixels[max(v - 1, 0)], superpixels[min(v + 1, height - 1)]
        _find_sides(lines, sides)
        n_found = 0
        for u in range(width):
            outline[n_found] = u
            n_found += int(sides[u] > 0)
        _move_pixels(image[v], lines, outline[:n_found], sides, factors, moved[v])
    return moved


@njit(cache=True, nogil=True)
def _move_pixels(
    pixels: Array, lines: Lines, outline: Array, sides: Array, factors: Array, moved: Array
) -> None:
    """Write to `moved` (w,) the nearest superpixel of the pixels `outline` of a line.

    Pixels beside their own superpixel are asked, too: a tie changes nothing.
    """
    line, upper, lower = lines
    last = line.size - 1
    for u in outline:
        first, second, third = pixels[u, 0], pixels[u, 1], pixels[u, 2]
        nearest = line[u]
        least = _distance(factors, nearest, first, second, third)
        if sides[u] & ACROSS:
            left, right = line[u - np.uint32(u > 0)], line[u + np.uint32(u < last)]
            distance = _distance(factors, left, first, second, third)
            nearest, least = left if distance < least else nearest, min(least, distance)
            distance = _distance(factors, right, first, second, third)
            nearest, least = right if distance < least else nearest, min(least, distance)
        if sides[u] & DOWN:
            distance = _distance(factors, upper[u], first, second, third)
            nearest, least = upper[u] if distance < least else nearest, min(least, distance)
            distance = _distance(factors, lower[u], first, second, third)
            nearest = lower[u] if distance < least else nearest
        moved[u] = nearest


@njit(cache=True, nogil=True)
def _find_sides(lines: Lines, sides: Array) -> None:
    """Write to `sides` (w,) whether a pixel has another superpixel beside it across or down."""
    line, upper, lower = lines
    last = line.size - 1
    for u in range(1, last):
        is_across = (line[u - 1] != line[u]) | (line[u + 1] != line[u])
        is_down = (upper[u] != line[u]) | (lower[u] != line[u])
        sides[u] = ACROSS * np.uint8(is_across) + DOWN * np.uint8(is_down)
    for u, beside in ((0, min(1, last)), (last, max(last - 1, 0))):
        is_down = (upper[u] != line[u]) | (lower[u] != line[u])
        sides[u] = ACROSS * np.uint8(line[beside] != line[u]) + DOWN * np.uint8(is_down)


@njit(cache=True, nogil=True)
def _distance_factors(means: Array) -> Array:
    """Return (n, 4) int32, by which `_distance` multiplies a colour, and what it adds."""
    factors = np.empty((len(means), 4), np.int32)
    for s in range(len(means)):
        factors[s, 3] = 0
        for c in range(3):
            factors[s, c] = -2 * PARTS * means[s, c]
            factors[s, 3] += means[s, c] * means[s, c]
    return factors


@njit(cache=True, nogil=True, inline="always")
def _distance(factors: Array, superpixel: int, first: int, second: int, third: int) -> Any:
    """Return the squared distance of a colour to a mean, in 64ths, less the colour's square: int32.

    That is the same for all means: whole numbers, which are compared as the distances are.
    """
    a, b, c = np.int32(first), np.int32(second), np.int32(third)
    s = np.uint32(superpixel)  # no index from the end: sooner
    return factors[s, 0] * a + factors[s, 1] * b + factors[s, 2] * c + factors[s, 3]
