"""Things: groups of points on a support, and what is measured of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import horizontal_axes
from curiosight.teacher.things.clusters import euclidean_clusters, join_stacked
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
# So far apart, metres, are things on two supports moved before they are clustered.
APART = 1000.0
# What covers fewer pixels of a 640x480 image than this is noise, not a part of a thing.
MIN_PART_PX = 60
# What is just below a thing is so far from it, in pixels of a 640x480 image.
BELOW_PX = 9
# Share of a thing's points that are low enough for it to stand; what a part needs is enough.
MIN_FOOT_SHARE = 0.02
# Of the way down to a thing, so far aside is the camera at most that looks from above (35°).
MAX_ASIDE = 0.7
# Share of its points at the border of the image by which that cuts a thing: fewer are stray.
MAX_AT_BORDER = 0.02


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
    places = places_over(parts, support, around)
    boxes = parts.ends(places, [(axis, 0.02) for axis in range(3)])
    hovers = ~are_standing(parts, places, support, around)
    hovers &= parts.hidden_shares(points.depth, reach=points.steps(BELOW_PX)) < 0.4
    # What the image cuts or is too large, a cupboard on the wall say, is no part of what is below.
    is_part = hovers & (parts.boxes(around.border)[1] <= MAX_AT_BORDER * parts.sizes)
    max_size = np.array([s.settings.max_size for s in supports]).take(support)
    is_part &= np.linalg.norm(boxes[..., 1] - boxes[..., 0], axis=1) < max_size
    thing = join_stacked(boxes, is_part, support)
    stands = np.bincount(thing, ~hovers | _are_below_camera(boxes, support, around)) > 0
    if len(stands) < len(parts):
        carrier_of_thing = np.empty(len(stands), np.int8)
        carrier_of_thing[thing] = support
        parts, support = parts.joined(thing), carrier_of_thing
        places = places_over(parts, support, around)
    return measure_things(parts, places, support, stands, around)


def _are_below_camera(boxes: Array, support: Array, around: Surroundings) -> Array:
    """(n,) bool: seen so steeply that their sides, and whether they stand, cannot be seen.

    boxes: (n, 3, 2) where they begin and end along two level axes and over their support.
    """
    camera_height = np.array([s.plane.offset for s in around.supports]).take(support)
    aside = np.hypot(*boxes[:, :2].sum(axis=2).T) / 2
    is_below: Array = aside < MAX_ASIDE * (camera_height - boxes[:, 2, 1])
    return is_below


def _cluster(carrier: Array, around: Surroundings) -> Groups:
    """Return the points over supports in groups that stand together, none over two supports."""
    points, kinds = (
        around.points,
        [(s.settings.leaf, s.settings.tolerance) for s in around.supports],
    )
    over = np.flatnonzero(carrier >= 0)
    members, numbers, n_clusters = [], [], 0
    for leaf, tolerance in sorted({*kinds}):
        is_chosen = np.array([kind == (leaf, tolerance) for kind in kinds])
        where, xyz = _take_over(over, carrier.ravel(), is_chosen, points.xyz.reshape(-1, 3))
        number = euclidean_clusters(xyz, leaf=leaf, tolerance=tolerance)
        members.append(where)
        numbers.append(number + n_clusters)
        n_clusters += 1 + int(number.max(initial=-1))
    where, number = np.concatenate(members), np.concatenate(numbers)
    return Groups.of(where, number, min_points=max(2, int(points.count(MIN_PART_PX))))


@njit(cache=True, nogil=True, error_model="numpy")
def _take_over(where: Array, carrier: Array, is_chosen: Array, xyz: Array) -> tuple[Array, Array]:
    """Return flat indices and float64 places, (n, 3), of the points that are over some supports.

    where: (m,) flat indices of those over any. carrier: (h * w,), see `find_things`. is_chosen:
    (n_supports,) bool. xyz: (h * w, 3). Supports are moved apart.
    """
    taken, places, n = np.empty_like(where), np.empty((len(where), 3)), 0
    for here in where:
        if is_chosen[carrier[here]]:
            taken[n] = here
            places[n, 0] = xyz[here, 0] + APART * carrier[here]
            places[n, 1], places[n, 2] = xyz[here, 1], xyz[here, 2]
            n += 1
    return taken[:n], places[:n]


def measure_things(
    groups: Groups, places: Array, support: Array, stands: Array, around: Surroundings
) -> list[Thing]:
    """Return the groups that are large enough as things.

    places: see `places_over`. support: (n_groups,) places in `supports`. stands: (n_groups,) bool.
    """
    ends = groups.ends(places, [(0, 0.01), (1, 0.01), (2, 0.01), (2, 0.1), (3, 0.5)])
    # What is below the support, by noise, adds nothing to the height.
    ends[:, 2, 0] = np.maximum(ends[:, 2, 0], 0)
    boxes, n_at_border = groups.boxes(around.border)
    measured = zip(
        groups,
        support.tolist(),
        boxes.tolist(),
        (ends[:, :3, 1] - ends[:, :3, 0]).tolist(),
        *ends[:, 3].T.tolist(),
        (ends[:, 4].sum(axis=1) / 2).tolist(),
        (n_at_border > MAX_AT_BORDER * groups.sizes).tolist(),
        stands.tolist(),
        strict=True,
    )
    min_points = around.points.evidence(around.settings.min_cluster_px)
    return [
        Thing(members, place, tuple(box), tuple(size), *rest)
        for members, place, box, size, *rest in measured
        if len(members) >= min_points
    ]


def number_points(things: Iterable[Thing], shape: tuple[int, ...]) -> npt.NDArray[np.int32]:
    """(h, w) int32: 1 + the place of the thing that each point of a grid is in; 0 = in none."""
    number = np.zeros(shape, np.int32)
    for place, thing in enumerate(things, start=1):
        number.ravel()[thing.members] = place
    return number


def are_standing(groups: Groups, places: Array, support: Array, around: Surroundings) -> Array:
    """(n_groups,) bool: have a foot on their support, of which thin legs are a small share.

    The arguments are as in `measure_things`.
    """
    mean_depth = np.add.reduceat(places[:, 3], groups.start[:-1]) / groups.sizes
    slab = np.array([s.settings.slab for s in around.supports]).take(support)
    reach = slab + 0.06 + 3 * around.settings.noise * mean_depth**2
    is_low = places[:, 2] <= np.repeat(reach, groups.sizes)
    n_low = np.add.reduceat(is_low, groups.start[:-1], dtype=np.int64)
    n_least = np.minimum(MIN_FOOT_SHARE * groups.sizes, around.points.count(MIN_PART_PX))
    stands: Array = n_low > n_least
    return stands


def places_over(groups: Groups, support: Array, around: Surroundings) -> Array:
    """(n, 4) metres of the members along two level axes, over their group's support, along z."""
    planes = np.array([[*s.plane.normal, s.plane.offset] for s in around.supports])
    places = np.empty((len(groups.members), 4), np.float32)
    _place(around.points.xyz.reshape(-1, 3), groups.members, groups.start, support, planes, places)
    return places


@njit(cache=True, nogil=True, error_model="numpy")
def _place(
    xyz: Array, members: Array, start: Array, support: Array, planes: Array, places: Array
) -> None:
    """Set what `places_over` returns; xyz: (h * w, 3). planes: (n_supports, 4), normal, offset."""
    to_place = np.zeros((4, 3), np.float32)
    for group in range(len(support)):
        plane = planes[support[group]]
        right, forward = horizontal_axes(plane[:3])
        for axis in range(3):
            to_place[axis, 0], to_place[axis, 1] = right[axis], forward[axis]
        for axis in range(4):
            to_place[axis, 2] = plane[axis]
        for place in range(start[group], start[group + 1]):
            point = members[place]
            x, y, z = xyz[point, 0], xyz[point, 1], xyz[point, 2]
            for axis in range(3):
                sideways = x * to_place[0, axis] + y * to_place[1, axis]
                places[place, axis] = sideways + z * to_place[2, axis] + to_place[3, axis]
            places[place, 3] = z
