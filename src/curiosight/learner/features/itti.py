"""The 42 maps of Itti, Koch and Niebur (PAMI 1998), which the authors' code knows too.

Intensity, red against green, blue against yellow, and orientations of 0°, 45°, 90° and 135°: the
difference between a pyramid's levels 2, 3 and 4, and those 3 and 4 coarser, is a map each. The
authors resize them to the shrunken image; here they are averaged over superpixels, and their
pyramid starts from the shrunken image.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb
from curiosight.learner.features.colour import Rows
from curiosight.learner.features.feature_set import FeatureSet, mean_of_pixels, to_bytes
from curiosight.learner.features.superpixels import Superpixels

Map = npt.NDArray[np.float32]

CENTRES, STEPS = (2, 3, 4), (3, 4)
ANGLES = (0, 45, 90, 135)
N_LEVELS = max(CENTRES) + max(STEPS) + 1
# A pixel has a hue only where it is brighter than this share of the brightest.
DIMMEST = 0.1
# Gabor's wave of K = π/2, under a bell of σ = 2π, √2 as wide along the wave's crests.
WAVELENGTH, SIGMA, ASPECT, KERNEL_SIDE = 4.0, 2 * np.pi, 1 / np.sqrt(2), 39
# Highest values that are told apart: intensity in grey levels, hues in intensities.
HIGHEST = {"intensity": 255.0, "red-green": 3.0, "blue-yellow": 3.0}


def itti() -> FeatureSet:
    """Return the set."""
    names = [*HIGHEST, *(f"orientation {angle}" for angle in ANGLES)]
    columns = tuple(
        f"{name} {centre}-{centre + step}"
        for name in names
        for centre, step in product(CENTRES, STEPS)
    )
    return FeatureSet("itti", columns, describe_itti)


def describe_itti(image: Rgb, superpixels: Superpixels) -> Rows:
    """Return (n, 42) uint8 rows of an RGB image: the maps' means over superpixels."""
    height, width = superpixels.shape
    columns = []
    for channel, highest in _channels(image):
        maps = [
            cv2.resize(contrast, (width, height), interpolation=cv2.INTER_LINEAR)
            for contrast in _contrasts(_pyramid(channel))
        ]
        columns.append(to_bytes(mean_of_pixels(maps, superpixels), 0, highest))
    return np.hstack(columns)


def _channels(image: Rgb) -> list[tuple[Map, float]]:
    """Return the seven channels, and the highest difference in each that is told apart."""
    colours = image.astype(np.float32)
    intensity: Map = colours.mean(axis=2)
    has_hue = intensity > DIMMEST * intensity.max()
    scale = np.where(has_hue, 1 / np.maximum(intensity, 1), 0)
    r, g, b = (colours[..., c] * scale for c in range(3))
    red, green, blue = (
        np.maximum(one - (two + three) / 2, 0)
        for one, two, three in ((r, g, b), (g, r, b), (b, r, g))
    )
    yellow = np.maximum((r + g) / 2 - np.abs(r - g) / 2 - b, 0)
    channels = zip((intensity, red - green, blue - yellow), HIGHEST.values(), strict=True)
    return [*channels, *((_orientation(intensity, angle), 255.0) for angle in ANGLES)]


def _orientation(intensity: Map, angle: int) -> Map:
    """Return how strongly an image is striped along an angle, in grey levels, at most 255."""
    size: Any = (KERNEL_SIDE, KERNEL_SIDE)
    kernel = cv2.getGaborKernel(size, SIGMA, np.deg2rad(angle), WAVELENGTH, ASPECT, 0)
    kernel -= kernel.mean()  # an even image has no stripes
    kernel /= np.abs(kernel).sum() / 2
    response: Map = np.abs(cv2.filter2D(intensity, cv2.CV_32F, kernel))
    return response


def _pyramid(channel: Map) -> list[Map]:
    levels = [channel]
    while len(levels) < N_LEVELS:
        levels.append(cv2.pyrDown(levels[-1]))
    return levels


def _contrasts(levels: list[Map]) -> list[Map]:
    """Return the differences between centres and surroundings, in the size of the centre."""
    contrasts = []
    for centre, step in product(CENTRES, STEPS):
        height, width = levels[centre].shape
        around = cv2.resize(levels[centre + step], (width, height), interpolation=cv2.INTER_LINEAR)
        contrasts.append(np.abs(levels[centre] - around))
    return contrasts
