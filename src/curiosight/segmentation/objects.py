"""Clusters on the supports, and whether each is an object (sec. II-A.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.clusters import euclidean_clusters
from curiosight.segmentation.planes import Mask, Plane, horizontal_axes
from curiosight.segmentation.points import Points
from curiosight.segmentation.settings import SegmentationSettings
from curiosight.segmentation.stacking import join_stacked
from curiosight.segmentation.supports import Support
from curiosight.segmentation.walls import Wall

Array = npt.NDArray[Any]


class Verdict(Enum):
    """Why a cluster is, or is not, an object. Everything but OBJECT is labelled unknown."""

    OBJECT = "object"
    CUT = "touches the image border"
    FAR = "reaches beyond the range"
    SMALL = "too small"
    LARGE = "too large"
    FLAT = "hardly rises over its support"
    FLOATING = "stands on nothing"
    FURNITURE = "belongs to a seat or a bed"
    WALL_PART = "belongs to a wall"


@dataclass(frozen=True, slots=True)
class Cluster:
    """A group of points on a support.

    box: (u_min, v_min, u_max, v_max) in pixels of the full image, ends exclusive.
    n_pixels: in the full image.
    size: metres, (width, length, height); the height is over the support.
    distance: median metres along z.
    support_height: of its support over the lowest one, metres.
    """

    verdict: Verdict
    box: tuple[int, int, int, int]
    n_pixels: int
    size: tuple[float, float, float]
    distance: float
    support_height: float


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What clusters are judged against.

    supports: lowest first. border: (h, w) bool, what no object may touch.
    """

    points: Points
    supports: list[Support]
    walls: list[Wall]
    border: Mask
    upholstery: Mask
    settings: SegmentationSettings


def find_clusters(
    free: Mask, support: Support, around: Surroundings
) -> tuple[Array, list[Cluster]]:
    """Group the `free` points over a support and judge each group.

    Return the (h, w) int32 number of each point's cluster, 0 = none, and the clusters in the
    order of their numbers.
    """
    points = around.points
    where = np.flatnonzero(free)
    found = euclidean_clusters(
        points.xyz.reshape(-1, 3)[where],
        leaf=support.settings.leaf,
        tolerance=support.settings.tolerance,
    )
    heights = support.heights(points)
    number = np.zeros(free.shape, np.int32)
    clusters = []
    for members, stands in _things(where, found, heights, support, around):
        if len(members) < around.settings.min_cluster_px / points.stride**2:
            continue
        cluster = _measure(members, heights, support, around)
        verdict = _judge(cluster, members, heights, support, around, stands)
        clusters.append(replace(cluster, verdict=verdict))
        number.ravel()[members] = len(clusters)
    return number, clusters


def _things(
    where: Array, found: Array, heights: Array, support: Support, around: Surroundings
) -> Iterator[tuple[Array, bool]]:
    """Yield the flat indices of the points of each thing, and whether it stands on the support.

    where, found: flat index and cluster of each point.
    """
    points = around.points
    order = np.argsort(found, kind="stable")
    groups = np.split(where[order], np.cumsum(np.bincount(found))[:-1]) if len(found) else []
    groups = [members for members in groups if len(members) >= 10]
    if not groups:
        return
    axes = np.stack(horizontal_axes(support.plane.normal), axis=1).astype(np.float32)
    low, high, hovers = np.empty(len(groups)), np.empty(len(groups)), np.zeros(len(groups), np.bool_)
    boxes = np.empty((len(groups), 4))
    for i, members in enumerate(groups):
        xyz = points.xyz.reshape(-1, 3)[members]
        low[i], high[i] = np.percentile(heights.ravel()[members], (2, 98))
        boxes[i] = np.percentile(xyz @ axes, (2, 98), axis=0).ravel()
        noise = around.settings.noise * float(np.median(xyz[:, 2])) ** 2
        foot = support.settings.slab + 0.06 + 3 * noise
        hovers[i] = low[i] > foot and _hidden_share(points.depth, members) < 0.4
    thing = join_stacked(low, high, boxes, hovers)
    for label in range(thing.max() + 1):
        parts = np.flatnonzero(thing == label)
        yield np.concatenate([groups[part] for part in parts]), not hovers[parts].all()


def _measure(members: Array, heights: Array, support: Support, around: Surroundings) -> Cluster:
    """Return the cluster of some points, given by their flat index; an object so far."""
    points = around.points
    xyz = points.xyz.reshape(-1, 3)[members]
    v, u = np.unravel_index(members, heights.shape)
    s = points.stride
    right, forward = horizontal_axes(support.plane.normal)
    width, length = (float(np.ptp(np.percentile(xyz @ a, (1, 99)))) for a in (right, forward))
    low, high = np.percentile(heights.ravel()[members], (1, 99))
    return Cluster(
        verdict=Verdict.OBJECT,
        box=(int(u.min()) * s, int(v.min()) * s, int(u.max() + 1) * s, int(v.max() + 1) * s),
        n_pixels=len(members) * s * s,
        size=(width, length, float(high - max(0.0, low))),
        distance=float(np.median(xyz[:, 2])),
        support_height=float(max(0.0, around.supports[0].plane.offset - support.plane.offset)),
    )


def _judge(
    cluster: Cluster, members: Array, heights: Array, support: Support, around: Surroundings, stands: bool
) -> Verdict:
    """Apply the paper's tests; the first that fails names the verdict."""
    points, limits = around.points, support.settings
    xyz = points.xyz.reshape(-1, 3)[members]
    noise = around.settings.noise * cluster.distance**2
    diagonal = float(np.linalg.norm(cluster.size))
    if around.border.ravel()[members].any():
        return Verdict.CUT
    if around.upholstery.ravel()[members].mean() > 0.03:
        return Verdict.FURNITURE
    if not support.is_table and _is_leg(members, around):
        return Verdict.FURNITURE
    if diagonal < limits.min_size:
        return Verdict.SMALL
    if diagonal > limits.max_size or np.hypot(*cluster.size[:2]) > limits.max_width:
        return Verdict.LARGE
    if np.count_nonzero(xyz[:, 2] > around.settings.max_range - 0.05) > 5:
        return Verdict.FAR
    if any(_is_part_of(wall, members, around, support) for wall in around.walls):
        return Verdict.WALL_PART
    over = heights.ravel()[members]
    if np.percentile(over, 90) < 2 * (limits.slab + noise):
        return Verdict.FLAT
    if not stands:
        return Verdict.FLOATING
    return Verdict.OBJECT


def _is_part_of(wall: Wall, members: Array, around: Surroundings, support: Support) -> bool:
    """Tell whether a cluster hangs on a wall, or is round its corner."""
    points = around.points
    xyz = points.xyz.reshape(-1, 3)[members]
    if np.mean(wall.is_beside(xyz)) > 0.5:
        away = np.abs(wall.distance(xyz))
        if np.median(away) < around.settings.wall_gap:
            return True
        if not support.is_table and np.percentile(away, 95) < 2 * around.settings.wall_gap:
            return True
    return _turns_corner(points, members, wall)


def _is_leg(members: Array, around: Surroundings) -> bool:
    """Tell whether something close to a table ends just below its top."""
    points = around.points
    xyz = points.xyz.reshape(-1, 3)[members]
    for table in around.supports:
        if table.skirt is not None and np.mean(table.skirt.ravel()[members]) > 0.7:
            top = float(np.percentile(table.plane.distance(xyz), 98))
            if table.is_seat or -0.5 < top < 0.05:
                return True
    return False


def _turns_corner(points: Points, members: Array, wall: Plane, *, reach: int = 6) -> bool:
    """Tell whether a cluster is the other face of a wall, round a convex corner.

    It lies behind the wall's plane, and in most of its rows goes over into the wall sideways,
    without a step. Together they are larger than any object. What stands before a wall meets
    it in a concave corner and stays out of this.

    reach: cells over the crease, where no normal is known.
    """
    if np.median(wall.distance(points.xyz.reshape(-1, 3)[members])) > 0:
        return False
    height, width = points.depth.shape
    v, u = np.unravel_index(members, points.depth.shape)
    first, last = np.full(height, width), np.full(height, -1)
    np.minimum.at(first, v, u)
    np.maximum.at(last, v, u)
    rows = np.unique(v)
    for edge, beyond in ((first, -reach), (last, reach)):
        there = np.clip(edge[rows] + beyond, 0, width - 1)
        step = np.abs(points.depth[rows, there] - points.depth[rows, edge[rows]])
        if np.mean(wall.inliers[rows, there] & (step < 0.10)) > 0.5:
            return True
    return False


def _hidden_share(depth: Array, members: Array, *, step: float = 0.05) -> float:
    """Return the share of a cluster's columns whose foot something hides.

    Just below the lowest point of such a column comes a surface nearer by `step` metres, or
    no reading at all: what the cluster stands on cannot be seen there.
    """
    height = depth.shape[0]
    v, u = np.unravel_index(members, depth.shape)
    lowest = np.full(depth.shape[1], -1, np.int64)
    np.maximum.at(lowest, u, v)
    columns = np.flatnonzero(lowest >= 0)
    foot = lowest[columns]
    here = depth[foot, columns]
    hidden = np.zeros(len(columns), np.bool_)
    for below in (3, 6):
        there = depth[np.minimum(foot + below, height - 1), columns]
        hidden |= np.isnan(there) | (there < here - step)
    return float(hidden.mean())
