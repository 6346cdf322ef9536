"""Four features of a superpixel's texture, of the pixels around its centroid."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb
from curiosight.learner.features.colour import Rows
from curiosight.learner.features.feature_set import FeatureSet
from curiosight.learner.features.superpixel_sums import Sums, sums_of
from curiosight.learner.features.superpixels import ColourSpace, Superpixels
from curiosight.learner.features.surroundings import box_at, byte, centroid

Array = npt.NDArray[Any]

# The box around the centroid has 2 · REACH + 1 pixels a side.
REACH = 4
VALUE, SQUARE, ACROSS, DOWN, FALLING, RISING = range(6)


def texture(colour_space: ColourSpace) -> FeatureSet:
    """Return the set; it is of the first channel, lightness in Lab."""
    columns = ("deviation around", "gradient", "gradient across", "gradient falling")
    return FeatureSet("texture", columns, describe_texture, colour_space, from_sums=True)


def describe_texture(image: Rgb, superpixels: Superpixels, sums: Sums | None = None) -> Rows:
    """Return (n, 4) uint8 rows, of the 9x9 pixels around centroids, in the first channel.

    Twice the standard deviation; 16 times the root of the mean gradient, across plus down; how
    much of it is across rather than down, and along which diagonal, where 128 is both alike.

    sums: of the superpixels, see `sum_superpixels`; None = to be found.
    """
    rows: Rows = _measure(sums_of(image, superpixels, sums), _sum_down(_widened(image)))
    return rows


@njit(cache=True, nogil=True)
def _widened(image: Array) -> Array:
    """Return (h + 2, w + 2) int16: the first channel, with its border once more around it."""
    height, width = image.shape[:2]
    wide = np.empty((height + 2, width + 2), np.int16)
    for v in range(height):
        line, pixels = wide[v + 1], image[v]
        for u in range(width):
            line[u + 1] = pixels[u, 0]
        line[0], line[width + 1] = line[1], line[width]
    wide[0], wide[height + 1] = wide[1], wide[height]
    return wide


@njit(cache=True, nogil=True)
def _sum_down(wide: Array) -> Array:
    """Return (h + 1, 6, w) int32 sums of what is above in a column.

    Of the channel, its square, and its changes in four directions. A change is the difference
    between the two neighbours of a pixel.
    """
    height, width = wide.shape[0] - 2, wide.shape[1] - 2
    sums = np.empty((height + 1, 6, width), np.int32)
    sums[0] = 0
    for v in range(height):
        above, line, below = wide[v], wide[v + 1], wide[v + 2]
        before, after = sums[v], sums[v + 1]
        _add_values(before, after, line[1 : width + 1])
        _add_changes(before[ACROSS], after[ACROSS], line[2:], line[:width])
        _add_changes(before[DOWN], after[DOWN], below[1 : width + 1], above[1 : width + 1])
        _add_changes(before[FALLING], after[FALLING], below[2:], above[:width])
        _add_changes(before[RISING], after[RISING], below[:width], above[2:])
    return sums


# Loops of few arrays each: then the compiler does several pixels at once.
@njit(cache=True, nogil=True)
def _add_values(before: Array, after: Array, line: Array) -> None:
    values, squares = before[VALUE], before[SQUARE]
    new_values, new_squares = after[VALUE], after[SQUARE]
    for u in range(line.size):
        new_values[u] = values[u] + np.int32(line[u])
    for u in range(line.size):
        new_squares[u] = squares[u] + np.int32(line[u]) * np.int32(line[u])


@njit(cache=True, nogil=True)
def _add_changes(before: Array, after: Array, one: Array, other: Array) -> None:
    for u in range(one.size):
        after[u] = before[u] + abs(np.int32(one[u]) - np.int32(other[u]))


@njit(cache=True, nogil=True, inline="always")
def _box_mean(sums: Array, box: tuple[int, int, int, int, float], kind: int) -> float:
    """Return the mean of one kind of sums in a box."""
    left, right, upper, lower, share = box
    last, first = sums[lower, kind], sums[upper, kind]
    total = np.int32(0)
    for u in range(left, right):
        total += last[u] - first[u]
    return share * total


@njit(cache=True, nogil=True)
def _measure(sums: Array, sums_down: Array) -> Array:
    """Return the row of each superpixel; 0 where it has no pixel."""
    height, width = sums_down.shape[0] - 1, sums_down.shape[2]
    rows = np.zeros((len(sums), 4), np.uint8)
    for s in range(len(sums)):
        if sums[s, 0] == 0:
            continue
        u, v = centroid(sums, s)
        box = box_at(height, width, u, v, REACH)
        mean = _box_mean(sums_down, box, VALUE)
        variance = max(_box_mean(sums_down, box, SQUARE) - mean * mean, 0.0)
        across, down = _box_mean(sums_down, box, ACROSS), _box_mean(sums_down, box, DOWN)
        falling, rising = _box_mean(sums_down, box, FALLING), _box_mean(sums_down, box, RISING)
        rows[s, 0] = byte(2 * np.sqrt(variance))
        rows[s, 1] = byte(16 * np.sqrt(across + down))
        # One level more than there is, so that noise on an even surface has no direction.
        rows[s, 2] = byte(128 + 127 * (across - down) / (across + down + 1))
        rows[s, 3] = byte(128 + 127 * (falling - rising) / (falling + rising + 1))
    return rows
