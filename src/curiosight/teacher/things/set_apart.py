"""Things that only seem to touch what the image cuts: they stand before it, whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.things.bodies import Bodies
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.things.things import (
    Surroundings,
    Thing,
    are_standing,
    measure_things,
)

Array = npt.NDArray[Any]
# A body meets what is beside it within so many cells: readings at a step are torn.
REACH = 4
# Of where a body meets the rest of its thing, the share that must lie behind it.
MIN_BEFORE = 0.8


def set_apart(things: list[Thing], bodies: Bodies, around: Surroundings) -> list[Thing]:
    """Return the bodies in things that stand on their support, nearer than all that they meet.

    Readings that stray between a thing and what is behind it tie the two together in space; in
    the image a step in depth parts them.
    """
    shape = around.points.depth.shape
    whose = np.zeros(shape, np.int32)
    for number, thing in enumerate(things, start=1):
        whose.ravel()[thing.members] = number
    body = np.where(whose > 0, bodies.number, 0)
    counts = np.zeros((bodies.n, 2), np.int64)
    _count_meetings(whose, body, around.points.depth, around.settings.noise, counts)
    before, others = counts.T
    is_before = (before > 0) & (before >= MIN_BEFORE * (before + others))
    is_before[0] = False
    where = np.flatnonzero(is_before.take(body) & (whose > 0))
    if len(where) == 0:
        return []
    _, number = np.unique(body.take(where), return_inverse=True)
    least = around.settings.min_cluster_px / around.points.stride**2
    groups = Groups.of(where, number, min_points=max(1, int(least)))
    if len(groups) == 0:
        return []
    of_thing = np.array([0, *(thing.support for thing in things)])
    support = of_thing.take(whose.take(groups.members[groups.start[:-1]]))
    stands = are_standing(groups, support, around)
    return [thing for thing in measure_things(groups, support, stands, around) if thing.stands]


@njit(cache=True, nogil=True, error_model="numpy")
def _count_meetings(whose: Array, body: Array, depth: Array, noise: float, counts: Array) -> None:
    """Add to (n_bodies, 2) counts where a body meets other points of its thing behind it, or not.

    Points at a step that follow a body without one are made a part of it first: (h, w) `body`.
    """
    height, width = body.shape
    for v in range(height):
        for u in range(width):
            if whose[v, u] == 0 or body[v, u] != 0:
                continue
            for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                row, column = v + dv, u + du
                if row < 0 or column < 0 or row >= height or column >= width:
                    continue
                z = depth[v, u]
                is_same = whose[row, column] == whose[v, u] and body[row, column] > 0
                if is_same and abs(depth[row, column] - z) < 0.02 + 2 * noise * z * z:
                    body[v, u] = body[row, column]
                    break
    for v in range(height):
        for u in range(width):
            number = body[v, u]
            if number == 0:
                continue
            for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                row, column = v + dv, u + du
                if row < 0 or column < 0 or row >= height or column >= width:
                    continue
                if body[row, column] == number or whose[row, column] == 0:
                    continue
                row, column = v + REACH * dv, u + REACH * du
                if row < 0 or column < 0 or row >= height or column >= width:
                    continue
                if body[row, column] != number and whose[row, column] == whose[v, u]:
                    z = depth[v, u]
                    step = depth[row, column] - z
                    counts[number, 0 if step > 0.05 + 3 * noise * z * z else 1] += 1
