"""From which spots are linked, and how much, to groups of them: hierarchical clustering."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame.linkage import AverageLinkage

Array = npt.NDArray[Any]
Numbers = npt.NDArray[np.int64]

# Of the views most like one, those that count.
N_LIKE = 5


def join_linked(links: Array, least: float, max_groups: int) -> Numbers:
    """Return the (n,) group of each, from 0, by average linkage.

    links: (n, n) symmetric, in [0, 1]. least: two groups stay two if fewer are linked on average.
    max_groups: where there would be more, the best linked ones are one.
    """
    if len(links) < 2:
        return np.zeros(len(links), np.int64)
    tree = AverageLinkage(1 - links)
    groups = tree.within(1 - least)
    return groups if groups.max() < max_groups else tree.at_most(max_groups)


def seen_by_each_other(
    sees: Sequence[npt.NDArray[np.int64]], cell_of_spot: Numbers, n_cells: int
) -> Array:
    """Return (n, n) in [0, 1] how much spots see of each other.

    1 if one sees the other, else what both see, as a share of what either sees.
    sees: of each spot, numbers of the cells it sees. cell_of_spot: (n,) its own.
    """
    seen = np.zeros((len(sees), n_cells), np.float32)
    for spot, cells in enumerate(sees):
        seen[spot, cells] = 1
    both, size = seen @ seen.T, seen.sum(axis=1)
    shared = both / np.maximum(size[:, None] + size - both, 1)
    direct = seen[:, cell_of_spot]
    links: Array = np.maximum(shared, np.maximum(direct, direct.T)).astype(np.float64)
    return links


def shared_likes(alike: Array) -> Array:
    """Return (n, n) in [0, 1] how many of those most like two views are the same.

    At least a half if each is among those most like the other. alike: (n, n) likeness.
    """
    n_views = len(alike)
    n_like = min(N_LIKE, n_views - 1)
    others = np.where(np.eye(n_views, dtype=bool), -np.inf, alike)
    likes = np.zeros((n_views, n_views))
    nearest = np.argsort(-others, axis=1, kind="stable")[:, :n_like]
    likes[np.arange(n_views)[:, None], nearest] = 1
    with_self = likes + np.eye(n_views)
    links: Array = np.maximum(with_self @ with_self.T / (n_like + 1), (likes + likes.T) / 2)
    return links


def keep_numbers(groups: Numbers, before: Numbers, weights: Numbers) -> Numbers:
    """Return groups by the numbers that most of their members had before.

    groups, before, weights: (n,); before: -1 = none yet. The result has no gaps, so that a
    number that nobody keeps is taken by a new group.
    """
    n_groups, n_before = groups.max() + 1, before.max(initial=-1) + 1
    common = np.zeros((n_groups, max(n_groups, n_before)))
    was = before >= 0
    np.add.at(common, (groups[was], before[was]), weights[was])
    number = np.full(n_groups, -1)
    for flat in np.argsort(-common, axis=None, kind="stable"):
        group, old = divmod(int(flat), common.shape[1])
        if number[group] < 0 and old not in number and (common[group, old] or old < n_groups):
            number[group] = old
    # Numbers without gaps: the order of those kept stays.
    _, dense = np.unique(number, return_inverse=True)
    kept: Numbers = dense.astype(np.int64)[groups]
    return kept
