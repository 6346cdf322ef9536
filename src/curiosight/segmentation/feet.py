"""Feet: what of an object lies within its support's slab, and does not face up as that does."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from curiosight.segmentation.planes import Mask
from curiosight.segmentation.points import Points

Array = npt.NDArray[Any]
# Lower than this (metres) a point in the crease may be either's.
MIN_FOOT_HEIGHT = 0.006


def join_feet(
    number: Array, are_objects: Array, free: Mask, heights: Array, points: Points, noise: float
) -> None:
    """Give the points straight below an object in the image, down to its support, its number.

    Changes (h, w) int32 `number`, of each point's cluster, 0 = none.
    are_objects: (n_clusters + 1,) bool, the objects on one support. heights: (h, w) metres over
    it. free: (h, w) bool, of neither support nor wall. noise: of inverse depth, 1/m.
    """
    if are_objects.any():
        _join_down(number, are_objects, free, heights, points.depth, noise)


@njit(cache=True, nogil=True, error_model="numpy")
def _join_down(
    number: Array, are_objects: Array, free: Array, heights: Array, depth: Array, noise: float
) -> None:
    """Change `number` as `join_feet` says, row by row, where no step in depth parts them."""
    lowest, lowest_slope = np.float32(MIN_FOOT_HEIGHT), np.float32(0.2 * noise)
    step, step_slope = np.float32(0.01), np.float32(noise)
    for v in range(1, number.shape[0]):
        for u in range(number.shape[1]):
            above = number[v - 1, u]
            if number[v, u] == 0 and free[v, u] and are_objects[above]:
                z = depth[v, u]
                is_foot = heights[v, u] > lowest + lowest_slope * (z * z)
                if is_foot and abs(depth[v - 1, u] - z) < step + step_slope * (z * z):
                    number[v, u] = above
