"""Group views by the ways between them: rooms, without anybody saying where they are."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from curiosight.frame.linkage import AverageLinkage

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Metres of way between two groups of views.
MAX_WAY = 7.0
# Of more views so many are grouped first, and the others join them: ways take time to find.
MAX_GROUPED = 600


class MetresFrom(Protocol):
    """How long the ways are from a view to all, row by row; an (n, n) array is that, too."""

    def __len__(self) -> int: ...
    def __getitem__(self, view: int, /) -> Floats: ...


def group_by_ways(metres: MetresFrom) -> Ints:
    """Return (n_views,) groups of views a short way apart: a way through a door is a long one.

    Two groups are one while the mean way between their views is below `MAX_WAY` (average
    linkage). Of more than `MAX_GROUPED` views so many, evenly taken, are grouped, and each other
    view joins the group to which the mean way is shortest. Groups are numbered as they come.
    """
    n_views = len(metres)
    if n_views == 1:
        return np.zeros(1, np.int64)
    taken = np.linspace(0, n_views - 1, min(n_views, MAX_GROUPED)).round().astype(np.int64)
    rows = np.stack([metres[int(view)] for view in taken])
    ways = rows[:, taken]
    found = AverageLinkage((ways + ways.T) / 2).within(MAX_WAY)
    means = np.stack([rows[found == group].mean(axis=0) for group in range(found.max() + 1)])
    joined = means.argmin(axis=0)
    joined[taken] = found
    _, first, group = np.unique(joined, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[group].astype(np.int64)
