"""Which detections of many views are of one thing.

Whatever two views show of one thing overlaps in the world; what one view shows apart is two things.
Both are told as weights between detections, and groups are joined as long as more speaks for it
than against it: greedy additive edge contraction (Keuper et al., "Efficient Decomposition of
Image and Mesh Graphs by Lifted Multicuts", ICCV 2015). So a view in which two things are one blob
does not make one thing of them, where other views show them apart.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.detection import Detection
from curiosight.catalogue.voxels import Voxels, grown

Weights = dict[int, dict[int, float]]

# Two detections are as likely of one thing as of two where they share so much.
EVEN = 0.45
# What speaks against it where one view shows both.
APART = 1.5
# What shares less than this is not compared at all.
MIN_SHARED = 0.01


def group_detections(views: Sequence[int], detections: Sequence[Detection]) -> list[list[int]]:
    """Return the places of detections that are of one thing, for each thing.

    views: number of the view that shows each.
    """
    weights = _weigh(np.asarray(views), detections)
    return _contracted(len(detections), weights)


def _weigh(views: npt.NDArray[np.int64], detections: Sequence[Detection]) -> Weights:
    """Return what speaks for each pair that is near each other being one thing; against < 0."""
    if not detections:
        return {}
    own = [one.voxels for one in detections]
    around = [grown(voxels) for voxels in own]
    shared = _shared(own, around)
    weights: Weights = {}
    # Also where they do not overlap: something may overlap both.
    for view in np.unique(views):
        for i, j in combinations(np.flatnonzero(views == view).tolist(), 2):
            _put(weights, i, j, -APART)
    for (i, j), n_shared in shared.items():
        if i >= j:
            continue
        both = n_shared / len(own[i]), shared.get((j, i), 0) / len(own[j])
        if max(both) < MIN_SHARED:
            continue
        weight = (max(both) + min(both)) / 2 - EVEN
        _put(weights, i, j, weight - APART * float(views[i] == views[j]))
    return weights


def _put(weights: Weights, i: int, j: int, weight: float) -> None:
    weights.setdefault(i, {})[j] = weight
    weights.setdefault(j, {})[i] = weight


def _shared(own: Sequence[Voxels], around: Sequence[Voxels]) -> dict[tuple[int, int], int]:
    """Return how many cubes of one lie in or beside those of another, where any does."""
    owner = np.repeat(np.arange(len(around)), [len(one) for one in around])
    cubes = np.concatenate(around)
    order = np.argsort(cubes, kind="stable")
    cubes, owner = cubes[order], owner[order]
    found = {}
    for i, voxels in enumerate(own):
        first, last = (np.searchsorted(cubes, voxels, side) for side in ("left", "right"))
        n_each = last - first
        # Of each cube the places of all that have it.
        within = np.arange(n_each.sum()) - np.repeat(np.cumsum(n_each) - n_each, n_each)
        others = np.bincount(owner[np.repeat(first, n_each) + within])
        found.update({(i, int(j)): int(others[j]) for j in np.flatnonzero(others)})
    return found


def _contracted(n: int, weights: Weights) -> list[list[int]]:
    """Join the two groups that most speaks for, until nothing does for any."""
    members = {i: [i] for i in range(n)}
    heap = [(-w, i, j) for i, of_i in weights.items() for j, w in of_i.items() if i < j and w > 0]
    heapq.heapify(heap)
    while heap:
        negative, i, j = heapq.heappop(heap)
        if i not in members or j not in members or weights[i].get(j) != -negative:
            continue
        if len(weights[i]) < len(weights[j]):
            i, j = j, i
        members[i] += members.pop(j)
        for k, weight in weights.pop(j).items():
            del weights[k][j]
            if k == i:
                continue
            together = weights[i].get(k, 0.0) + weight
            weights[i][k] = weights[k][i] = together
            if together > 0:
                heapq.heappush(heap, (-together, min(i, k), max(i, k)))
    return [sorted(group) for _, group in sorted(members.items())]
