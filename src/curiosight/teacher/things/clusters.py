"""Groups of points that stand together: voxels, their neighbours, connected components.

The paper finds neighbours with a k-d tree (sec. II-A.2); a hash table of cells finds the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.things.union import join_nodes, number_sets, root_of

Array = npt.NDArray[Any]

# A cell's key holds its place along each axis in 21 bits: a million cells to either side.
ALONG_X, ALONG_Y = 1 << 42, 1 << 21
# From a cell to half of the 26 around it; the others have it in their half.
_SHIFTS = np.array(
    [(z - 1) + (y - 1) * ALONG_Y + (x - 1) * ALONG_X for x, y, z in np.ndindex(3, 3, 3)]
)
HALF_AROUND = _SHIFTS[_SHIFTS > 0]


def euclidean_clusters(xyz: Array, *, leaf: float, tolerance: float) -> Array:
    """Label (n, 3) points in metres with the number of their cluster, 0, 1, ….

    Points in one voxel of side `leaf` belong together, and so do voxels whose mean points lie
    within `tolerance` of each other.
    """
    xyz = np.ascontiguousarray(xyz, np.float64)
    voxel, keys, _ = _number_cells(xyz, leaf)
    means = np.zeros((len(keys), 3))
    _average(xyz, voxel, np.bincount(voxel), means)
    cluster: Array = near_sets(means, tolerance).take(voxel)
    return cluster


def near_sets(xyz: Array, tolerance: float) -> Array:
    """Number the sets of (n, 3) points in metres that hang together within a tolerance."""
    parent = np.arange(len(xyz))
    # Wider by a trifle, so that rounding never puts neighbours two cells apart.
    _join_near(xyz, tolerance, *_number_cells(xyz, 1.000001 * tolerance), parent)
    number: Array = number_sets(parent)
    return number


def join_stacked(
    boxes: Array, hovers: Array, support: Array, *, reach: float = 0.5, margin: float = 0.08
) -> Array:
    """Return the (n,) number of the thing that each of n clusters belongs to.

    A cluster that hovers belongs to those below it, seen from above: what joins them, a stem
    or a chair's legs, is hidden in it, or too thin to be seen.

    boxes: (n, 3, 2) where they begin and end, metres, along two level axes and upwards.
    hovers: (n,) bool. support: (n,) number of what each is over.
    reach: largest gap between the two, metres. margin: metres by which their outlines may miss
        each other.
    """
    return np.asarray(_join_below(boxes, hovers, support, reach, margin))


@njit(cache=True, nogil=True, error_model="numpy")
def _join_below(boxes: Array, hovers: Array, support: Array, reach: float, margin: float) -> Array:
    """Return what `join_stacked` does."""
    parent, far, wider = np.arange(len(boxes)), np.float32(reach), np.float32(margin)
    for upper in range(len(boxes)):
        bottom = boxes[upper, 2, 0]
        for lower in range(len(boxes)):
            joins = hovers[upper] & (support[upper] == support[lower])
            joins &= (boxes[lower, 2, 0] < bottom) & (boxes[lower, 2, 1] > bottom - far)
            for axis in range(2):
                joins &= boxes[upper, axis, 0] - wider < boxes[lower, axis, 1]
                joins &= boxes[lower, axis, 0] < boxes[upper, axis, 1] + wider
            if joins:
                join_nodes(parent, upper, lower)
    number: Array = number_sets(parent)
    return number


@njit(cache=True, nogil=True, error_model="numpy")
def _average(xyz: Array, group: Array, n_points: Array, means: Array) -> None:
    """Set the (n_groups, 3) means, 0 before, to those of (n, 3) points in their groups."""
    for point in range(len(xyz)):
        for axis in range(3):
            means[group[point], axis] += xyz[point, axis]
    for one in range(len(means)):
        for axis in range(3):
            means[one, axis] /= n_points[one]


@njit(cache=True, nogil=True, error_model="numpy")
def _number_cells(xyz: Array, side: float) -> tuple[Array, Array, Array]:
    """Number the cubes of a side in metres that hold (n, 3) points, in order of appearance.

    Return the (n,) number of each point's cell, the keys of the cells, and the hash table that
    finds them, see `_slot`.
    """
    size = 2
    while size <= 2 * len(xyz):
        size *= 2
    table, keys, per_side = np.zeros(size, np.int32), np.empty(len(xyz), np.int64), 1 / side
    for point in range(len(xyz)):
        key = np.int64(0)
        for axis in range(3):
            key = key * ALONG_Y + np.int64(np.floor(xyz[point, axis] * per_side))
        keys[point] = key
    cell, n_cells, last = np.empty(len(xyz), np.int64), 0, -1
    for point in range(len(xyz)):
        key = keys[point]
        # Points beside each other are mostly in one cell.
        if last < 0 or keys[last] != key:
            slot = _slot(keys, table, key)
            if table[slot] == 0:
                # No point before it needs that key any more.
                keys[n_cells] = key
                n_cells += 1
                table[slot] = n_cells
            last = table[slot] - 1
        cell[point] = last
    return cell, keys[:n_cells], table


@njit(cache=True, nogil=True, error_model="numpy")
def _slot(keys: Array, table: Array, key: int) -> int:
    """Return where a key is in the hash table, or where it would be.

    table: 2^k slots, each with 1 + the place in `keys` of what it holds, 0 = nothing.
    """
    # The golden ratio's digits spread neighbours over the table.
    slot = (key * 0x9E3779B97F4A7C1 >> 40) & (len(table) - 1)
    while table[slot] > 0 and keys[table[slot] - 1] != key:
        slot = (slot + 1) & (len(table) - 1)
    return slot


@njit(cache=True, nogil=True, error_model="numpy")
def _join_near(
    xyz: Array, tolerance: float, cell: Array, keys: Array, table: Array, parent: Array
) -> None:
    """Join the (n, 3) points that are at most a tolerance from each other.

    cell, keys, table: of the points, see `_number_cells`.
    """
    # The points of each cell, chained: the last, and before each one the next.
    before, last = np.empty(len(xyz), np.int64), np.full(len(keys), -1)
    for point in range(len(xyz)):
        before[point] = last[cell[point]]
        last[cell[point]] = point
    is_one = np.zeros(len(keys), np.bool_)
    for one in range(len(keys)):
        _join_chains(xyz, tolerance, before, last[one], last[one], False, parent)
        is_one[one] = _are_joined(before, last[one], parent)
    for one in range(len(keys)):
        for shift in HALF_AROUND:
            other = table[_slot(keys, table, keys[one] + shift)] - 1
            if other >= 0:
                # One link joins two cells whose points are joined already.
                is_enough = is_one[one] and is_one[other]
                _join_chains(xyz, tolerance, before, last[one], last[other], is_enough, parent)


@njit(cache=True, nogil=True, error_model="numpy")
def _are_joined(before: Array, one: int, parent: Array) -> bool:
    """Tell whether the points of a cell are in one set; before, one: see `_join_chains`."""
    root = root_of(parent, one)
    while one >= 0:
        if root_of(parent, one) != root:
            return False
        one = before[one]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _join_chains(
    xyz: Array,
    tolerance: float,
    before: Array,
    one: int,
    other: int,
    is_enough: bool,
    parent: Array,
) -> None:
    """Join the points of two cells that are near each other.

    before: (n,) the next point of the same cell, -1 = none. one, other: where the cells begin.
    is_enough: the first link is, and none is needed if their sets are one.
    """
    if is_enough and root_of(parent, one) == root_of(parent, other):
        return
    while one >= 0:
        near = other
        while near >= 0:
            gap = 0.0
            for axis in range(3):
                gap += (xyz[one, axis] - xyz[near, axis]) ** 2
            if gap <= tolerance * tolerance:
                join_nodes(parent, one, near)
                if is_enough:
                    return
            near = before[near]
        one = before[one]
