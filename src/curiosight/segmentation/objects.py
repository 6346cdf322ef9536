"""Clusters on the supports (sec. II-A.2), each with its verdict."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.bodies import beside_table, connect_bodies
from curiosight.segmentation.clusters import euclidean_clusters, join_stacked
from curiosight.segmentation.planes import Mask, horizontal_axes, noise_band
from curiosight.segmentation.points import ends, median
from curiosight.segmentation.supports import Support
from curiosight.segmentation.verdicts import Cluster, Surroundings, Verdict, is_cut, judge

Array = npt.NDArray[Any]


def find_objects(free: Mask, around: Surroundings) -> tuple[Array, list[Cluster]]:
    """Cluster what is on each table, the highest first, then the rest over the lowest support.

    What is under a table stays out: its legs and apron are no objects, and would tie chairs
    together. On a seat, a bed or a shelf nothing is an object, so the rest has it.

    free: (h, w) bool, the points of neither support nor wall. Return the (h, w) int32 number of
    each point's cluster, 0 = none, and the clusters in the order of their numbers.
    """
    points, lowest = around.points, around.supports[0]
    body = connect_bodies(free, points.depth, around.settings.noise)
    number = np.zeros(free.shape, np.int32)
    clusters: list[Cluster] = []
    free = free.copy()
    for support in reversed(around.supports):
        if not support.carries_objects:
            continue
        slab = noise_band(points, support.settings.slab, around.settings.noise)
        # What is free inside the slab faces elsewhere: the foot of something, or a crease.
        over = free & (support.heights > slab / 2)
        over &= support.heights < support.settings.max_height
        if support.extent is not None:
            extent = support.extent & ~beside_table(body, support)
            under = extent & (support.heights > -1.2)
            if support.core is not None:
                under &= support.core | (support.heights > -slab)
            free &= ~under
            over &= extent | free if support is lowest else extent
        free &= ~over
        numbers, found = _find_clusters(over, support, around)
        number += np.where(numbers > 0, numbers + len(clusters), 0)
        clusters += found
    return number, clusters


def _find_clusters(
    free: Mask, support: Support, around: Surroundings
) -> tuple[Array, list[Cluster]]:
    """Group the `free` points over a support and judge each group; see `find_objects`."""
    min_points = around.settings.min_cluster_px / around.points.stride**2
    number = np.zeros(free.shape, np.int32)
    clusters: list[Cluster] = []
    for members, stands in _things(np.flatnonzero(free), support, around):
        if len(members) >= min_points:
            cluster = _measure(members, support, around)
            verdict = judge(cluster, members, stands, support, around)
            clusters.append(replace(cluster, verdict=verdict))
            number.ravel()[members] = len(clusters)
    return number, clusters


def _things(
    where: Array, support: Support, around: Surroundings, *, min_points: int = 15
) -> Iterator[tuple[Array, bool]]:
    """Yield the flat indices of each thing's points, and whether it stands on the support.

    where: flat indices of all points. min_points: of a part; with fewer it is noise.
    """
    points, limits = around.points, support.settings
    xyz = points.xyz_at(where)
    cluster = euclidean_clusters(xyz, leaf=limits.leaf, tolerance=limits.tolerance)
    order = np.argsort(cluster, kind="stable")
    last = np.cumsum(np.bincount(cluster))
    groups = [where[part] for part in np.split(order, last[:-1]) if len(part) >= min_points]
    if not groups:
        return
    axes = np.stack(horizontal_axes(support.plane.normal), axis=1).astype(np.float32)
    boxes, hovers = np.empty((len(groups), 3, 2)), np.empty(len(groups), np.bool_)
    cut = np.empty(len(groups), np.bool_)
    for index, members in enumerate(groups):
        xyz = points.xyz_at(members)
        places = (*(xyz @ axes).T, support.heights.ravel()[members])
        boxes[index] = [ends(place, 0.02) for place in places]
        noise = around.settings.noise * float(xyz[:, 2].mean()) ** 2
        is_high = boxes[index, 2, 0] > limits.slab + 0.06 + 3 * noise
        hovers[index] = is_high and _hidden_share(points.depth, members) < 0.4
        cut[index] = is_cut(members, around.border)
    # What the image cuts, such as a cupboard on the wall, takes nothing below with it.
    thing = join_stacked(boxes, hovers & ~cut)
    for label in range(thing.max() + 1):
        parts = np.flatnonzero(thing == label)
        yield np.concatenate([groups[part] for part in parts]), not hovers[parts].all()


def _measure(members: Array, support: Support, around: Surroundings) -> Cluster:
    """Return the cluster of some points, given by their flat index; an object so far."""
    points = around.points
    xyz = points.xyz_at(members)
    v, u = np.unravel_index(members, points.depth.shape)
    s = points.stride
    right, forward = horizontal_axes(support.plane.normal)
    width, length = (high - low for low, high in (ends(xyz @ a) for a in (right, forward)))
    low, high = ends(support.heights.ravel()[members])
    return Cluster(
        verdict=Verdict.OBJECT,
        box=(int(u.min()) * s, int(v.min()) * s, int(u.max() + 1) * s, int(v.max() + 1) * s),
        n_pixels=len(members) * s * s,
        size=(width, length, high - max(0.0, low)),
        distance=median(xyz[:, 2]),
        support_height=float(max(0.0, around.supports[0].plane.offset - support.plane.offset)),
    )


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
    return np.count_nonzero(hidden) / len(hidden)
