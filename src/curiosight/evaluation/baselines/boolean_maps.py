"""Boolean maps of an image, and what is surrounded in them (Zhang and Sclaroff, ICCV 2013).

The thresholds t_0 < t_1 < … cut a grey image f into Boolean maps f > t_k. In each, a pixel is
surrounded if no path of pixels of its own value, 8-connected, leads to the border of the image.

All of them are found at once. Write q for the number of thresholds below a pixel, so that
f > t_k means k < q. On the best path to the border the lowest q is U at most, the highest V at
least: then the pixel is surrounded in exactly the maps U <= k < V. The maps of a pixel are the
bits of one 64-bit word.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]
Levels = npt.NDArray[np.uint8]
Words = npt.NDArray[np.uint64]

MAX_THRESHOLDS = 64
# BELOW[k] has the bits 0 … k - 1.
BELOW = np.array([(1 << k) - 1 for k in range(MAX_THRESHOLDS + 1)], np.uint64)
BITS_OF_BYTE = (np.arange(256)[:, None] >> np.arange(8)) & 1


def thresholds_of(channel: Levels, step: int) -> Levels:
    """Return the thresholds of a channel, from its minimum in steps, below its maximum."""
    if not 4 <= step <= 255:
        raise ValueError(f"step: expected 4 to 255 grey levels, got {step}")
    return np.arange(int(channel.min()), int(channel.max()), step).astype(np.uint8)


def levels_of(channel: Levels, thresholds: Levels) -> Levels:
    """Return how many thresholds lie below each pixel, with a frame of one pixel around."""
    below = np.searchsorted(thresholds, np.arange(256)).astype(np.uint8)
    framed: Levels = cv2.copyMakeBorder(
        cv2.LUT(channel, below), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0
    )
    return framed


def reach_of(levels: Levels, n_thresholds: int) -> tuple[Levels, Levels]:
    """Return U and V of each pixel of framed levels: surrounded are the maps U <= k < V."""
    top = np.uint8(n_thresholds)
    lowest: Levels = flood_from_border(levels, n_thresholds)
    highest: Levels = top - flood_from_border(top - levels, n_thresholds)
    return lowest, highest


@njit(cache=True, nogil=True)
def maps_between(low: Array, high: Array) -> Array:
    """Return for each pixel a word whose bits low, …, high - 1 are set."""
    words = np.empty(low.shape, np.uint64)
    flat_words, flat_low, flat_high = words.ravel(), low.ravel(), high.ravel()
    for pixel in range(words.size):
        flat_words[pixel] = BELOW[flat_high[pixel]] ^ BELOW[flat_low[pixel]]
    return words


@njit(cache=True, nogil=True)
def flood_from_border(levels: Array, n_levels: int) -> Array:
    """Return for each pixel the highest level from which water at the border reaches it.

    levels: (H + 2, W + 2) uint8, its frame is not read. Of all 8-connected paths to the border
    the result is that of the best, and of a path the lowest level.
    """
    height, width = levels.shape
    ground = levels.ravel()
    reached = np.zeros(height * width, np.uint8)
    is_open = np.zeros((height, width), np.bool_)
    is_open[2:-2, 2:-2] = True
    is_dry = is_open.ravel()
    # One linked list of pixels per level: its first pixel, and the next of each pixel.
    first = np.full(n_levels + 1, -1, np.int32)
    following = np.empty(height * width, np.int32)
    for v in range(1, height - 1):
        stride = 1 if v in (1, height - 2) else max(width - 3, 1)
        for pixel in range(v * width + 1, v * width + width - 1, stride):
            level = ground[pixel]
            reached[pixel] = level
            following[pixel] = first[level]
            first[level] = pixel
    around = (-width - 1, -width, 1 - width, -1, 1, width - 1, width, width + 1)
    for level in range(n_levels, -1, -1):
        while first[level] >= 0:
            pixel = first[level]
            first[level] = following[pixel]
            for offset in around:
                neighbour = pixel + offset
                if is_dry[neighbour]:
                    is_dry[neighbour] = False
                    here = min(level, ground[neighbour])
                    reached[neighbour] = here
                    following[neighbour] = first[here]
                    first[here] = neighbour
    return reached.reshape(height, width)


@njit(cache=True, nogil=True)
def dilate(words: Array, reach: int) -> Array:
    """Dilate every map by a square of 2 reach + 1 pixels; beyond the image there is nothing."""
    height, width = words.shape
    across = words.copy()
    for v in range(height):
        for offset in range(1, min(reach, width - 1) + 1):
            for u in range(width - offset):
                across[v, u] |= words[v, u + offset]
            for u in range(offset, width):
                across[v, u] |= words[v, u - offset]
    dilated = across.copy()
    for v in range(height):
        for other in range(max(v - reach, 0), min(v + reach + 1, height)):
            for u in range(width):
                dilated[v, u] |= across[other, u]
    return dilated


def add_maps(total: npt.NDArray[np.float64], words: Words, *, by_norm: bool) -> None:
    """Add every map to the total in place: as it is, or divided by its Euclidean norm.

    As with the original's min-max normalisation, a map of ones adds nothing as it is.
    """
    counts = (_count_bytes(words) @ BITS_OF_BYTE).ravel()
    weights = np.zeros(MAX_THRESHOLDS)
    if by_norm:
        weights[counts > 0] = 1 / np.sqrt(counts[counts > 0])
    else:
        weights[(counts > 0) & (counts < words.size)] = 1
    _add_weighted(total, words, weights.reshape(8, 8) @ BITS_OF_BYTE.T)


@njit(cache=True, nogil=True)
def _count_bytes(words: Array) -> Array:
    """Return how often each value but 0 is one of the words' bytes, (8, 256)."""
    counts = np.zeros((8, 256), np.int64)
    for word in words.ravel():
        rest = word
        byte = 0
        while rest != np.uint64(0):
            counts[byte, rest & np.uint64(255)] += 1
            rest >>= np.uint64(8)
            byte += 1
    return counts


@njit(cache=True, nogil=True)
def _add_weighted(total: Array, words: Array, weights: Array) -> None:
    """Add to each pixel what the (8, 256) weights say of the bytes of its word."""
    sums, flat = total.ravel(), words.ravel()
    for pixel in range(flat.size):
        rest = flat[pixel]
        byte = 0
        while rest != np.uint64(0):
            sums[pixel] += weights[byte, rest & np.uint64(255)]
            rest >>= np.uint64(8)
            byte += 1
