"""Things parted along masks that another program drew: depth says what is an object, they where.

What a mask covers is only believed where depth leaves it open. A thing that is an object stays
one, or becomes several; of one that is none, what a mask shows whole is judged by itself.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.things.clusters import euclidean_clusters
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.things.nearest_points import nearest_points
from curiosight.teacher.things.things import (
    MAX_AT_BORDER,
    Thing,
    are_standing,
    measure_things,
    number_points,
    places_over,
)
from curiosight.teacher.things.verdicts import Verdict, judge
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
Judged = list[tuple[Thing, Verdict]]
# Of a region with more on supports and walls than this share, the background is meant.
MAX_BACKGROUND = 0.5
# A region is of one thing where so much of what is free in it belongs to that.
MIN_OF_THING = 0.7
# Of what is too large: where one region is more of it, it is that which is too large.
MAX_OF_LARGE = 0.8
# Masks end so far, metres and besides the noise, before the thing does.
RIM = 0.03


def part_along_masks(judged: Judged, regions: Array, around: Surroundings) -> Judged:
    """Return things with their verdicts, parted where masks say that one ends.

    regions: (h, w) int32, a number an instance of the masks, 0 = none.
    """
    whose = number_points((thing for thing, _ in judged), regions.shape)
    trusted = _Regions(regions, around)
    parted: Judged = []
    for number, (thing, verdict) in enumerate(judged, start=1):
        members = np.flatnonzero(whose == number)
        piece = _pieces(members, thing, trusted, around)
        if len(np.unique(piece)) < 2:
            parted.append((thing, verdict))
        elif verdict is Verdict.OBJECT:
            parted += _divided(members, piece, thing, around) or [(thing, verdict)]
        else:
            most = MAX_OF_LARGE * len(members) if verdict is Verdict.LARGE else np.inf
            shown = _shown_whole(members, piece, thing, trusted, around)
            shown = [part for part in shown if len(part.members) <= most]
            parted += [(part, Verdict.OBJECT) for part in shown]
            rest = np.setdiff1d(members, np.concatenate([[], *(part.members for part in shown)]))
            parted += [(replace(thing, members=rest), verdict)] if len(rest) else []
    return parted


class _Regions:
    """What masks say on the grid of a frame, as far as it is about things.

    drawn: (h, w) int32, as the masks have them.
    number: (h, w) int32, 0 where there is no region, or one of the background.
    n_free: (n,) points of each region on neither support nor wall. is_cut: (n,) bool.
    """

    def __init__(self, regions: Array, around: Surroundings) -> None:
        n = int(regions.max(initial=0)) + 1

        def count(where: Mask) -> Array:
            return np.bincount(regions[where], minlength=n)

        self.drawn = regions
        self.n_free = count(around.free)
        n_background = count(around.is_support | around.is_wall)
        is_background = n_background > MAX_BACKGROUND * (self.n_free + n_background)
        is_background[0] = True
        self.number: Array = np.where(is_background, 0, np.arange(n)).take(regions)
        self.is_cut = count(around.border) > MAX_AT_BORDER * np.bincount(
            regions.ravel(), minlength=n
        )


def _pieces(members: Array, thing: Thing, regions: _Regions, around: Surroundings) -> Array:
    """(n,) the region of each member, or a negative number of a cluster that is in none.

    What is beside a region, and in none, belongs to it: masks are drawn roughly. So does what
    goes along it, a rim that depth has torn, and what is thin: a leg that the mask has lost.
    """
    piece: Array = regions.number.take(members).astype(np.int64)
    n_here = np.bincount(piece, minlength=len(regions.n_free))
    piece[(n_here < MIN_OF_THING * regions.n_free).take(piece)] = 0
    outside, inside = np.flatnonzero(piece == 0), np.flatnonzero(piece)
    if len(outside) == 0 or len(inside) == 0:
        return piece
    xyz = around.points.xyz_at(members)
    gap, nearest = nearest_points(xyz[inside], xyz[outside])
    piece[outside] = piece[inside[nearest]]
    rim = RIM + around.settings.noise * thing.distance**2
    is_rest, limits = gap > rim, around.supports[thing.support].settings
    rest, gap = outside[is_rest], gap[is_rest]
    clusters = euclidean_clusters(xyz[rest], leaf=limits.leaf, tolerance=limits.tolerance)
    for cluster in range(1 + int(clusters.max(initial=-1))):
        is_in = clusters == cluster
        radius = _inner_radius(members[rest[is_in]], around)
        if np.median(gap[is_in]) > 2 * rim and radius > rim:
            piece[rest[is_in]] = -1 - cluster
    return piece


def _inner_radius(members: Array, around: Surroundings) -> float:
    """Return the metres between the outline of some points in the image and what is inmost."""
    points = around.points
    is_in = np.zeros(points.depth.shape, np.uint8)
    is_in.ravel()[members] = 1
    inside = cv2.distanceTransform(is_in, cv2.DIST_L2, 3)
    inmost = int(inside.argmax())
    return float(inside.flat[inmost] * (points.x[1] - points.x[0]) * points.depth.flat[inmost])


def _divided(members: Array, piece: Array, thing: Thing, around: Surroundings) -> Judged:
    """Return the objects that an object consists of, together the same points; [] = itself.

    What is none by itself, a lid or a handle, belongs to the nearest that is one.
    """
    pieces = _measured(members, piece, thing, around, stands=True)
    objects = [part for part in pieces if judge(part, around) is Verdict.OBJECT]
    if len(objects) < 2:
        return []
    owner_of: Array = number_points(objects, around.points.depth.shape).take(members)
    is_owned = owner_of > 0
    xyz = around.points.xyz_at(members)
    _, nearest = nearest_points(xyz[is_owned], xyz[~is_owned])
    owner_of[~is_owned] = owner_of[is_owned][nearest]
    whole = _measured(members, owner_of, thing, around, stands=True)
    return [(part, Verdict.OBJECT) for part in whole]


def _shown_whole(
    members: Array, piece: Array, thing: Thing, regions: _Regions, around: Surroundings
) -> list[Thing]:
    """Return the objects in a thing that is none: those that a mask shows whole."""
    drawn = regions.drawn.take(members)
    is_shown = (piece > 0) & ~regions.is_cut[np.maximum(piece, 0)]
    is_shown &= (drawn == piece) | (drawn == 0)
    parts = _measured(members[is_shown], piece[is_shown], thing, around, stands=False)
    return [part for part in parts if judge(part, around) is Verdict.OBJECT]


def _measured(
    members: Array, piece: Array, thing: Thing, around: Surroundings, *, stands: bool
) -> list[Thing]:
    """Return the pieces of a thing that are large enough; stands: whatever is seen of that."""
    _, number = np.unique(piece, return_inverse=True)
    groups = Groups.of(members, number)
    if len(groups) == 0:
        return []
    support = np.full(len(groups), thing.support)
    places = places_over(groups, support, around)
    standing = are_standing(groups, places, support, around) | stands
    return measure_things(groups, places, support, standing, around)
