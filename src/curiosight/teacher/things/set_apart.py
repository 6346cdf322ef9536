"""Things that only seem to touch what the image cuts: they stand before it, whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.things.bodies import Bodies
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.things.things import (
    Thing,
    are_standing,
    measure_things,
    number_points,
    places_over,
)
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
# A body meets what is beside it within so many pixels of a 640x480 image: readings at a step are
# torn.
REACH_PX = 12
# Of where a body meets the rest of its thing, the share that must lie behind it.
MIN_BEFORE = 0.8


def set_apart(things: list[Thing], bodies: Bodies, around: Surroundings) -> list[Thing]:
    """Return the bodies in things that stand on their support, nearer than all that they meet.

    Readings that stray between a thing and what is behind it tie the two together in space; in
    the image a step in depth parts them.
    """
    depth, noise = around.points.depth, around.settings.noise
    whose = number_points(things, depth.shape)
    body = np.where(whose > 0, bodies.number, 0)
    _join_edges(whose, body, depth, noise)
    counts = np.zeros((bodies.n, 2), np.int64)
    _count_meetings(whose, body, depth, noise, around.points.steps(REACH_PX), counts)
    # What is in no body is counted nowhere.
    is_before = counts[:, 0] > MIN_BEFORE * counts.sum(axis=1)
    if not is_before.any():
        return []
    where = np.flatnonzero(is_before.take(body))
    least = around.points.evidence(around.settings.min_cluster_px)
    groups = Groups.of(where, body.take(where), min_points=max(1, int(least)))
    if len(groups) == 0:
        return []
    support_of = np.array([0, *(thing.support for thing in things)])
    support = support_of.take(whose.take(groups.members[groups.start[:-1]]))
    places = places_over(groups, support, around)
    stands = are_standing(groups, places, support, around)
    if not stands.any():
        return []
    measured = measure_things(groups, places, support, stands, around)
    return [thing for thing in measured if thing.stands]


@njit(cache=True, nogil=True, error_model="numpy")
def _join_edges(whose: Array, body: Array, depth: Array, noise: float) -> None:
    """Make points at a step a part of the body beside them that they follow without one.

    Changes (h, w) `body`, 0 = none. whose: (h, w), the thing of each point, 0 = none.
    """
    height, width = body.shape
    for v in range(height):
        for u in range(width):
            if whose[v, u] == 0 or body[v, u] != 0:
                continue
            z = depth[v, u]
            for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                row = min(max(v + dv, 0), height - 1)
                column = min(max(u + du, 0), width - 1)
                is_same = whose[row, column] == whose[v, u] and body[row, column] > 0
                if is_same and abs(depth[row, column] - z) < 0.02 + 2 * noise * z * z:
                    body[v, u] = body[row, column]
                    break


@njit(cache=True, nogil=True, error_model="numpy")
def _count_meetings(
    whose: Array, body: Array, depth: Array, noise: float, reach: int, counts: Array
) -> None:
    """Add to (n_bodies, 2) counts where the rest of its thing is behind a body, and where not.

    whose, body: (h, w), see `_join_edges`. reach: cells beside the body.
    """
    height, width = body.shape
    for v in range(height):
        for u in range(width):
            number = body[v, u]
            for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                row, column = v + reach * dv, u + reach * du
                if number == 0 or min(row, column) < 0 or row >= height or column >= width:
                    continue
                is_outline = body[v + dv, u + du] != number and whose[v + dv, u + du] > 0
                is_rest = body[row, column] != number and whose[row, column] == whose[v, u]
                if is_outline and is_rest:
                    z = depth[v, u]
                    is_behind = depth[row, column] - z > 0.05 + 3 * noise * z * z
                    counts[number, 0 if is_behind else 1] += 1
