"""Things: groups of points on a support, and what is measured of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask, horizontal_axes
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.things.clusters import euclidean_clusters, join_stacked
from curiosight.teacher.things.groups import Groups

Array = npt.NDArray[Any]
# So far apart, metres, are things on two supports moved before they are clustered.
APART = 1000.0
# What covers fewer pixels than this is noise, not a part of a thing.
MIN_PART_PX = 60
# Share of a thing's points that are low enough for it to stand; what a part needs is enough.
MIN_FOOT_SHARE = 0.02
# Of the way down to a thing, so far aside is the camera at most that looks from above (35°).
MAX_ASIDE = 0.7


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

    members: (n,) flat indices. support: its place in `Surroundings.supports`.
    box: (u_min, v_min, u_max, v_max) on the grid, ends exclusive.
    size: metres, width, length and height over the support, without the outermost 1 %.
    bottom, top: heights over the support in metres, without the outermost 10 %.
    distance: median metres along z.
    is_cut: by the border of the image. stands: reaches down to its support.
    """

    members: Array
    support: int
    box: tuple[int, int, int, int]
    size: tuple[float, float, float]
    bottom: float
    top: float
    distance: float
    is_cut: bool
    stands: bool


def find_things(carrier: Array, around: Surroundings) -> list[Thing]:
    """Return what the points over supports are, without the smallest.

    carrier: (h, w) int8, the place in `supports` of what each point is over, -1 = of nothing.
    """
    points, supports = around.points, around.supports
    parts = _cluster(carrier, around)
    if len(parts) == 0:
        return []
    support = carrier.take(parts.members[parts.start[:-1]])
    places = _places(parts, support, around)
    boxes = parts.ends(places, 0.02)
    hovers = ~_reach_down(parts, places[:, 2], support, around)
    hovers &= parts.hidden_shares(points.depth) < 0.4
    # What the image cuts or is too large, a cupboard on the wall say, is no part of what is below.
    is_part = hovers & ~_is_cut(parts, around.border)
    max_size = np.array([s.settings.max_size for s in supports]).take(support)
    is_part &= np.linalg.norm(boxes[..., 1] - boxes[..., 0], axis=1) < max_size
    thing = join_stacked(boxes, is_part, support)
    stands = np.bincount(thing, ~hovers | _are_below_camera(boxes, support, around)) > 0
    carrier_of_thing = np.empty(len(stands), np.int8)
    carrier_of_thing[thing] = support
    return measure_things(parts.joined(thing), carrier_of_thing, stands, around)


def _are_below_camera(boxes: Array, support: Array, around: Surroundings) -> Array:
    """(n,) bool: seen so steeply that their sides, and whether they stand, cannot be seen.

    boxes: (n, 3, 2) where they begin and end along two level axes and over their support.
    """
    camera_height = np.array([s.plane.offset for s in around.supports]).take(support)
    aside = np.linalg.norm(boxes[:, :2].mean(axis=2), axis=1)
    is_below: Array = aside < MAX_ASIDE * (camera_height - boxes[:, 2, 1])
    return is_below


def _cluster(carrier: Array, around: Surroundings) -> Groups:
    """Return the points over supports in groups that stand together, none over two supports."""
    limits = [support.settings for support in around.supports]
    members, numbers, n_clusters = [], [], 0
    for leaf, tolerance in sorted({(limit.leaf, limit.tolerance) for limit in limits}):
        chosen = [(limit.leaf, limit.tolerance) == (leaf, tolerance) for limit in limits]
        where = np.flatnonzero(np.array([*chosen, False]).take(carrier))
        xyz = around.points.xyz_at(where).astype(np.float64)
        xyz[:, 0] += APART * carrier.take(where)
        number = euclidean_clusters(xyz, leaf=leaf, tolerance=tolerance)
        members.append(where)
        numbers.append(number + n_clusters)
        n_clusters += 1 + int(number.max(initial=-1))
    where, number = np.concatenate(members), np.concatenate(numbers)
    return Groups.of(where, number, min_points=max(2, MIN_PART_PX // around.points.stride**2))


def measure_things(
    groups: Groups, support: Array, stands: Array, around: Surroundings
) -> list[Thing]:
    """Return the groups that are large enough as things.

    support: (n_groups,) places in `supports`. stands: (n_groups,) bool.
    """
    points = around.points
    places = _places(groups, support, around)
    low, high = np.moveaxis(groups.ends(places), 2, 0)
    # What is below the support, by noise, adds nothing to the height.
    low[:, 2] = np.maximum(low[:, 2], 0)
    trunk = groups.ends(places[:, 2:], 0.1)[:, 0]
    distance = groups.ends(points.depth.take(groups.members)[:, None], 0.5).mean(axis=(1, 2))
    measured = zip(
        groups,
        support.tolist(),
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
        Thing(members, place, tuple(box), tuple(size), *rest)
        for members, place, box, size, *rest in measured
        if len(members) >= min_points
    ]


def are_standing(groups: Groups, support: Array, around: Surroundings) -> Array:
    """(n_groups,) bool: reach down to their supports, the (n_groups,) places in `supports`."""
    return _reach_down(groups, _places(groups, support, around)[:, 2], support, around)


def _reach_down(groups: Groups, heights: Array, support: Array, around: Surroundings) -> Array:
    """(n_groups,) bool: have a foot, of which thin legs are a small share.

    heights: (n,) metres of the members over the (n_groups,) places in `supports`.
    """
    depth = around.points.depth.take(groups.members)
    mean_depth = np.add.reduceat(depth, groups.start[:-1]) / groups.sizes
    slab = np.array([s.settings.slab for s in around.supports]).take(support)
    reach = slab + 0.06 + 3 * around.settings.noise * mean_depth**2
    n_low = groups.count(heights <= np.repeat(reach, groups.sizes))
    n_least = np.minimum(MIN_FOOT_SHARE * groups.sizes, MIN_PART_PX / around.points.stride**2)
    stands: Array = n_low > n_least
    return stands


def _places(groups: Groups, support: Array, around: Surroundings) -> Array:
    """(n, 3) metres of the members along two level axes and over the support of their group."""
    axes = np.empty((len(around.supports), 4, 3), np.float32)
    for to_place, one in zip(axes, around.supports, strict=True):
        up = one.plane.normal
        to_place[:3] = np.stack([*horizontal_axes(up), up], axis=1)
        to_place[3] = 0, 0, one.plane.offset
    places = np.empty((len(groups.members), 3), np.float32)
    _place(around.points.xyz.reshape(-1, 3), groups.members, groups.start, support, axes, places)
    return places


@njit(cache=True, nogil=True, error_model="numpy")
def _place(
    xyz: Array, members: Array, start: Array, support: Array, axes: Array, places: Array
) -> None:
    """Set what `_places` returns; xyz: (h * w, 3). axes: (n_supports, 4, 3), from (x, y, z, 1)."""
    for group in range(len(support)):
        to_place = axes[support[group]]
        for place in range(start[group], start[group + 1]):
            x, y, z = xyz[members[place]]
            for axis in range(3):
                sideways = x * to_place[0, axis] + y * to_place[1, axis]
                places[place, axis] = sideways + z * to_place[2, axis] + to_place[3, axis]


def _is_cut(groups: Groups, border: Mask, *, max_share: float = 0.02) -> Array:
    """(n_groups,) bool: touches the border, by more than stray points beside it."""
    is_cut: Array = groups.count(border.take(groups.members)) > max_share * groups.sizes
    return is_cut
