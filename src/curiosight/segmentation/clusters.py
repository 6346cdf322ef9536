"""Groups of points that stand together: voxels, k-d tree, connected components (sec. II-A.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Array = npt.NDArray[Any]


def euclidean_clusters(xyz: Array, *, leaf: float, tolerance: float) -> Array:
    """Label (n, 3) points in metres with the number of their cluster, 0, 1, ….

    Points in one voxel of side `leaf` belong together, and so do voxels whose mean points lie
    within `tolerance` of each other.
    """
    if len(xyz) == 0:
        return np.empty(0, np.int64)
    cell = np.floor(xyz / leaf).astype(np.int64)
    cell -= cell.min(axis=0)
    size = cell.max(axis=0) + 1
    key = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    _, voxel, n_points = np.unique(key, return_inverse=True, return_counts=True)
    sums = [np.bincount(voxel, xyz[:, axis]) for axis in range(3)]
    mean = np.stack(sums, axis=1) / n_points[:, None]
    pairs = cKDTree(mean).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), [len(mean)] * 2)
    _, cluster = connected_components(links, directed=False)
    labels: Array = cluster[voxel]
    return labels


def join_stacked(boxes: Array, hovers: Array, *, reach: float = 0.5, margin: float = 0.03) -> Array:
    """Return the (n,) number of the thing that each of n clusters belongs to.

    A cluster that hovers belongs to those below it, seen from above: what joins them, a stem
    or a chair's legs, is hidden in it, or too thin to be seen.

    boxes: (n, 3, 2) where they begin and end, metres, along two level axes and upwards.
    hovers: (n,) bool. reach: largest gap between the two, metres. margin: metres by which
        their outlines may miss each other.
    """
    low, high = boxes[:, 2, 0], boxes[:, 2, 1]
    is_below = (low < low[:, None]) & (high > low[:, None] - reach)
    begin, end = boxes[:, :2, 0], boxes[:, :2, 1]
    meets = ((begin[:, None] - margin < end) & (begin < end[:, None] + margin)).all(axis=2)
    _, thing = connected_components(hovers[:, None] & is_below & meets, directed=False)
    things: Array = thing
    return things
