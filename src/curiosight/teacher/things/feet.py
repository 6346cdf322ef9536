"""Feet: what of an object lies within its support's slab, and does not face up as that does."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask

Array = npt.NDArray[Any]
# Lower than this (metres) a point in the crease may be either's.
MIN_FOOT_HEIGHT = 0.006
# Farther apart in depth, and besides the noise, points are of two things.
MAX_STEP = 0.01


@njit(cache=True, nogil=True, error_model="numpy")
def join_feet(
    number: Array,
    are_objects: Array,
    free: Mask,
    heights: Array,
    depth: Array,
    slab: float,
    noise: float,
) -> None:
    """Give the slab's points straight below an object in the image its number, row by row.

    Where no step in depth parts them. Changes (h, w) int32 `number`, of each point's cluster,
    0 = none.

    are_objects: (n_clusters + 1,) bool, the objects on one support. heights: (h, w) metres over
    it. free: (h, w) bool, of neither support nor wall: in the slab, what does not face up.
    slab: metres, thickness of its layer. noise: of inverse depth, 1/m.
    """
    lowest, lowest_slope = np.float32(MIN_FOOT_HEIGHT), np.float32(0.2 * noise)
    highest, slope = np.float32(slab), np.float32(noise)
    for v in range(1, number.shape[0]):
        for u in range(number.shape[1]):
            above = number[v - 1, u]
            if number[v, u] == 0 and free[v, u] and are_objects[above]:
                z = depth[v, u]
                slack = slope * (z * z)
                is_foot = heights[v, u] > lowest + lowest_slope * (z * z)
                is_foot &= heights[v, u] < highest + slack
                if is_foot and abs(depth[v - 1, u] - z) < np.float32(MAX_STEP) + slack:
                    number[v, u] = above
