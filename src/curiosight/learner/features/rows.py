"""An image as rows of features: the paper's 39, and the 15 of contrast behind them."""

from __future__ import annotations

import numpy as np

from curiosight.frame import Rgb
from curiosight.learner.features.colour import (
    N_FEATURES,
    RowOfPixel,
    Rows,
    RowsPer,
    describe_pixels,
    describe_superpixels,
)
from curiosight.learner.features.contrast import N_CONTRAST, describe_contrast
from curiosight.learner.features.superpixels import Superpixels


def count_features(*, contrast: bool) -> int:
    """Return how many features a row has: 39, or 54 with contrast."""
    return N_FEATURES + N_CONTRAST if contrast else N_FEATURES


def describe(
    image: Rgb, superpixels: Superpixels, *, rows_per: RowsPer, contrast: bool
) -> tuple[Rows, RowOfPixel]:
    """Return the features of an (h, w, 3) image: (n, F) uint8 rows and each pixel's row."""
    describe_colour = describe_pixels if rows_per == "pixel" else describe_superpixels
    rows, row_of_pixel = describe_colour(image, superpixels)
    if contrast:
        of_superpixels = describe_contrast(image, superpixels)
        rows = np.hstack([rows, of_superpixels[_superpixel_of_row(row_of_pixel, superpixels)]])
    return rows, row_of_pixel


def _superpixel_of_row(row_of_pixel: RowOfPixel, superpixels: Superpixels) -> RowOfPixel:
    """Return the one superpixel in which all pixels of a row lie; 0 for a row without pixels."""
    superpixel_of_row = np.zeros(row_of_pixel.max() + 1, np.int32)
    superpixel_of_row[row_of_pixel.ravel()] = superpixels.ravel()
    return superpixel_of_row
