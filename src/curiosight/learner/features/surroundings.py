"""58 features of a superpixel and its surroundings, in two passes over the image.

What the 39 colours say of superpixels is said here of boxes, whose sums an integral image gives at
once; and so is which surroundings are darker. The contrasts are those of the set `contrast`.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb
from curiosight.learner.features.colour import PLACES, Rows
from curiosight.learner.features.contrast import LEVELS, smoothed
from curiosight.learner.features.feature_set import FeatureSet
from curiosight.learner.features.superpixel_sums import Sums, sums_of
from curiosight.learner.features.superpixels import ColourSpace, Superpixels

Array = npt.NDArray[Any]

CHANNELS = {"rgb": ("red", "green", "blue"), "lab": ("L", "a", "b")}
# The box of a place has 2 · PLACE_REACH + 1 pixels a side.
PLACE_REACH = 4
# Pixels from the centroid to the eight boxes of a pattern, whose reach is half of it.
RINGS = (7, 18)
# Directions of a ring in turn: right, down and right, down, …
RING_PLACES = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
# Levels by which a box of a pattern must be darker: less is noise.
DARKER = 2


def surroundings(colour_space: ColourSpace) -> FeatureSet:
    """Return the set; patterns are of the first channel, lightness in Lab."""
    channels = CHANNELS[colour_space]
    names = [f"{channel} here" for channel in channels]
    names += [f"{channel} deviation" for channel in channels]
    names += [f"{channel} at {u:+d} {v:+d}" for u, v in PLACES[1:].tolist() for channel in channels]
    names += [f"{channel} contrast {2**level}" for level in LEVELS for channel in channels]
    names += [f"{what} at {ring}" for ring in RINGS for what in ("darker", "turns")]
    columns = tuple(names)
    return FeatureSet("surroundings", columns, describe_surroundings, colour_space, from_sums=True)


def describe_surroundings(image: Rgb, superpixels: Superpixels, sums: Sums | None = None) -> Rows:
    """Return (n, 58) uint8 rows.

    Of the superpixel: mean and twice the standard deviation of the three channels. Of boxes of
    9x9 pixels at the twelve places of the paper: the mean colour. Of four scales: the mean colour
    of the superpixel minus the smoothed one at its centroid, plus 128.

    Of eight boxes on each of two rings, in the first channel: 31 times how many are darker than
    the superpixel, and 31 times how often this changes around the ring.

    A box that leaves the image is cut by its border, and a place beyond it lies on it.

    sums: of the superpixels, see `sum_superpixels`; None = to be found.
    """
    sums = sums_of(image, superpixels, sums)
    integrals = cv2.integral(image)
    at_contrasts = 6 + 3 * (len(PLACES) - 1)
    at_patterns = at_contrasts + 3 * len(LEVELS)
    rows = np.zeros((len(sums), at_patterns + 2 * len(RINGS)), np.uint8)
    _write_colours(rows, sums, integrals)
    for number, (level, smooth) in enumerate(zip(LEVELS, smoothed(image), strict=True)):
        _write_contrast(rows, at_contrasts + 3 * number, sums, smooth, 2**level)
    _write_patterns(rows, at_patterns, sums, integrals)
    return rows


def height_in_image(colour_space: ColourSpace) -> FeatureSet:
    """Return the set of one column: how far down the superpixel lies, 0 at the top.

    colour_space: of the image whose sums it shares; it changes nothing else.
    """
    return FeatureSet("height", ("height",), describe_height, colour_space, from_sums=True)


def describe_height(image: Rgb, superpixels: Superpixels, sums: Sums | None = None) -> Rows:
    """Return (n, 1) uint8: the mean line of a superpixel's pixels, of 255 at the last.

    sums: of the superpixels, see `sum_superpixels`; None = to be found.
    """
    rows: Rows = _mean_lines(sums_of(image, superpixels, sums), len(superpixels))
    return rows


@njit(cache=True, nogil=True)
def _mean_lines(sums: Array, height: int) -> Array:
    rows = np.zeros((len(sums), 1), np.uint8)
    for s in range(len(sums)):
        if sums[s, 0] > 0:
            rows[s, 0] = byte(255 * sums[s, 2] / (sums[s, 0] * max(height - 1, 1)))
    return rows


@njit(cache=True, nogil=True)
def _write_colours(rows: Array, sums: Array, integrals: Array) -> None:
    """Write means, deviations, and the mean colours of twelve places around."""
    height, width = integrals.shape[0] - 1, integrals.shape[1] - 1
    for s in range(len(rows)):
        n = sums[s, 0]
        if n == 0:
            continue
        row = rows[s]
        for c in range(3):
            total = sums[s, 3 + c]
            row[c] = byte(total / n)
            row[3 + c] = byte(2 * np.sqrt(n * sums[s, 6 + c] - total * total) / n)
        u, v = centroid(sums, s)
        for k in range(1, len(PLACES)):
            x, y = _inside(height, width, u + PLACES[k, 0], v + PLACES[k, 1])
            box = box_at(height, width, x, y, PLACE_REACH)
            for c in range(3):
                row[3 + 3 * k + c] = byte(_box_mean(integrals, box, c))


@njit(cache=True, nogil=True)
def _write_contrast(rows: Array, at: int, sums: Array, smooth: Array, scale: int) -> None:
    """Write mean colours minus smoothed ones, of an image of 1 / scale of the size, plus 128.

    The smoothed image is interpolated linearly; beyond it, its border repeats.
    """
    height, width, _ = smooth.shape
    for s in range(len(rows)):
        n = sums[s, 0]
        if n == 0:
            continue
        u, v = sums[s, 1] / (n * scale), sums[s, 2] / (n * scale)
        left, upper = min(int(u), width - 1), min(int(v), height - 1)
        right, lower = min(left + 1, width - 1), min(upper + 1, height - 1)
        across, down = u - left, v - upper
        for c in range(3):
            above = smooth[upper, left, c] * (1 - across) + smooth[upper, right, c] * across
            below = smooth[lower, left, c] * (1 - across) + smooth[lower, right, c] * across
            around = above * (1 - down) + below * down
            rows[s, at + c] = byte(sums[s, 3 + c] / n - around + 128)


@njit(cache=True, nogil=True, inline="always")
def centroid(sums: Array, superpixel: int) -> tuple[int, int]:
    """Return the pixel (u, v) next to a superpixel's centroid."""
    n = sums[superpixel, 0]
    return (2 * sums[superpixel, 1] + n) // (2 * n), (2 * sums[superpixel, 2] + n) // (2 * n)


@njit(cache=True, nogil=True, inline="always")
def byte(value: float) -> np.uint8:
    """Return the nearest whole number, halves rounded up, cut to 0 to 255."""
    return np.uint8(min(max(value + 0.5, 0.0), 255.0))


@njit(cache=True, nogil=True, inline="always")
def box_at(height: int, width: int, u: int, v: int, reach: int) -> tuple[int, int, int, int, float]:
    """Return first and last + 1 column and line of a box in the image, and 1 / its pixels."""
    left, right = max(u - reach, 0), min(u + reach + 1, width)
    upper, lower = max(v - reach, 0), min(v + reach + 1, height)
    return left, right, upper, lower, 1.0 / ((right - left) * (lower - upper))


@njit(cache=True, nogil=True, inline="always")
def _box_mean(integrals: Array, box: tuple[int, int, int, int, float], channel: int) -> float:
    """Return the mean of one channel in a box.

    integrals: (h + 1, w + 1, 3) int32 sums of all pixels above and to the left. They may run over,
    but differences of them are right for boxes whose own sums do not.
    """
    left, right, upper, lower, share = box
    return share * np.int32(
        integrals[lower, right, channel]
        - integrals[upper, right, channel]
        - integrals[lower, left, channel]
        + integrals[upper, left, channel]
    )


@njit(cache=True, nogil=True, inline="always")
def _inside(height: int, width: int, u: int, v: int) -> tuple[int, int]:
    """Return the pixel of the image that is nearest to a place."""
    return min(max(u, 0), width - 1), min(max(v, 0), height - 1)


@njit(cache=True, nogil=True)
def _write_patterns(rows: Array, at: int, sums: Array, integrals: Array) -> None:
    """Write how many boxes of each ring are darker, and how often that changes around it."""
    height, width = integrals.shape[0] - 1, integrals.shape[1] - 1
    for s in range(len(rows)):
        if sums[s, 0] == 0:
            continue
        u, v = centroid(sums, s)
        threshold = sums[s, 3] / sums[s, 0] - DARKER
        for number, ring in enumerate(RINGS):
            n_darker, n_turns, first, last = 0, 0, False, False
            for k in range(8):
                x, y = u + ring * RING_PLACES[k][0], v + ring * RING_PLACES[k][1]
                x, y = _inside(height, width, x, y)
                box = box_at(height, width, x, y, ring // 2)
                is_darker = _box_mean(integrals, box, 0) < threshold
                n_darker += is_darker
                if k == 0:
                    first = is_darker
                elif is_darker != last:
                    n_turns += 1
                last = is_darker
            rows[s, at + 2 * number] = 31 * n_darker
            rows[s, at + 2 * number + 1] = 31 * (n_turns + (first != last))
