"""Four features of a superpixel's texture, of the pixels around its centroid."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb
from curiosight.learner.features.colour import Rows
from curiosight.learner.features.feature_set import FeatureSet
from curiosight.learner.features.superpixel_sums import sum_superpixels
from curiosight.learner.features.superpixels import ColourSpace, Superpixels
from curiosight.learner.features.surroundings import (
    box_at,
    box_mean,
    byte,
    centroid,
    integrate,
)

Array = npt.NDArray[Any]

# The box around the centroid has 2 · REACH + 1 pixels a side.
REACH = 4
VALUE, SQUARE, ACROSS, DOWN, FALLING, RISING = range(6)


def texture(colour_space: ColourSpace) -> FeatureSet:
    """Return the set; it is of the first channel, lightness in Lab."""
    columns = ("deviation around", "gradient", "gradient across", "gradient falling")
    return FeatureSet("texture", columns, describe_texture, colour_space)


def describe_texture(image: Rgb, superpixels: Superpixels) -> Rows:
    """Return (n, 4) uint8 rows, of the 9x9 pixels around centroids, in the first channel.

    Twice the standard deviation; 16 times the root of the mean gradient, across plus down; how
    much of it is across rather than down, and along which diagonal, where 128 is both alike.
    """
    n_superpixels = int(superpixels.max()) + 1
    sums = sum_superpixels(image, superpixels, n_superpixels)
    rows: Rows = _measure(sums, integrate(_changes(image)))
    return rows


@njit(cache=True, nogil=True)
def _changes(image: Array) -> Array:
    """Return (h, w, 6) int32: the first channel, its square, and its changes in four directions.

    A change is the difference between the two neighbours of a pixel; the border repeats.
    """
    height, width = image.shape[:2]
    changes = np.empty((height, width, 6), np.int32)
    for v in range(height):
        above, below = max(v - 1, 0), min(v + 1, height - 1)
        for u in range(width):
            left, right = max(u - 1, 0), min(u + 1, width - 1)
            value = np.int32(image[v, u, 0])
            pixel = changes[v, u]
            pixel[VALUE], pixel[SQUARE] = value, value * value
            pixel[ACROSS] = abs(np.int32(image[v, right, 0]) - np.int32(image[v, left, 0]))
            pixel[DOWN] = abs(np.int32(image[below, u, 0]) - np.int32(image[above, u, 0]))
            pixel[FALLING] = abs(np.int32(image[below, right, 0]) - np.int32(image[above, left, 0]))
            pixel[RISING] = abs(np.int32(image[below, left, 0]) - np.int32(image[above, right, 0]))
    return changes


@njit(cache=True, nogil=True)
def _measure(sums: Array, integrals: Array) -> Array:
    """Return the row of each superpixel; 0 where it has no pixel."""
    rows = np.zeros((len(sums), 4), np.uint8)
    for s in range(len(sums)):
        if sums[s, 0] == 0:
            continue
        u, v = centroid(sums, s)
        box = box_at(integrals, u, v, REACH)
        mean = box_mean(integrals, box, VALUE)
        variance = max(box_mean(integrals, box, SQUARE) - mean * mean, 0.0)
        across, down = box_mean(integrals, box, ACROSS), box_mean(integrals, box, DOWN)
        falling, rising = box_mean(integrals, box, FALLING), box_mean(integrals, box, RISING)
        rows[s, 0] = byte(2 * np.sqrt(variance))
        rows[s, 1] = byte(16 * np.sqrt(across + down))
        # One level more than there is, so that noise on an even surface has no direction.
        rows[s, 2] = byte(128 + 127 * (across - down) / (across + down + 1))
        rows[s, 3] = byte(128 + 127 * (falling - rising) / (falling + rising + 1))
    return rows
