"""Things that touch, told apart: patches of smooth surface, joined where they are one object."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.things.hollows import find_hollows
from curiosight.teacher.things.meetings import TOUCHING, Patches
from curiosight.teacher.things.patches import find_patches
from curiosight.teacher.things.things import Thing, measure_things, number_points, places_over
from curiosight.teacher.things.union import join_linked, join_nodes, number_sets
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
# The wall of a pot is within so many pixels of its hollow, of a 640x480 image.
WALL_PX = 6


def part_touching(things: list[Thing], around: Surroundings) -> list[Thing]:
    """Return the objects that things consist of, together the same points.

    Two patches are one object where they meet convexly, where one is the inside of a bowl or a
    cup that the other is the outside of, where both are beside one hollow, and where they are one
    surface that goes on behind something, even if the two were of different things.
    """
    box, noise = _box_around(things), around.settings.noise
    points = _window(around.points, box)
    thing: Array = np.ascontiguousarray(number_points(things, around.points.depth.shape)[box])
    patch = find_patches(thing, points, noise)
    # A thing without a patch stays in one piece.
    patch = np.where(patch > 0, patch, np.where(thing > 0, patch.max() + thing, 0))
    where = np.flatnonzero(patch)
    groups = Groups.of(where, patch.take(where))
    whose = thing.take(groups.members[groups.start[:-1]])
    support = np.array([one.support for one in things]).take(whose - 1)
    heights = _over_supports(things, thing, box, around)
    patches = Patches.measure(groups, points, heights.take(groups.members), noise)
    same = patches.meet_convexly() | patches.are_inside() | patches.go_on_behind()
    parent = np.arange(len(groups))
    join_linked(same & (support[:, None] == support), parent)
    hollows = _find_hollows(things, thing, around.is_support[box], points, box)
    reach = points.steps(WALL_PX)
    _join_around(hollows, thing, patches.number, parent, reach=reach)
    min_points = points.evidence(around.settings.min_cluster_px)
    _join_small(patches.borders[..., TOUCHING], groups.sizes, whose, min_points, parent)
    v, u = np.divmod(groups.members, thing.shape[1])
    width = around.points.depth.shape[1]
    whole = replace(groups, members=(v + box[0].start) * width + u + box[1].start)
    object_of_patch = number_sets(parent)
    support_of_object = np.empty(object_of_patch.max() + 1, np.int64)
    support_of_object[object_of_patch] = support
    objects = whole.joined(object_of_patch)
    places = places_over(objects, support_of_object, around)
    stands = np.ones(len(objects), np.bool_)
    return measure_things(objects, places, support_of_object, stands, around)


def _over_supports(
    things: list[Thing], thing: Array, box: tuple[slice, slice], around: Surroundings
) -> Array:
    """(h, w) metres of the things' points over their supports.

    thing: (h, w) int32 number of each point's thing, in the rows and columns of the box.
    """
    heights = np.zeros(thing.shape, np.float32)
    support = np.array([-1, *(one.support for one in things)]).take(thing)
    for place in sorted({one.support for one in things}):
        heights = np.where(support == place, around.supports[place].heights[box], heights)
    return heights


def _box_around(things: list[Thing]) -> tuple[slice, slice]:
    """Return the rows and columns of the grid that hold all of the things."""
    left, top, right, bottom = zip(*(thing.box for thing in things), strict=True)
    return slice(min(top), max(bottom)), slice(min(left), max(right))


def _window(points: Points, box: tuple[slice, slice]) -> Points:
    """Return the points in some rows and columns of the grid."""
    xyz, normals, depth, area = (
        np.ascontiguousarray(grid[box])
        for grid in (points.xyz, points.normals, points.depth, points.area)
    )
    return Points(
        xyz, depth, normals, area, points.x[box[1]], points.y[box[0]], points.stride, points.scale
    )


def _find_hollows(
    things: list[Thing], thing: Array, is_support: Mask, points: Points, box: tuple[slice, slice]
) -> Array:
    """(h, w) int32 number of the thing that each point is inside of, 0 = none.

    thing: (h, w) int32 number of each point's thing, in the rows and columns of the box.
    is_support: (h, w) bool, on one.
    """
    left, top = box[1].start, box[0].start
    boxes = [
        (number, (u_min - left, v_min - top, u_max - left, v_max - top))
        for number, (u_min, v_min, u_max, v_max) in enumerate((one.box for one in things), start=1)
    ]
    return find_hollows(thing, boxes, is_support, points)


def _join_around(hollows: Array, thing: Array, patch: Array, parent: Array, *, reach: int) -> None:
    """Join the patches of a thing beside one of its hollows: the wall of one pot or open box.

    All are (h, w), see `_find_hollows` and `Patches.number`. reach: cells.
    """
    if hollows.any():
        n, piece = cv2.connectedComponents((hollows > 0).astype(np.uint8), connectivity=4)
        _join_beside(hollows, piece, thing, patch, reach, np.full(n, -1), parent)


@njit(cache=True, nogil=True, error_model="numpy")
def _join_beside(
    hollows: Array, piece: Array, thing: Array, patch: Array, reach: int, wall: Array, parent: Array
) -> None:
    """Join what `_join_around` says; wall: (n_pieces,) -1, to work with: a patch of each."""
    height, width = piece.shape
    for v in range(height):
        for u in range(width):
            one = piece[v, u]
            for row in range(max(v - reach, 0), min(v + reach + 1, height) if one > 0 else 0):
                for column in range(max(u - reach, 0), min(u + reach + 1, width)):
                    if thing[row, column] == hollows[v, u]:
                        beside = patch[row, column] - 1
                        wall[one] = beside if wall[one] < 0 else wall[one]
                        join_nodes(parent, wall[one], beside)


@njit(cache=True, nogil=True, error_model="numpy")
def _join_small(touching: Array, sizes: Array, whose: Array, least: float, parent: Array) -> None:
    """Join what is too small to be an object with what it touches most, or its thing's largest.

    touching: (n, n) pairs of neighbours. sizes: (n,) points of each patch. whose: (n,) thing.
    """
    while True:
        number, total = number_sets(parent), np.zeros(len(parent), np.int64)
        for patch in range(len(sizes)):
            total[number[patch]] += sizes[patch]
        small, other = -1, -1
        for patch in range(len(sizes)):
            # The smallest set first; of those as small the first.
            is_next = small < 0 or total[number[patch]] < total[number[small]]
            if is_next and total[number[patch]] < least:
                beside = _most_touching(touching, whose, number, total, patch)
                if beside >= 0:
                    small, other = patch, beside
        if small < 0:
            return
        join_nodes(parent, small, other)


@njit(cache=True, nogil=True, error_model="numpy")
def _most_touching(touching: Array, whose: Array, number: Array, total: Array, patch: int) -> int:
    """Return a patch of another set in the same thing that this patch's set touches most.

    Of those that it touches as much, or not, it is one of the largest set; -1 = there is none.
    number: (n,) set of each patch. total: points of each set. The rest as in `_join_small`.
    """
    best, most = -1, 0
    for other in range(len(number)):
        if number[other] == number[patch] or whose[other] != whose[patch]:
            continue
        shared = 0
        for one in range(len(number)):
            shared += touching[one, other] if number[one] == number[patch] else 0
        is_same = shared == most and best >= 0 and total[number[other]] >= total[number[best]]
        if best < 0 or shared > most or is_same:
            best, most = other, shared
    return best
