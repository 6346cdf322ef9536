"""Hollows: what looks like the support inside a bowl or a pot, and is its bottom."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points

Array = npt.NDArray[Any]


def find_hollows(
    number: Array,
    boxes: Iterable[tuple[int, Sequence[int]]],
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
    around = [(place, *box) for place, box in boxes]
    if not around:
        return np.zeros(number.shape, np.int32)
    grids = number, is_support, points.depth
    return np.asarray(_find_hollows(*grids, np.array(around), max_step, min_share))


@njit(cache=True, nogil=True, error_model="numpy")
def _find_hollows(
    number: Array, is_support: Array, depth: Array, boxes: Array, max_step: float, min_share: float
) -> Array:
    """Return what `find_hollows` does; boxes: (n, 5) number and ends of each."""
    hollows, highest, flood = np.zeros_like(number), np.float32(max_step), 0
    # The number of the flood that was at each point, in the order of all floods.
    flooded, queue = np.zeros_like(number), np.empty((number.size, 2), np.int32)
    ends = np.empty((4, max(number.shape)), np.int64)
    for place in range(len(boxes)):
        box, before = boxes[place], flood
        _outline(number, box, ends)
        left, right, top, bottom = ends[0], ends[1], ends[2], ends[3]
        for v in range(box[2], box[4]):
            for u in range(left[v] + 1, right[v]):
                is_new = is_support[v, u] and number[v, u] != box[0] and flooded[v, u] <= before
                if not (is_new and top[u] < v < bottom[u]):
                    continue
                flood += 1
                n = _flood(number, box, v, u, before, flood, flooded, queue)
                n_bottom, n_edge, n_rising = 0, 0, 0
                for index in range(n):
                    row, column = queue[index, 0], queue[index, 1]
                    n_bottom += is_support[row, column]
                    is_above = number[row - 1, column] != box[0] and is_support[row - 1, column]
                    if is_support[row, column] and not is_above:
                        n_edge += 1
                        n_rising += abs(depth[row - 1, column] - depth[row, column]) < highest
                if n_bottom > min_share * n and n_rising > min_share * n_edge:
                    for index in range(n):
                        if is_support[queue[index, 0], queue[index, 1]]:
                            hollows[queue[index, 0], queue[index, 1]] = box[0]
    return hollows


@njit(cache=True, nogil=True, error_model="numpy")
def _outline(number: Array, box: Array, ends: Array) -> None:
    """Set the first and second of (4, n) `ends` to those of an object in each row of its box.

    The others are its ends in each column. box: (5,) see `_find_hollows`.
    """
    for v in range(box[2], box[4]):
        ends[0, v], ends[1, v] = number.shape[1], -1
    for u in range(box[1], box[3]):
        ends[2, u], ends[3, u] = number.shape[0], -1
    for v in range(box[2], box[4]):
        for u in range(box[1], box[3]):
            if number[v, u] == box[0]:
                ends[0, v], ends[1, v] = min(ends[0, v], u), u
                ends[2, u], ends[3, u] = min(ends[2, u], v), v


@njit(cache=True, nogil=True, error_model="numpy")
def _flood(
    number: Array,
    box: Array,
    v: int,
    u: int,
    before: int,
    flood: int,
    flooded: Array,
    queue: Array,
) -> int:
    """Flood from a point inside a box without entering its object; return the points reached.

    They are the first rows of (h * w, 2) `queue`; 0 = the flood has reached the end of the box.
    flood: its number. before: that of the last one about another object.
    """
    flooded[v, u] = flood
    queue[0, 0], queue[0, 1] = v, u
    n_done, n_waiting = 0, 1
    while n_done < n_waiting:
        row, column = queue[n_done, 0], queue[n_done, 1]
        n_done += 1
        for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            v, u = row + dv, column + du
            if number[v, u] == box[0] or flooded[v, u] == flood:
                continue
            is_inside = box[1] < u < box[3] - 1 and box[2] < v < box[4] - 1
            # Where another one was that left off, it came to the end.
            if not is_inside or flooded[v, u] > before:
                return 0
            flooded[v, u] = flood
            queue[n_waiting, 0], queue[n_waiting, 1] = v, u
            n_waiting += 1
    return n_waiting
