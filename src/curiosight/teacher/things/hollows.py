"""Hollows: what looks like the support inside a bowl or a pot, and is its bottom."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points

Array = npt.NDArray[Any]


def find_hollows(
    number: Array,
    boxes: Iterable[tuple[int, tuple[int, int, int, int]]],
    is_support: Mask,
    points: Points,
    *,
    max_step: float = 0.03,
    min_share: float = 0.5,
) -> Array:
    """(h, w) int32 number of the object that each point of a support is inside of, 0 = none.

    An object encloses its hollow in the image, and goes on from it upwards without a step in
    depth: its farther side rises from the bottom. A table seen through a handle lies behind.

    number: (h, w) int32 of each point's cluster. boxes: of the objects, number and
        (u_min, v_min, u_max, v_max) on the grid, ends exclusive.
    max_step: metres. min_share: of what is enclosed that is support, and of the places where
        that ends upwards that go on so.
    """
    hollows = np.zeros(number.shape, np.int32)
    for object_number, (left, top, right, bottom) in boxes:
        box = slice(top, bottom), slice(left, right)
        is_around = (number[box] != object_number).astype(np.uint8)
        _, piece, stats, _ = cv2.connectedComponentsWithStats(is_around, connectivity=4)
        for enclosed, (u, v, width, height, n_points) in enumerate(stats[1:], start=1):
            if 0 in (u, v) or u + width == right - left or v + height == bottom - top:
                continue
            # With the row above it.
            part = slice(top + v - 1, top + v + height), slice(left + u, left + u + width)
            is_bottom = piece[v - 1 : v + height, u : u + width] == enclosed
            is_bottom &= is_support[part]
            edge = is_bottom[1:] & ~is_bottom[:-1]
            step = points.depth[part][:-1][edge] - points.depth[part][1:][edge]
            is_mostly_bottom = np.count_nonzero(is_bottom) > min_share * n_points
            is_rising = np.abs(step) < max_step
            if is_mostly_bottom and np.count_nonzero(is_rising) > min_share * len(is_rising):
                hollows[part][is_bottom] = object_number
    return hollows
