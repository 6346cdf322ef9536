"""Points of a frame in groups, measured all groups at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.ranks import find_ends

Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Some points of a frame, sorted by their group.

    members: (n,) flat indices on the grid, those of a group in one piece and none empty.
    start: (n_groups + 1,) where each group begins in `members`, and n.
    """

    members: Array
    start: Array

    @classmethod
    def of(cls, where: Array, number: Array, *, min_points: int = 1) -> Self:
        """Return the groups of points with the same number, in the order of the numbers.

        where: (n,) flat indices. number: (n,) from 0. min_points: groups with fewer are left out.
        """
        return cls(*_sort(where, number, min_points))

    def __len__(self) -> int:
        return len(self.start) - 1

    def __iter__(self) -> Iterator[Array]:
        """Yield the flat indices of each group's points."""
        for first, end in zip(self.start[:-1], self.start[1:], strict=True):
            yield self.members[first:end]

    @property
    def sizes(self) -> Array:
        """(n_groups,) how many points each group has."""
        sizes: Array = self.start[1:] - self.start[:-1]
        return sizes

    def joined(self, number: Array) -> Self:
        """Return larger groups: those of the groups with the same of (n_groups,) numbers from 0."""
        return type(self).of(self.members, np.repeat(number, self.sizes))

    def boxes(self, mask: Array) -> tuple[Array, Array]:
        """(n_groups, 4) u_min, v_min, u_max, v_max of each group on the grid, ends exclusive.

        With it comes (n_groups,) how many of its members are in the (h, w) mask.
        """
        boxes, counts = _find_boxes(self.members, self.start, mask)
        return boxes, counts

    def ends(self, values: Array, shares: Sequence[tuple[int, float]]) -> Array:
        """(n_groups, k, 2) between which values of each group lie but for a share.

        values: (n, m) float32. shares: k columns to look at, each with what lies below, and as
            much above; with a share of 0.5 both ends are at the median.
        Of a group with more than 1000 points, evenly spaced ones are looked at.
        """
        ends: Array = _find_ends(values, self.start, np.array(shares))
        return ends

    def hidden_shares(self, depth: Array, *, step: float = 0.05, reach: int = 3) -> Array:
        """(n_groups,) share of a group's columns whose foot something hides.

        One or two times `reach` rows below the lowest point of such a column comes a surface
        nearer by `step` metres, or no reading at all: what the group stands on cannot be seen
        there.
        """
        shares: Array = _find_hidden(depth, self.members, self.start, step, reach)
        return shares


@njit(cache=True, nogil=True, error_model="numpy")
def _sort(where: Array, number: Array, min_points: int) -> tuple[Array, Array]:
    """Return what `Groups` are made of, see `Groups.of`."""
    n_numbers = 0
    for point in range(len(number)):
        n_numbers = max(n_numbers, number[point] + 1)
    sizes = np.zeros(n_numbers, np.int64)
    for point in range(len(number)):
        sizes[number[point]] += 1
    start, end, n_groups = np.zeros(len(sizes) + 1, np.int64), np.full(len(sizes), -1), 0
    for group in range(len(sizes)):
        if sizes[group] >= min_points:
            end[group] = start[n_groups]
            start[n_groups + 1] = start[n_groups] + sizes[group]
            n_groups += 1
    members = np.empty(start[n_groups], np.int64)
    for point in range(len(where)):
        place = end[number[point]]
        if place >= 0:
            members[place] = where[point]
            end[number[point]] = place + 1
    return members, start[: n_groups + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _find_boxes(members: Array, start: Array, mask: Array) -> tuple[Array, Array]:
    """Return what `Groups.boxes` does."""
    (height, width), n_groups, v = mask.shape, len(start) - 1, 0
    boxes, counts = np.empty((n_groups, 4), np.int64), np.empty(n_groups, np.int64)
    for group in range(n_groups):
        left, top, right, bottom, n_in = width, height, 0, 0, 0
        for place in range(start[group], start[group + 1]):
            # Most points are in the row of the one before, and divisions are slow.
            if not 0 <= members[place] - v * width < width:
                v = members[place] // width
            u = members[place] - v * width
            left, top, right, bottom = min(left, u), min(top, v), max(right, u), max(bottom, v)
            n_in += mask[v, u]
        boxes[group, 0], boxes[group, 1] = left, top
        boxes[group, 2], boxes[group, 3] = right + 1, bottom + 1
        counts[group] = n_in
    return boxes, counts


@njit(cache=True, nogil=True, error_model="numpy")
def _find_ends(values: Array, start: Array, shares: Array) -> Array:
    """Return what `Groups.ends` does."""
    found = np.empty((len(start) - 1, len(shares), 2), np.float32)
    pool = np.empty(2000, np.float32)
    for group in range(len(found)):
        first, last = start[group], start[group + 1] - 1
        stride = 1 + (last - first) // 1000
        n = 1 + (last - first) // stride
        for one in range(len(shares)):
            column, share = int(shares[one, 0]), shares[one, 1]
            for place in range(n):
                pool[place] = values[first + place * stride, column]
            n_beyond = min(int(share * n), n - 1 - int(share * n))
            found[group, one, 0], found[group, one, 1] = find_ends(pool[:n], n_beyond)
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _find_hidden(depth: Array, members: Array, start: Array, step: float, reach: int) -> Array:
    """Return what `Groups.hidden_shares` does."""
    height, width = depth.shape
    lowest, shares = np.full(width, -1), np.empty(len(start) - 1)
    for group in range(len(shares)):
        for place in range(start[group], start[group + 1]):
            row = members[place] // width
            column = members[place] - row * width
            lowest[column] = max(lowest[column], row)
        n_columns, n_hidden = 0, 0
        for column in range(width):
            foot = lowest[column]
            if foot >= 0:
                nearer = depth[foot, column] - np.float32(step)
                near = depth[min(foot + reach, height - 1), column]
                far = depth[min(foot + 2 * reach, height - 1), column]
                n_columns += 1
                n_hidden += not (near >= nearer and far >= nearer)
                lowest[column] = -1
        shares[group] = n_hidden / n_columns
    return shares
