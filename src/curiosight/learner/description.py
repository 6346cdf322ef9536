"""An image as rows of features, and maps and labels of the size that it is described in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Label, Pose, Rgb
from curiosight.learner.features import RowOfPixel, Rows
from curiosight.learner.looks import Look
from curiosight.learner.sight import Sight

Array = npt.NDArray[Any]
Saliency = npt.NDArray[np.float32]
Labels = npt.NDArray[np.uint8]
Counts = npt.NDArray[np.int64]

# Kernels know numbers, no classes.
SALIENT, NOT_SALIENT = int(Label.SALIENT), int(Label.NOT_SALIENT)


@dataclass(frozen=True, slots=True, eq=False)
class Description:
    """An image as rows of features.

    rows: (n, F) uint8, a column a feature.
    row_of_pixel: (h, w) int32, the row of each pixel of the shrunken image.
    look: of the image as a whole, see `look_of`; None where places are not told apart.
    """

    rows: Rows
    row_of_pixel: RowOfPixel
    look: Look | None = None

    def count(self, labels: Labels) -> tuple[Counts, Counts]:
        """Return how many salient and how many not salient pixels each row stands for.

        labels: (h, w), see `fit_labels`.
        """
        salient, other = np.zeros((2, len(self.rows)), np.int64)
        _count_labels(self.row_of_pixel, labels, salient, other)
        return salient, other


@njit(cache=True, nogil=True)
def _count_labels(row_of_pixel: Array, labels: Array, salient: Array, other: Array) -> None:
    """Add to (n,) counts the pixels of each row."""
    for v in range(row_of_pixel.shape[0]):
        n_salient, n_other = 0, 0
        for u in range(row_of_pixel.shape[1]):
            n_salient += int(labels[v, u] == SALIENT)
            n_other += int(labels[v, u] == NOT_SALIENT)
            # Pixels of one row follow each other in a line.
            row = row_of_pixel[v, u]
            if u + 1 == row_of_pixel.shape[1] or row_of_pixel[v, u + 1] != row:
                salient[row] += n_salient
                other[row] += n_other
                n_salient, n_other = 0, 0


def sight_of(description: Description, T_world_camera: Pose | None) -> Sight | None:
    """Return what tells the place of a view without looking at its depth."""
    return None if description.look is None else Sight(description.look, T_world_camera)


def enlarge(small: Saliency, rgb: Rgb) -> Saliency:
    """Bring an (h, w) map to the size of an (H, W, 3) image."""
    height, width = rgb.shape[:2]
    enlarged: Saliency = cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)
    return enlarged


def fit_labels(labels: Labels, description: Description) -> Labels:
    """Bring (H, W) labels to the size of a description's image; each pixel keeps one label."""
    height, width = description.row_of_pixel.shape
    fitted: Labels = cv2.resize(labels, (width, height), interpolation=cv2.INTER_NEAREST)
    return fitted
