"""Clusters on the supports (sec. II-A.2), each with its verdict."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from curiosight.segmentation.bodies import Bodies, beside_table, connect_bodies
from curiosight.segmentation.planes import Mask
from curiosight.segmentation.supports import Support
from curiosight.segmentation.things import Surroundings, Thing, find_things
from curiosight.segmentation.touching import part_touching
from curiosight.segmentation.verdicts import Cluster, Verdict, judge

Array = npt.NDArray[Any]


def find_objects(free: Mask, around: Surroundings) -> tuple[Array, list[Cluster]]:
    """Cluster what is on each table, the highest first, then the rest over the lowest support.

    What is under a table stays out: its legs and apron are no objects, and would tie chairs
    together. On a seat, a bed or a shelf nothing is an object, so the rest has it.

    free: (h, w) bool, the points of neither support nor wall. Return the (h, w) int32 number of
    each point's cluster, 0 = none, and the clusters in the order of their numbers.
    """
    carriers = [support for support in around.supports if support.carries_objects]
    bodies = connect_bodies(free, around.points.depth, around.settings.noise)
    number = np.zeros(free.shape, np.int32)
    clusters: list[Cluster] = []
    free = free.copy()
    for support in reversed(carriers):
        over = _take_over(free, bodies, support, around)
        for thing, verdict in _judged(find_things(over, support, around), support, around):
            clusters.append(_cluster(thing, verdict, support, around))
            number.ravel()[thing.members] = len(clusters)
    return number, clusters


def _judged(
    things: list[Thing], support: Support, around: Surroundings
) -> list[tuple[Thing, Verdict]]:
    """Return things with their verdicts; what is parted into objects stands last."""
    judged = [(thing, judge(thing, support, around)) for thing in things]
    if not support.settings.part_touching:
        return judged
    whole = [thing for thing, verdict in judged if verdict is Verdict.OBJECT]
    others = [(thing, verdict) for thing, verdict in judged if verdict is not Verdict.OBJECT]
    objects = part_touching(whole, support, around) if whole else []
    return [*others, *((thing, Verdict.OBJECT) for thing in objects)]


def _take_over(free: Mask, bodies: Bodies, support: Support, around: Surroundings) -> Mask:
    """(h, w) bool: the free points over a support; they, and those under it, are free no more."""
    over = np.zeros(free.shape, np.bool_)
    extent = over if support.extent is None else support.extent
    _divide(
        free,
        bodies.number,
        beside_table(bodies, support),
        extent,
        extent if support.core is None else support.core,
        support.heights,
        around.points.depth,
        support.settings.slab,
        around.settings.noise,
        support.settings.max_height,
        support is around.supports[0],
        over,
    )
    return over


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
    is_lowest: bool,
    over: Array,
) -> None:
    """Set `over`, and change `free`, as `_take_over` says; all are (h, w).

    is_beside: (n_bodies,), see `beside_table`. What is free inside the slab faces elsewhere: the
    foot of something, or a crease.
    """
    base, slope, highest = np.float32(slab), np.float32(noise), np.float32(max_height)
    for v in range(free.shape[0]):
        for u in range(free.shape[1]):
            if not free[v, u]:
                continue
            height = heights[v, u]
            band = base + slope * (depth[v, u] * depth[v, u])
            is_in = extent[v, u] and not is_beside[body[v, u]]
            is_under = is_in and height > -1.2 and (core[v, u] or height > -band)
            is_over = band < 2 * height and height < highest and (is_in or is_lowest)
            over[v, u] = is_over
            free[v, u] = not (is_under or is_over)


def _cluster(thing: Thing, verdict: Verdict, support: Support, around: Surroundings) -> Cluster:
    """Return a thing as the rest of the program knows it."""
    stride = around.points.stride
    u_min, v_min, u_max, v_max = (stride * end for end in thing.box)
    return Cluster(
        verdict=verdict,
        box=(u_min, v_min, u_max, v_max),
        n_pixels=len(thing.members) * stride**2,
        size=thing.size,
        distance=thing.distance,
        support_height=float(max(0.0, around.supports[0].plane.offset - support.plane.offset)),
    )
