"""An image as rows of features: sets side by side, a row a superpixel or a pixel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from curiosight.frame import Rgb
from curiosight.learner.features.colour import RowOfPixel, Rows, RowsPer, describe_pixels
from curiosight.learner.features.feature_set import FeatureSet
from curiosight.learner.features.sets import COLOURS
from curiosight.learner.features.superpixel_sums import Sums, sums_of
from curiosight.learner.features.superpixels import ColourSpace, Superpixels, to_colour_space


class Picture:
    """An (h, w, 3) uint8 RGB image, brought to other colour spaces, and summed, once each."""

    def __init__(self, rgb: Rgb) -> None:
        self._images: dict[str, Rgb] = {"rgb": rgb}
        self._sums: dict[str, Sums] = {}

    def of_space(self, colour_space: ColourSpace) -> Rgb:
        """Return the image in a colour space."""
        if colour_space not in self._images:
            self._images[colour_space] = to_colour_space(self._images["rgb"], colour_space)
        return self._images[colour_space]

    def rows_of(self, one: FeatureSet, superpixels: Superpixels) -> Rows:
        """Return the rows of a set; the superpixels are the same whenever it is called."""
        image = self.of_space(one.colour_space)
        if one.from_sums and one.colour_space not in self._sums:
            self._sums[one.colour_space] = sums_of(image, superpixels)
        return one(image, superpixels, self._sums.get(one.colour_space))


def describe(
    picture: Picture, superpixels: Superpixels, sets: Sequence[FeatureSet], *, rows_per: RowsPer
) -> tuple[Rows, RowOfPixel]:
    """Return the features of an image by some sets: (n, F) uint8 rows and each pixel's row.

    rows_per: "pixel" describes every pixel exactly, where the first set is `colours`. By other
        sets, all pixels of a superpixel have the same features either way.
    """
    if rows_per == "superpixel" or sets[0].name != COLOURS:
        parts = [picture.rows_of(one, superpixels) for one in sets]
        return _side_by_side(parts), superpixels
    rows, row_of_pixel = describe_pixels(picture.of_space(sets[0].colour_space), superpixels)
    superpixel_of_row = _superpixel_of_row(row_of_pixel, superpixels)
    parts = [picture.rows_of(one, superpixels) for one in sets[1:]]
    return _side_by_side([rows, *(part[superpixel_of_row] for part in parts)]), row_of_pixel


def _side_by_side(parts: list[Rows]) -> Rows:
    return parts[0] if len(parts) == 1 else np.hstack(parts)


def _superpixel_of_row(row_of_pixel: RowOfPixel, superpixels: Superpixels) -> RowOfPixel:
    """Return the one superpixel in which all pixels of a row lie; 0 for a row without pixels."""
    superpixel_of_row = np.zeros(row_of_pixel.max() + 1, np.int32)
    superpixel_of_row[row_of_pixel.ravel()] = superpixels.ravel()
    return superpixel_of_row
