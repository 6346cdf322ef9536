"""Groups of points that stand together: voxels, their neighbours, connected components.

The paper finds neighbours with a k-d tree (sec. II-A.2); a hash table of cells finds the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.things.union import join_linked, join_nodes, number_sets

Array = npt.NDArray[Any]

# A cell's key holds its place along each axis in 21 bits: a million cells to either side.
ALONG_X, ALONG_Y = 1 << 42, 1 << 21
# From a cell to itself and to half of the 26 around it; the others have it in their half.
_SHIFTS = np.array(
    [(z - 1) + (y - 1) * ALONG_Y + (x - 1) * ALONG_X for x, y, z in np.ndindex(3, 3, 3)]
)
HALF_AROUND = _SHIFTS[_SHIFTS >= 0]


def euclidean_clusters(xyz: Array, *, leaf: float, tolerance: float) -> Array:
    """Label (n, 3) points in metres with the number of their cluster, 0, 1, ….

    Points in one voxel of side `leaf` belong together, and so do voxels whose mean points lie
    within `tolerance` of each other.
    """
    xyz = np.ascontiguousarray(xyz, np.float64)
    voxel, keys = _number_cells(xyz, leaf, _table_for(xyz))
    sums = np.zeros((len(keys), 4))
    _add_up(xyz, voxel, sums)
    means = sums[:, :3] / sums[:, 3:]
    # Wider by a trifle, so that rounding never puts neighbours two cells apart.
    table = _table_for(means)
    cell, keys = _number_cells(means, 1.000001 * tolerance, table)
    cluster: Array = _join_near(means, tolerance, cell, keys, table).take(voxel)
    return cluster


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
    low, high = boxes[:, 2, 0], boxes[:, 2, 1]
    is_below = (low < low[:, None]) & (high > low[:, None] - reach)
    begin, end = boxes[:, :2, 0], boxes[:, :2, 1]
    meets = ((begin[:, None] - margin < end) & (begin < end[:, None] + margin)).all(axis=2)
    parent = np.arange(len(boxes))
    meets &= support[:, None] == support
    join_linked(hovers[:, None] & is_below & meets, parent)
    return number_sets(parent)


def _table_for(xyz: Array) -> Array:
    """Return an empty hash table that is at most half full with the cells of (n, 3) points."""
    return np.full(2 << len(xyz).bit_length(), -1, np.int32)


def _number_cells(xyz: Array, side: float, table: Array) -> tuple[Array, Array]:
    """Number the cubes of a side in metres that hold (n, 3) points, in order of appearance.

    table: see `_slot`; the cells are added. Return the (n,) number of each point's cell, and
    the keys of the cells.
    """
    keys, cell = np.empty((2, len(xyz)), np.int64)
    n_cells = _enter_cells(xyz, side, table, keys, cell)
    return cell, keys[:n_cells]


@njit(cache=True, nogil=True, error_model="numpy")
def _enter_cells(xyz: Array, side: float, table: Array, keys: Array, cell: Array) -> int:
    """Set the first of the (n,) keys, and (n,) `cell`; return how many cells there are."""
    n_cells = 0
    for point in range(len(xyz)):
        key = np.int64(0)
        for axis in range(3):
            key = key * ALONG_Y + np.int64(np.floor(xyz[point, axis] / side))
        slot = _slot(keys, table, key)
        if table[slot] < 0:
            table[slot] = n_cells
            keys[n_cells] = key
            n_cells += 1
        cell[point] = table[slot]
    return n_cells


@njit(cache=True, nogil=True, error_model="numpy")
def _slot(keys: Array, table: Array, key: int) -> int:
    """Return where a key is in the hash table, or where it would be.

    table: 2^k slots, each with the place in `keys` of what it holds, -1 = nothing.
    """
    # The golden ratio's digits spread neighbours over the table.
    slot = (key * 0x9E3779B97F4A7C1 >> 40) & (len(table) - 1)
    while table[slot] >= 0 and keys[table[slot]] != key:
        slot = (slot + 1) & (len(table) - 1)
    return slot


@njit(cache=True, nogil=True, error_model="numpy")
def _add_up(xyz: Array, group: Array, sums: Array) -> None:
    """Add the (n, 3) points and their count to the (n_groups, 4) sums of their groups."""
    for point in range(len(xyz)):
        for axis in range(3):
            sums[group[point], axis] += xyz[point, axis]
        sums[group[point], 3] += 1


def _join_near(xyz: Array, tolerance: float, cell: Array, keys: Array, table: Array) -> Array:
    """Return the (n,) component of each point, where links are at most `tolerance` long.

    cell, keys, table: of the points, see `_number_cells`.
    """
    parent, before = np.arange(len(xyz)), np.empty(len(xyz), np.int64)
    last = np.full(len(keys), -1)
    _join_cells(xyz, tolerance, cell, keys, table, before, last, parent)
    return number_sets(parent)


@njit(cache=True, nogil=True, error_model="numpy")
def _join_cells(
    xyz: Array,
    tolerance: float,
    cell: Array,
    keys: Array,
    table: Array,
    before: Array,
    last: Array,
    parent: Array,
) -> None:
    """Join the points that are near each other.

    before: (n,) and last: (n_cells,) -1, to work with: the points of each cell, chained.
    """
    for point in range(len(xyz)):
        before[point] = last[cell[point]]
        last[cell[point]] = point
    for one in range(len(keys)):
        for shift in HALF_AROUND:
            other = table[_slot(keys, table, keys[one] + shift)]
            if other >= 0:
                _join_chains(xyz, tolerance, before, last[one], last[other], parent)


@njit(cache=True, nogil=True, error_model="numpy")
def _join_chains(
    xyz: Array, tolerance: float, before: Array, one: int, other: int, parent: Array
) -> None:
    """Join the points of two cells that are near each other.

    before: (n,) the next point of the same cell, -1 = none. one, other: where the cells begin.
    """
    while one >= 0:
        near = other
        while near >= 0:
            gap = 0.0
            for axis in range(3):
                gap += (xyz[one, axis] - xyz[near, axis]) ** 2
            if gap <= tolerance * tolerance:
                join_nodes(parent, one, near)
            near = before[near]
        one = before[one]
