"""Hollows: what looks like the support inside a bowl or a pot, and is its bottom."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask
from curiosight.segmentation.points import Points

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
        n_pieces, piece = cv2.connectedComponents(is_around, connectivity=4)
        at_edge = np.unique(np.concatenate([piece[[0, -1]].ravel(), piece[:, [0, -1]].ravel()]))
        for enclosed in np.setdiff1d(np.arange(1, n_pieces), at_edge):
            is_hole = piece == enclosed
            is_bottom = is_hole & is_support[box]
            edge = is_bottom[1:] & ~is_bottom[:-1]
            step = points.depth[box][:-1][edge] - points.depth[box][1:][edge]
            n_rising = np.count_nonzero(np.abs(step) < max_step)
            if (
                np.count_nonzero(is_bottom) > min_share * np.count_nonzero(is_hole)
                and n_rising > min_share * np.count_nonzero(edge)
            ):
                hollows[box][is_bottom] = object_number
    return hollows
