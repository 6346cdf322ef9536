"""Sums over the pixels of each superpixel, of which all that describes them is made."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]
Sums = npt.NDArray[np.int64]


def sums_of(image: Array, superpixels: Array, sums: Sums | None = None) -> Sums:
    """Return `sums` where they are known, else those of all superpixels of an image."""
    if sums is None:
        sums = np.asarray(sum_superpixels(image, superpixels, int(superpixels.max()) + 1))
    return sums


@njit(cache=True, nogil=True)
def sum_colours(image: Array, superpixels: Array, n_superpixels: int) -> tuple[Array, Array]:
    """Return (n, 3) int32 sums of the colours of an (h, w, 3) uint8 image, and (n,) of pixels.

    Of at most 8 million pixels: beyond, sums may run over.
    """
    sums = np.zeros((n_superpixels, 3), np.int32)
    counts = np.zeros(n_superpixels, np.int32)
    height, width = superpixels.shape
    for v in range(height):
        # Pixels of one superpixel follow each other in a line: they are summed before memory is.
        start = 0
        first, second, third = np.int32(0), np.int32(0), np.int32(0)
        for u in range(width):
            first += image[v, u, 0]
            second += image[v, u, 1]
            third += image[v, u, 2]
            s = superpixels[v, u]
            if u + 1 == width or superpixels[v, u + 1] != s:
                counts[s] += u + 1 - start
                sums[s, 0] += first
                sums[s, 1] += second
                sums[s, 2] += third
                start = u + 1
                first, second, third = np.int32(0), np.int32(0), np.int32(0)
    return sums, counts


@njit(cache=True, nogil=True)
def sum_superpixels(image: Array, superpixels: Array, n_superpixels: int) -> Array:
    """Return (n, 9) int64 sums over pixels: 1, u, v, the three channels, and their squares."""
    sums = np.zeros((n_superpixels, 9), np.int64)
    height, width = superpixels.shape
    for v in range(height):
        start = 0
        first, second, third = np.int64(0), np.int64(0), np.int64(0)
        first_square, second_square, third_square = np.int64(0), np.int64(0), np.int64(0)
        for u in range(width):
            a, b, c = np.int64(image[v, u, 0]), np.int64(image[v, u, 1]), np.int64(image[v, u, 2])
            first += a
            second += b
            third += c
            first_square += a * a
            second_square += b * b
            third_square += c * c
            s = superpixels[v, u]
            if u + 1 == width or superpixels[v, u + 1] != s:
                n = u + 1 - start
                total = sums[s]
                total[0] += n
                total[1] += n * (start + u) // 2
                total[2] += n * v
                total[3] += first
                total[4] += second
                total[5] += third
                total[6] += first_square
                total[7] += second_square
                total[8] += third_square
                start = u + 1
                first, second, third = np.int64(0), np.int64(0), np.int64(0)
                first_square, second_square, third_square = np.int64(0), np.int64(0), np.int64(0)
    return sums
