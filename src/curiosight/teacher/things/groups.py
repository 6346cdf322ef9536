"""Points of a frame in groups, measured all groups at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

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
        sizes = np.bincount(number)
        is_kept = sizes >= min_points
        start = np.zeros(np.count_nonzero(is_kept) + 1, np.int64)
        np.cumsum(sizes[is_kept], out=start[1:])
        end = np.full(len(sizes), -1)
        end[is_kept] = start[:-1]
        members = np.empty(start[-1], np.int64)
        _sort(where, number, end, members)
        return cls(members, start)

    def __len__(self) -> int:
        return len(self.start) - 1

    def __iter__(self) -> Iterator[Array]:
        """Yield the flat indices of each group's points."""
        for first, end in zip(self.start[:-1], self.start[1:], strict=True):
            yield self.members[first:end]

    @property
    def sizes(self) -> Array:
        """(n_groups,) how many points each group has."""
        return np.diff(self.start)

    def joined(self, number: Array) -> Self:
        """Return larger groups: those of the groups with the same of (n_groups,) numbers from 0."""
        return type(self).of(self.members, np.repeat(number, self.sizes))

    def count(self, is_one: Array) -> Array:
        """(n_groups,) how many members (n,) `is_one` is true of."""
        return np.add.reduceat(is_one, self.start[:-1], dtype=np.int64)

    def boxes(self, width: int) -> Array:
        """(n_groups, 4) u_min, v_min, u_max, v_max of a group on a grid `width` wide, exclusive."""
        v, u = np.divmod(self.members, width)
        first = self.start[:-1]
        low = [np.minimum.reduceat(axis, first) for axis in (u, v)]
        high = [np.maximum.reduceat(axis, first) + 1 for axis in (u, v)]
        return np.stack([*low, *high], axis=1)

    def ends(self, values: Array, share: float = 0.01) -> Array:
        """(n_groups, k, 2) between which the (n, k) values of each group lie but for a share.

        The share lies below, and as much above; with a share of 0.5 both are at the median. Of a
        group with more than 1000 points, evenly spaced ones are looked at.
        """
        values = np.asarray(values, np.float32)
        pool = np.empty(int(self.sizes.max(initial=0)), np.float32)
        found = np.empty((len(self), values.shape[1], 2), np.float32)
        _find_ends(values, self.start, share, pool, found)
        return found

    def hidden_shares(self, depth: Array, *, step: float = 0.05, reach: int = 3) -> Array:
        """(n_groups,) share of a group's columns whose foot something hides.

        Just below, one and two times `reach` rows from the lowest point of such a column comes a surface nearer by `step` metres, or
        no reading at all: what the group stands on cannot be seen there.
        """
        lowest = np.full(depth.shape[1], -1)
        shares = np.empty(len(self))
        row = self.members // depth.shape[1]
        _find_hidden(depth, row, self.members, self.start, step, reach, lowest, shares)
        return shares


@njit(cache=True, nogil=True, error_model="numpy")
def _sort(where: Array, number: Array, end: Array, members: Array) -> None:
    """Set `members` to `where` in the order of the numbers.

    end: where the next point of each number goes, changed; -1 = nowhere.
    """
    for point in range(len(where)):
        place = end[number[point]]
        if place >= 0:
            members[place] = where[point]
            end[number[point]] = place + 1


@njit(cache=True, nogil=True, error_model="numpy")
def _find_ends(values: Array, start: Array, share: float, pool: Array, found: Array) -> None:
    """Set what `Groups.ends` returns; pool: (size of the largest group,), to work with."""
    for group in range(len(found)):
        first, last = start[group], start[group + 1] - 1
        stride = 1 + (last - first) // 1000
        n = 1 + (last - first) // stride
        low = min(int(share * n), n - 1 - int(share * n))
        for column in range(values.shape[1]):
            for place in range(n):
                pool[place] = values[first + place * stride, column]
            for end, rank in enumerate((low, n - 1 - low)):
                found[group, column, end] = _select(pool, end * low, n - 1, rank)


@njit(cache=True, nogil=True, error_model="numpy")
def _select(pool: Array, first: int, last: int, rank: int) -> float:
    """Return what would be at `rank` if pool[first : last + 1] were sorted; reorders it."""
    while first < last:
        pivot = pool[(first + last) // 2]
        up, down = first, last
        while up <= down:
            while pool[up] < pivot:
                up += 1
            while pool[down] > pivot:
                down -= 1
            if up <= down:
                pool[up], pool[down] = pool[down], pool[up]
                up += 1
                down -= 1
        if rank <= down:
            last = down
        elif rank >= up:
            first = up
        else:
            break
    return float(pool[rank])


@njit(cache=True, nogil=True, error_model="numpy")
def _find_hidden(
    depth: Array,
    row: Array,
    members: Array,
    start: Array,
    step: float,
    reach: int,
    lowest: Array,
    shares: Array,
) -> None:
    """Set what `Groups.hidden_shares` returns.

    row: (n,) of the members. lowest: (w,) -1, to work with: the lowest row of each column.
    """
    height, width = depth.shape
    for group in range(len(shares)):
        for place in range(start[group], start[group + 1]):
            column = members[place] - row[place] * width
            lowest[column] = max(lowest[column], row[place])
        n_columns, n_hidden = 0, 0
        for place in range(start[group], start[group + 1]):
            column = members[place] - row[place] * width
            foot = lowest[column]
            if foot >= 0:
                nearer = depth[foot, column] - np.float32(step)
                near = depth[min(foot + reach, height - 1), column]
                far = depth[min(foot + 2 * reach, height - 1), column]
                n_columns += 1
                n_hidden += not (near >= nearer and far >= nearer)
                lowest[column] = -1
        shares[group] = n_hidden / n_columns
