"""What GBVS and the toolbox's Itti-Koch see of an image: pyramids, and stripes in them.

Both are in the toolbox of Harel, Koch and Perona (release of July 2012); its choices are kept,
also where the papers name others: intensity is the strongest of the three colours, and the
smoothing before a halving is cut and reweighted at the border.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb

Array = npt.NDArray[Any]

HALVING_KERNEL = np.array([1.0, 5.0, 10.0, 10.0, 5.0, 1.0])
SMALLEST_HALVED = 11
GABOR_RADIUS = 13
GABOR_WAVE_NUMBER = 2.0
GABOR_SIGMA_ACROSS, GABOR_SIGMA_ALONG = 2.0, 4.0


class Level(NamedTuple):
    """An image at one size: four (h, w) float32 planes in [0, 1]."""

    red: Array
    green: Array
    blue: Array
    intensity: Array


def pyramid(rgb: Rgb, n_levels: int) -> list[Level]:
    """Return the image and `n_levels` halvings of it: level k has 1 / 2^k of its width."""
    red, green, blue = cv2.split(rgb)
    intensity = np.maximum(np.maximum(red, green), blue)
    levels = [Level(*(plane.astype(np.float32) / 255 for plane in (red, green, blue, intensity)))]
    for _ in range(n_levels):
        levels.append(Level(*map(halved, levels[-1])))
    return levels


def halved(plane: Array) -> Array:
    """Return every second pixel of the smoothed float32 plane, (H // 2, W // 2).

    A plane of which a side has 10 pixels or less is returned as it is.
    """
    if min(plane.shape) < SMALLEST_HALVED:
        return plane
    narrowed = _halve_rows(np.ascontiguousarray(plane.T), HALVING_KERNEL)
    half: Array = _halve_rows(np.ascontiguousarray(narrowed.T), HALVING_KERNEL)
    return half


@njit(cache=True, nogil=True)
def _halve_rows(plane: Array, kernel: Array) -> Array:
    """Return (H // 2, W) float32: weighted means of six rows, or of those that exist."""
    height, width = plane.shape
    half = np.empty((height // 2, width), np.float32)
    total = np.empty(width, np.float64)
    for k in range(height // 2):
        first = 2 * k - 2
        total[:] = 0
        weight = 0.0
        for row in range(max(first, 0), min(first + len(kernel), height)):
            share = kernel[row - first]
            weight += share
            for u in range(width):
                total[u] += share * plane[row, u]
        for u in range(width):
            half[k, u] = total[u] / weight
    return half


def _fast_length(least: int) -> int:
    """Return the first length from there on that only 2, 3, 5 and 7 divide: fast to transform."""
    length = least
    while True:
        rest = length
        for prime in (2, 3, 5, 7):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return length
        length += 1


def gabor_energy(intensity: Array, angle_deg: float) -> Array:
    """Return how strongly stripes of one direction show at each pixel, 0 at the border.

    The absolute responses to an even and to an odd Gabor filter are added.
    """
    radius = GABOR_RADIUS
    padded = np.pad(intensity.astype(np.float64), radius, mode="edge")
    size = [_fast_length(side) for side in padded.shape]
    # The even filter's response is the real part, the odd one's the imaginary part.
    spectrum = np.fft.fft2(padded, size) * _gabor_spectrum(angle_deg, *size)
    height, width = intensity.shape
    response = np.fft.ifft2(spectrum)[2 * radius :, 2 * radius :][:height, :width]
    return attenuated_border(np.abs(response.real) + np.abs(response.imag), radius)


@lru_cache(maxsize=64)
def _gabor_spectrum(angle_deg: float, height: int, width: int) -> Array:
    even, odd = _gabor_filter(angle_deg, 0.0), _gabor_filter(angle_deg, np.pi / 2)
    spectrum: Array = np.fft.fft2(even + 1j * odd, (height, width))
    return spectrum


def _gabor_filter(angle_deg: float, phase: float) -> Array:
    """Return a (27, 27) Gabor filter of mean 0 and Euclidean norm 1."""
    angle = np.deg2rad(angle_deg)
    y, x = np.mgrid[-GABOR_RADIUS : GABOR_RADIUS + 1, -GABOR_RADIUS : GABOR_RADIUS + 1]
    across = y * np.cos(angle) - x * np.sin(angle)
    along = -y * np.sin(angle) - x * np.cos(angle)
    envelope = np.exp(
        -(across**2) / (2 * GABOR_SIGMA_ACROSS**2) - along**2 / (2 * GABOR_SIGMA_ALONG**2)
    )
    gabor = np.cos(GABOR_WAVE_NUMBER * across + phase) * envelope
    gabor -= gabor.mean()
    normed: Array = gabor / np.linalg.norm(gabor)
    return normed


def attenuated_border(image: Array, n_pixels: int) -> Array:
    """Return the image with its outermost `n_pixels` faded towards 0.

    No more than half the shorter side is faded, along both sides.
    """
    n_faded = min(n_pixels, min(image.shape) // 2)
    ramps = []
    for side in image.shape:
        from_edge = np.minimum(np.arange(side), np.arange(side)[::-1]) + 1
        ramps.append(np.minimum(from_edge / (n_faded + 1), 1))
    faded: Array = image * ramps[0][:, None] * ramps[1]
    return faded
