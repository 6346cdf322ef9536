"""The 39 features: mean colour of the superpixel here and at twelve places around (sec. II-A.1).

The mean map is read at the pixel, then 25, 50 and 100 pixels (of 320) to the left, right, up
and down of it; beyond the image its border repeats. 13 places x 3 channels, in the colour space of
the image that is given.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb
from curiosight.learner.features.superpixel_sums import sum_colours
from curiosight.learner.features.superpixels import Superpixels

Array = npt.NDArray[Any]
Rows = npt.NDArray[np.uint8]
RowOfPixel = npt.NDArray[np.int32]
RowsPer = Literal["pixel", "superpixel"]

DISTANCES = (25, 50, 100)
# (du, dv) in the order of the features: here, then left, right, up, down per distance.
PLACES = np.array(
    [(0, 0)] + [p for d in DISTANCES for p in ((-d, 0), (d, 0), (0, -d), (0, d))], np.int64
)
N_FEATURES = 3 * len(PLACES)


def describe_pixels(image: Rgb, superpixels: Superpixels) -> tuple[Rows, RowOfPixel]:
    """Return the features of every pixel, exactly, as distinct rows.

    Neighbouring pixels often read the same 13 superpixels, so a row stands for several:
    (n, 39) uint8 rows and the (h, w) int32 row of each pixel.
    """
    means = superpixel_means(image, superpixels, int(superpixels.max()) + 1)
    row_of_pixel, first = _share_rows(superpixels, PLACES)
    return _read_rows(means, superpixels, first, PLACES), row_of_pixel


def describe_superpixels(image: Rgb, superpixels: Superpixels) -> tuple[Rows, RowOfPixel]:
    """Return one row of features per superpixel: each feature's mean over its pixels.

    An approximation of `describe_pixels`, in which only three of the 39 are constant inside a
    superpixel; it has about 80 times fewer rows.
    """
    n_superpixels = int(superpixels.max()) + 1
    means = superpixel_means(image, superpixels, n_superpixels)
    return _mean_rows(means, superpixels, PLACES), superpixels


@njit(cache=True, nogil=True)
def superpixel_means(image: Array, superpixels: Array, n_superpixels: int) -> Array:
    """Return the (n, 3) uint8 mean colours of superpixels, rounded."""
    sums, counts = sum_colours(image, superpixels, n_superpixels)
    means = np.zeros((n_superpixels, 3), np.uint8)
    for s in range(n_superpixels):
        for c in range(3):
            if counts[s] > 0:
                means[s, c] = (2 * sums[s, c] + counts[s]) // (2 * counts[s])
    return means


@njit(cache=True, nogil=True)
def _share_rows(superpixels: Array, places: Array) -> tuple[Array, Array]:
    """Give pixels that read the same superpixels as their left or upper neighbour its row.

    Return the (h, w) int32 row of each pixel and the (n,) int64 first pixel of each row.
    """
    height, width = superpixels.shape
    row_of_pixel = np.empty((height, width), np.int32)
    first = np.empty(height * width, np.int64)
    n_rows = 0
    for v in range(height):
        for u in range(width):
            like_left = u > 0
            like_upper = v > 0
            for k in range(len(places)):
                x, y = u + places[k, 0], v + places[k, 1]
                row, column = min(max(y, 0), height - 1), min(max(x, 0), width - 1)
                here = superpixels[row, column]
                like_left &= here == superpixels[row, min(max(x - 1, 0), width - 1)]
                like_upper &= here == superpixels[min(max(y - 1, 0), height - 1), column]
                if not (like_left or like_upper):
                    break
            if like_left:
                row_of_pixel[v, u] = row_of_pixel[v, u - 1]
            elif like_upper:
                row_of_pixel[v, u] = row_of_pixel[v - 1, u]
            else:
                row_of_pixel[v, u] = n_rows
                first[n_rows] = v * width + u
                n_rows += 1
    return row_of_pixel, first[:n_rows]


@njit(cache=True, nogil=True)
def _read_rows(means: Array, superpixels: Array, pixels: Array, places: Array) -> Array:
    """Read the (n, 39) uint8 features of some pixels, given by their flat index."""
    height, width = superpixels.shape
    rows = np.empty((len(pixels), 3 * len(places)), np.uint8)
    for i in range(len(pixels)):
        v, u = pixels[i] // width, pixels[i] % width
        for k in range(len(places)):
            row = min(max(v + places[k, 1], 0), height - 1)
            column = min(max(u + places[k, 0], 0), width - 1)
            s = superpixels[row, column]
            for c in range(3):
                rows[i, 3 * k + c] = means[s, c]
    return rows


@njit(cache=True, nogil=True)
def _mean_rows(means: Array, superpixels: Array, places: Array) -> Array:
    """Average the features of all pixels of each superpixel: (n, 39) uint8, rounded."""
    height, width = superpixels.shape
    sums = np.zeros((len(means), 3 * len(places)), np.int32)
    counts = np.zeros(len(means), np.int32)
    for v in range(height):
        for u in range(width):
            counts[superpixels[v, u]] += 1
    for k in range(len(places)):
        for v in range(height):
            row = min(max(v + places[k, 1], 0), height - 1)
            for u in range(width):
                column = min(max(u + places[k, 0], 0), width - 1)
                s, there = superpixels[v, u], superpixels[row, column]
                for c in range(3):
                    sums[s, 3 * k + c] += means[there, c]
    rows = np.zeros((len(means), 3 * len(places)), np.uint8)
    for s in range(len(means)):
        for k in range(3 * len(places)):
            if counts[s] > 0:
                rows[s, k] = (2 * sums[s, k] + counts[s]) // (2 * counts[s])
    return rows
