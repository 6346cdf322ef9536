"""Resizing as MATLAB's imresize does it by default, to the last digit.

Neither OpenCV nor Octave agrees with it: shrinking widens the cubic kernel against aliasing, the
weights of each pixel are made to sum to 1, and beyond its edge the image is mirrored.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

CUBIC_REACH = 2  # samples to either side
CUBIC_SLOPE = -0.5


def bicubic(image: npt.NDArray[Any], size: tuple[int, int]) -> Array:
    """Return an (H, W) image in another (height, width)."""
    rows = _weights(image.shape[0], size[0], size[0] / image.shape[0])
    columns = _weights(image.shape[1], size[1], size[1] / image.shape[1])
    resized: Array = rows @ image.astype(np.float64) @ columns.T
    return resized


def bicubic_to_width(image: npt.NDArray[Any], width: int) -> Array:
    """Return an (H, W) image in another width, and in as many rows as are begun.

    Both axes are scaled alike, so the last row may reach beyond the image.
    """
    scale = width / image.shape[1]
    rows = _weights(image.shape[0], int(np.ceil(width * image.shape[0] / image.shape[1])), scale)
    columns = _weights(image.shape[1], width, scale)
    resized: Array = rows @ image.astype(np.float64) @ columns.T
    return resized


@lru_cache(maxsize=64)
def _weights(n_from: int, n_to: int, scale: float) -> Array:
    """Return the (n_to, n_from) weights of one axis; each row sums to 1."""
    stretch = max(1.0, 1 / scale)
    middles = (np.arange(n_to) + 0.5) / scale - 0.5
    reach = int(np.ceil(CUBIC_REACH * stretch)) + 1
    samples = np.floor(middles).astype(np.int64)[:, None] + np.arange(-reach, reach + 1)
    values = _cubic((middles[:, None] - samples) / stretch)
    values /= values.sum(axis=1, keepdims=True)
    # Beyond the edge the image is mirrored, its outermost sample twice: ... 1 0 | 0 1 2 ...
    around = samples % (2 * n_from)
    mirrored = np.minimum(around, 2 * n_from - 1 - around)
    weights = np.zeros((n_to, n_from))
    np.add.at(weights, (np.arange(n_to)[:, None], mirrored), values)
    weights.setflags(write=False)
    return weights


def _cubic(distance: Array) -> Array:
    """Return Keys' cubic kernel (1981) at distances in samples."""
    x = np.abs(distance)
    near = ((CUBIC_SLOPE + 2) * x - (CUBIC_SLOPE + 3)) * x**2 + 1
    far = CUBIC_SLOPE * (((x - 5) * x + 8) * x - 4)
    return np.where(x <= 1, near, np.where(x <= CUBIC_REACH, far, 0.0))
