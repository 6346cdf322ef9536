"""Sums over the pixels of each superpixel, of which all that describes them is made."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]


@njit(cache=True, nogil=True)
def sum_colours(image: Array, superpixels: Array, n_superpixels: int) -> tuple[Array, Array]:
    """Return (n, 3) int32 sums of the colours of an (h, w, 3) uint8 image, and (n,) of pixels.

    Of at most 8 million pixels: beyond, sums may run over.
    """
    sums = np.zeros((n_superpixels, 3), np.int32)
    counts = np.zeros(n_superpixels, np.int32)
    height, width = superpixels.shape
    for v in range(height):
        for u in range(width):
            s = superpixels[v, u]
            counts[s] += 1
            for c in range(3):
                sums[s, c] += image[v, u, c]
    return sums, counts


@njit(cache=True, nogil=True)
def sum_superpixels(image: Array, superpixels: Array, n_superpixels: int) -> Array:
    """Return (n, 9) int64 sums over pixels: 1, u, v, the three channels, and their squares."""
    sums = np.zeros((n_superpixels, 9), np.int64)
    height, width = superpixels.shape
    for v in range(height):
        for u in range(width):
            total = sums[superpixels[v, u]]
            total[0] += 1
            total[1] += u
            total[2] += v
            for c in range(3):
                value = np.int64(image[v, u, c])
                total[3 + c] += value
                total[6 + c] += value * value
    return sums
