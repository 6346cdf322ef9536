"""Walls: vertical planes, found as peaks of a histogram over heading and distance.

As with the supports (`planes.py`), the known vertical leaves few unknowns, here two.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask, Surface, mask_of
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.walls.faces import Face, fit_face
from curiosight.teacher.walls.headings import Headings

Array = npt.NDArray[Any]


def find_walls(
    points: Points,
    up: Array,
    *,
    free: Mask,
    over_tables: Mask,
    band: Array,
    border: Mask,
    max_cosine: float = 0.3,
    min_diagonal: float = 1.5,
    min_cut_diagonal: float = 1.0,
    min_area: float = 0.3,
    max_walls: int = 6,
) -> list[Wall]:
    """Find the vertical planes whose visible part has a diagonal of at least `min_diagonal`.

    free: (h, w) bool, the points that may belong to a wall.
    over_tables: (h, w) bool: what stands on a cupboard, in the plane of its front, is no part
        of the front.
    border: (h, w) bool; what touches it needs no more than `min_cut_diagonal`.
    max_cosine: |normal·up| of a point below which it votes for a wall.
    """
    rest = Surface.facing(points, band, free, up, -max_cosine, max_cosine)
    headings = Headings(rest, up)
    walls: list[Wall] = []
    for _ in range(2 * max_walls):
        normal, offset, peak_area = headings.peak(rest.area)
        if peak_area < 0.3 * min_area or len(walls) == max_walls:
            break
        face, is_used = fit_face(points, rest, up, normal, offset, band=band)
        if face is None:
            # Else the same peak comes again, and hides all lower ones.
            is_used |= headings.voters()
        left = np.flatnonzero(~is_used)
        rest = rest.at(left)
        headings.keep(left)
        if face is None:
            continue
        face = face.below_top(over_tables.take(face.surface.where))
        least = min_cut_diagonal if border.take(face.surface.where).any() else min_diagonal
        if face.surface.area.sum() >= min_area and face.diagonal() >= least:
            walls.append(_wall(face, free.shape))
    return walls


def _wall(face: Face, shape: tuple[int, ...]) -> Wall:
    """Return a face as a wall, on a grid of a shape."""
    places = face.places.astype(np.float64)
    inliers = mask_of(face.surface.where, shape)
    low, high = places.min(axis=0), places.max(axis=0)
    return Wall(face.normal, face.offset, inliers, face.axes, low, high)
