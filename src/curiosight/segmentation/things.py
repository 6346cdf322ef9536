"""Things: groups of points on a support, and what is measured of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.clusters import euclidean_clusters, join_stacked
from curiosight.segmentation.groups import Groups
from curiosight.segmentation.planes import Mask, horizontal_axes
from curiosight.segmentation.points import Points
from curiosight.segmentation.settings import SegmentationSettings
from curiosight.segmentation.supports import Support
from curiosight.segmentation.walls import Wall

Array = npt.NDArray[Any]
# Fewer points than this are noise, not a part of a thing.
MIN_PART_POINTS = 15


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What things are found in and judged against.

    supports: lowest first. border: (h, w) bool, what no object may touch.
    """

    points: Points
    supports: list[Support]
    walls: list[Wall]
    border: Mask
    settings: SegmentationSettings


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """Points that stand together on a support.

    members: (n,) flat indices. box: (u_min, v_min, u_max, v_max) on the grid, ends exclusive.
    size: metres, width, length and height over the support, without the outermost 1 %.
    bottom, top: heights over the support in metres, without the outermost 10 %.
    distance: median metres along z.
    is_cut: by the border of the image. stands: reaches down to its support.
    """

    members: Array
    box: tuple[int, int, int, int]
    size: tuple[float, float, float]
    bottom: float
    top: float
    distance: float
    is_cut: bool
    stands: bool


def find_things(free: Mask, support: Support, around: Surroundings) -> list[Thing]:
    """Return what the `free` points, (h, w) bool, over a support are, without the smallest."""
    points, limits = around.points, support.settings
    where = np.flatnonzero(free)
    cluster = euclidean_clusters(points.xyz_at(where), leaf=limits.leaf, tolerance=limits.tolerance)
    parts = Groups.of(where, cluster, min_points=MIN_PART_POINTS)
    if len(parts) == 0:
        return []
    boxes = parts.ends(_places(parts, support, points), 0.02)
    mean_depth = np.add.reduceat(points.depth.take(parts.members), parts.start[:-1]) / parts.sizes
    noise = around.settings.noise * mean_depth**2
    hovers = boxes[:, 2, 0] > limits.slab + 0.06 + 3 * noise
    hovers &= parts.hidden_shares(points.depth) < 0.4
    # What the image cuts or is too large, a cupboard on the wall say, is no part of what is below.
    is_part = hovers & ~_is_cut(parts, around.border)
    is_part &= np.linalg.norm(boxes[..., 1] - boxes[..., 0], axis=1) < limits.max_size
    thing = join_stacked(boxes, is_part)
    return measure_things(parts.joined(thing), np.bincount(thing, ~hovers) > 0, support, around)


def measure_things(
    groups: Groups, stands: Array, support: Support, around: Surroundings
) -> list[Thing]:
    """Return the groups that are large enough as things; stands: (n_groups,) bool."""
    points = around.points
    places = _places(groups, support, points)
    low, high = np.moveaxis(groups.ends(places), 2, 0)
    # What is below the support, by noise, adds nothing to the height.
    low[:, 2] = np.maximum(low[:, 2], 0)
    trunk = groups.ends(places[:, 2:], 0.1)[:, 0]
    distance = groups.ends(points.depth.take(groups.members)[:, None], 0.5).mean(axis=(1, 2))
    measured = zip(
        groups,
        groups.boxes(points.depth.shape[1]).tolist(),
        (high - low).tolist(),
        *trunk.T.tolist(),
        distance.tolist(),
        _is_cut(groups, around.border).tolist(),
        stands.tolist(),
        strict=True,
    )
    min_points = around.settings.min_cluster_px / points.stride**2
    return [
        Thing(members, tuple(box), tuple(size), *rest)
        for members, box, size, *rest in measured
        if len(members) >= min_points
    ]


def _places(groups: Groups, support: Support, points: Points) -> Array:
    """(n, 3) metres of the members along two level axes and over a support."""
    up = support.plane.normal
    axes = np.stack([*horizontal_axes(up), up], axis=1, dtype=np.float32)
    places: Array = points.xyz_at(groups.members) @ axes
    places[:, 2] += np.float32(support.plane.offset)
    return places


def _is_cut(groups: Groups, border: Mask, *, max_share: float = 0.02) -> Array:
    """(n_groups,) bool: touches the border, by more than stray points beside it."""
    is_cut: Array = groups.count(border.take(groups.members)) > max_share * groups.sizes
    return is_cut
