"""15 features of centre and surround, which the mean colours of places cannot express.

A tree splits on one number at a time, so from the mean colours here and there it cannot learn
"unlike its surroundings". These numbers say it, as the contrasts of Itti, Koch and Niebur (PAMI
1998) do. The paper does not have them.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb
from curiosight.learner.features.colour import Rows
from curiosight.learner.features.superpixel_sums import Sums, sums_of
from curiosight.learner.features.superpixels import Superpixels

Array = npt.NDArray[Any]
Points = npt.NDArray[np.float64]

# Levels of the surroundings in the Gaussian pyramid: a pixel of them is 4, 8, 16 or 32 wide.
LEVELS = (2, 3, 4, 5)
N_CONTRAST = 3 * (len(LEVELS) + 1)


def describe_contrast(image: Rgb, superpixels: Superpixels, sums: Sums | None = None) -> Rows:
    """Return how each superpixel differs from its surroundings, and inside: (n, 15) uint8.

    First its mean colour minus that of its surroundings, three channels at each of four scales,
    plus 128: rows are 8-bit so that the forest finds splits exactly, and differences are kept
    whole and cut at ±128, which few reach, because most of them are small. Then twice the
    standard deviation of the three channels inside it, which is at most 255.

    sums: of the superpixels, see `sum_superpixels`; None = to be found.
    """
    counts, centres, colours, squares = np.split(
        sums_of(image, superpixels, sums), [1, 3, 6], axis=1
    )
    counts = np.maximum(counts, 1)
    means = colours / counts
    # Whole numbers up to the root: where all pixels are alike it is exactly 0.
    deviations = np.sqrt(counts * squares - colours**2) / counts
    differences = [means - there + 128 for there in _surroundings(image, centres / counts)]
    values = np.concatenate([*differences, 2 * deviations], axis=1)
    rows: Rows = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return rows


def _surroundings(image: Rgb, centres: Points) -> list[npt.NDArray[np.float32]]:
    """Return the (n, 3) smoothed colours at (n, 2) pixels (u, v), one array per level."""
    colours = []
    for level, smooth in zip(LEVELS, smoothed(image), strict=True):
        # pyrDown keeps the pixels 0, 2, 4, …: their middles, not their corners, coincide.
        u, v = centres.T / 2**level
        colours.append(_between_pixels(smooth, v, u))
    return colours


def _between_pixels(image: npt.NDArray[np.float32], v: Array, u: Array) -> npt.NDArray[np.float32]:
    """Return the (n, 3) colours at places between pixels, bilinearly; at the edge, the edge's."""
    v, u = (np.clip(at, 0, side - 1) for at, side in zip((v, u), image.shape, strict=False))
    top, left = v.astype(np.intp), u.astype(np.intp)
    below, right = (v - top)[:, None], (u - left)[:, None]
    bottom, beside = np.minimum(top + 1, len(image) - 1), np.minimum(left + 1, image.shape[1] - 1)
    upper = image[top, left] * (1 - below) * (1 - right) + image[top, beside] * (1 - below) * right
    lower = image[bottom, left] * below * (1 - right) + image[bottom, beside] * below * right
    colours: npt.NDArray[np.float32] = (upper + lower).astype(np.float32)
    return colours


def smoothed(image: Rgb) -> list[npt.NDArray[np.float32]]:
    """Return the surroundings at each of `LEVELS`: (h / 2^level, w / 2^level, 3) float32."""
    levels = []
    smaller = image.astype(np.float32)
    for level in range(1, max(LEVELS) + 1):
        smaller = cv2.pyrDown(smaller)
        if level in LEVELS:
            levels.append(cv2.GaussianBlur(smaller, (0, 0), 1.0))
    return levels
