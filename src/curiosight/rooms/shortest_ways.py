"""Shortest ways over the cells of a grid (Dijkstra)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.rooms.compiling import kernel

# To the sides first, then to the corners: down, right.
_STEPS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)], np.int64)
_N_SIDES = 4


def shortest_ways(
    is_free: npt.NDArray[np.bool_],
    first: tuple[int, int],
    *,
    side: float,
    has_corners: bool = True,
    longest: float = np.inf,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Return how far each cell is from the first one, and which cell comes before it on the way.

    Both (H, W): metres, infinite where no way leads or only one longer than `longest`; and the
    place of the cell before in the flattened grid, -1 for none.

    is_free: (H, W), the cells at its edge are not. first: row and column. side: of a cell,
    metres. has_corners: whether ways lead over the corners of cells, too.
    """
    lengths = np.hypot(*_STEPS.T.astype(np.float64)) * side
    n_steps = len(_STEPS) if has_corners else _N_SIDES
    metres, before = _spread(np.ascontiguousarray(is_free), *first, lengths[:n_steps], longest)
    return metres, before


@kernel
def _spread(
    is_free: npt.NDArray[np.bool_],
    row: int,
    column: int,
    lengths: npt.NDArray[np.float64],
    longest: float,
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Do as `shortest_ways` says, with a queue for each of the two lengths of a step.

    Cells are left in the order of their distance, so each queue is sorted by itself, and the
    nearest cell that waits is at the head of one of them.
    """
    height, width = is_free.shape
    metres = np.full((height, width), np.inf)
    before = np.full((height, width), -1, np.int64)
    if not is_free[row, column]:
        return metres, before
    size = _N_SIDES * int(is_free.sum()) + 1
    waiting, distance = np.empty((2, size), np.int64), np.empty((2, size))
    heads, ends = np.zeros(2, np.int64), np.zeros(2, np.int64)
    waiting[0, 0], distance[0, 0], ends[0] = row * width + column, 0.0, 1
    is_left = np.zeros((height, width), np.bool_)
    metres[row, column] = 0.0
    while heads[0] < ends[0] or heads[1] < ends[1]:
        queue = 1
        if heads[1] == ends[1] or (
            heads[0] < ends[0] and distance[0, heads[0]] <= distance[1, heads[1]]
        ):
            queue = 0
        v, u = divmod(waiting[queue, heads[queue]], width)
        heads[queue] += 1
        if is_left[v, u]:
            continue
        is_left[v, u] = True
        for step in range(len(lengths)):
            v_next, u_next = v + _STEPS[step, 0], u + _STEPS[step, 1]
            reached = metres[v, u] + lengths[step]
            if is_free[v_next, u_next] and reached <= longest and reached < metres[v_next, u_next]:
                metres[v_next, u_next], before[v_next, u_next] = reached, v * width + u
                kind = 0 if step < _N_SIDES else 1
                waiting[kind, ends[kind]] = v_next * width + u_next
                distance[kind, ends[kind]] = reached
                ends[kind] += 1
    return metres, before
