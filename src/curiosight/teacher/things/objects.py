"""The fourth stage: what is on the supports, in clusters, each with its verdict (sec. II-A.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.things.bodies import Bodies, beside_table, connect_bodies
from curiosight.teacher.things.feet import join_feet
from curiosight.teacher.things.hollows import find_hollows
from curiosight.teacher.things.masked import part_along_masks
from curiosight.teacher.things.set_apart import set_apart
from curiosight.teacher.things.things import Thing, find_things, number_points
from curiosight.teacher.things.touching import part_touching
from curiosight.teacher.things.verdicts import Cluster, Verdict, judge
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
# What is whole may stand before these, and seem a part of them.
TIED = frozenset({Verdict.CUT})


@dataclass(frozen=True, slots=True, eq=False)
class Things:
    """What is on the supports of a frame.

    number: (h, w) int32, 1 + the place in `clusters` of each point; 0 = in none.
    hollows: (h, w) int32, the same of the object that a point of a support is inside of.
    """

    around: Surroundings
    clusters: list[Cluster]
    number: Array
    hollows: Array


def find_objects(around: Surroundings, regions: Array | None = None) -> Things:
    """Cluster what is on each table, the highest first, then the rest over the lowest support.

    What is under a table stays out: its legs and apron are no objects, and would tie chairs
    together. On a seat, a bed or a shelf nothing is an object, so the rest has it.

    regions: (h, w) int32, instances of masks, see `part_along_masks`; None = there are none.
    """
    free, points, noise = around.free, around.points, around.settings.noise
    bodies = connect_bodies(free, points.depth, noise)
    things = find_things(divide(free, bodies, around), around)
    judged = _judged(things, bodies, around)
    if regions is not None:
        judged = part_along_masks(judged, regions, around)
    number = number_points((thing for thing, _ in judged), free.shape)
    carrier = np.array([-1, *(t.support if v is Verdict.OBJECT else -1 for t, v in judged)])
    for place, support in enumerate(around.supports):
        on_it, slab = carrier == place, support.settings.slab
        if on_it.any():
            join_feet(number, on_it, free, support.heights, points.depth, slab, noise)
    extents = np.zeros((len(judged), 5), np.int64)
    _measure_extents(number, extents)
    measured = zip(judged, extents.tolist(), strict=True)
    clusters = [_cluster(*pair, extent, around) for pair, extent in measured]
    boxes = [
        (place, extent[:4])
        for place, extent in enumerate(extents.tolist(), start=1)
        if clusters[place - 1].verdict is Verdict.OBJECT
    ]
    return Things(around, clusters, number, find_hollows(number, boxes, around.is_support, points))


@njit(cache=True, nogil=True, error_model="numpy")
def _measure_extents(number: Array, extents: Array) -> None:
    """Set (n, 5) u_min, v_min, u_max, v_max, ends exclusive, and the points of each number.

    number: (h, w) from 1; 0 = none. extents: 0 before.
    """
    height, width = number.shape
    for v in range(height):
        for u in range(width):
            if number[v, u] > 0:
                extent = extents[number[v, u] - 1]
                if extent[4] == 0:
                    extent[0], extent[1] = u, v
                extent[0], extent[2] = min(extent[0], u), max(extent[2], u + 1)
                extent[3] = v + 1
                extent[4] += 1


def divide(free: Mask, bodies: Bodies, around: Surroundings) -> Array:
    """(h, w) int8: the place in `supports` of what each free point is over, -1 = of nothing."""
    carrier, free = np.full(free.shape, -1, np.int8), free.copy()
    for place, support in reversed(list(enumerate(around.supports))):
        if support.kind.carries_objects:
            _take_over(free, bodies, support, place, around, carrier)
    return carrier


def _judged(
    things: list[Thing], bodies: Bodies, around: Surroundings
) -> list[tuple[Thing, Verdict]]:
    """Return things with their verdicts; what is parted into objects stands last."""
    judged = [(thing, judge(thing, around)) for thing in things]
    tied = [thing for thing, verdict in judged if verdict in TIED]
    free = set_apart(tied, bodies, around) if tied else []
    judged += [(thing, Verdict.OBJECT) for thing in free if judge(thing, around) is Verdict.OBJECT]
    rest: list[tuple[Thing, Verdict]] = []
    whole: dict[Verdict, list[Thing]] = {Verdict.OBJECT: [], Verdict.LARGE: []}
    for thing, verdict in judged:
        if verdict in whole and around.supports[thing.support].settings.part_touching:
            whole[verdict].append(thing)
        else:
            rest.append((thing, verdict))
    if whole[Verdict.OBJECT]:
        rest += [(part, Verdict.OBJECT) for part in part_touching(whole[Verdict.OBJECT], around)]
    if whole[Verdict.LARGE]:
        # What is too large may be several things that touch.
        parts = part_touching(whole[Verdict.LARGE], around)
        rest += [(part, judge(part, around)) for part in parts]
    return rest


def _take_over(
    free: Mask, bodies: Bodies, support: Support, place: int, around: Surroundings, carrier: Array
) -> None:
    """Set `carrier` to the place of a support where free points are over it.

    They, and those under it, are free no more. All are (h, w).
    """
    extent = np.zeros((1, 1), np.bool_) if support.extent is None else support.extent
    core = extent if support.core is None else support.core
    is_beside, depth = beside_table(bodies, support), around.points.depth
    limits = support.settings.slab, around.settings.noise, support.settings.max_height
    grids = bodies.number, is_beside, extent, core, support.heights, depth
    _divide(free, *grids, *limits, place, carrier)


@njit(cache=True, nogil=True, error_model="numpy")
def _divide(
    free: Array,
    body: Array,
    is_beside: Array,
    extent: Array,
    core: Array,
    heights: Array,
    depth: Array,
    slab: float,
    noise: float,
    max_height: float,
    place: int,
    carrier: Array,
) -> None:
    """Set `carrier`, and change `free`, as `_take_over` says; all are (h, w).

    extent, core: (1, 1) where the support has none. is_beside: (n_bodies,), see `beside_table`.
    What is free inside the slab faces elsewhere: the foot of something, or a crease.
    """
    base, slope, highest = np.float32(slab), np.float32(noise), np.float32(max_height)
    is_table, is_lowest = extent.shape == free.shape, place == 0
    for v in range(free.shape[0]):
        for u in range(free.shape[1]):
            if not free[v, u]:
                continue
            height = heights[v, u]
            band = base + slope * (depth[v, u] * depth[v, u])
            is_in = is_table and extent[v, u] and not is_beside[body[v, u]]
            is_under = is_in and height > -1.2 and (core[v, u] or height > -band)
            is_over = band < 2 * height and height < highest and (is_in or is_lowest)
            if is_over:
                carrier[v, u] = place
            free[v, u] = not (is_under or is_over)


def _cluster(thing: Thing, verdict: Verdict, extent: list[int], around: Surroundings) -> Cluster:
    """Return a thing as the rest of the program knows it; extent: its box and points, with feet."""
    stride, support = around.points.stride, around.supports[thing.support]
    u_min, v_min, u_max, v_max = (stride * end for end in extent[:4])
    return Cluster(
        verdict=verdict,
        box=(u_min, v_min, u_max, v_max),
        n_pixels=extent[4] * stride**2,
        size=thing.size,
        distance=thing.distance,
        support_height=float(max(0.0, around.supports[0].plane.offset - support.plane.offset)),
    )
