"""The walls of a recording: joined from what its frames show, known again in each frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.plane_fit import fit_plane
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.walls.faces import MAX_GAP

Array = npt.NDArray[Any]

_NOWHERE = np.zeros((0, 0), np.bool_)


def moved(wall: Wall, rotation: Array, translation: Array) -> Wall:
    """Return a wall in other coordinates, rotation @ p + translation, without its inliers."""
    normal, axes = rotation @ wall.normal, rotation @ wall.axes
    offset = wall.offset - float(normal @ translation)
    shift = translation @ axes
    return Wall(normal, offset, _NOWHERE, axes, wall.low + shift, wall.high + shift)


def join_walls(
    walls: Iterable[Wall], *, min_cosine: float = 0.985, max_step: float = 0.15
) -> tuple[Wall, ...]:
    """Return the walls that pieces from several frames make up, all in the world's frame.

    min_cosine: between the normals, and max_step: metres between the planes, of one wall.
    """
    joined: list[Wall] = []
    for piece in sorted(walls, key=lambda wall: -float(np.prod(wall.high - wall.low))):
        corners = np.stack([piece.low, piece.high]) @ piece.axes.T - piece.offset * piece.normal
        for place, wall in enumerate(joined):
            is_flush = piece.normal @ wall.normal > min_cosine
            if not is_flush or np.abs(wall.distance(corners)).max() > max_step:
                continue
            ends = corners @ wall.axes
            low, high = ends.min(axis=0), ends.max(axis=0)
            if (low < wall.high + MAX_GAP).all() and (high > wall.low - MAX_GAP).all():
                low, high = np.minimum(low, wall.low), np.maximum(high, wall.high)
                joined[place] = replace(wall, low=low, high=high)
                break
        else:
            joined.append(piece)
    return tuple(joined)


def recognise(points: Points, walls: Sequence[Wall], *, free: Mask, band: Array) -> list[Wall]:
    """Return known walls, given in the camera's frame, as this frame shows them.

    free: (h, w) bool, the points that may belong to a wall. band: (h, w) metres, see
    `noise_band`. Where a frame shows little of a wall, it has no inliers and stays as it was.
    """
    found = []
    wide_band, xyz = 0.06 + band, points.xyz.reshape(-1, 3)
    free, nothing = free & (points.area > 0), np.zeros(free.shape, np.bool_)
    for wall, is_in_view in zip(walls, _are_in_view(walls, points), strict=True):
        normal, offset, inliers = wall.normal, wall.offset, nothing
        if is_in_view:
            near = np.flatnonzero(wall.near(points, free, wide_band, min_facing=0.85))
            fit = fit_plane(xyz, band.ravel(), near, normal, offset, margin=0.02)
            if fit is not None and fit[0] @ normal > 0.99:
                normal, offset = fit
                inliers = np.zeros(free.shape, np.bool_)
                _mark_within(xyz, near, np.array([*normal, offset], np.float32), band, inliers)
        found.append(Wall(normal, offset, inliers, wall.axes, wall.low, wall.high))
    return found


def _sides_of_view(points: Points) -> Array:
    """Return the (5, 3) normals, into the view, of the planes through the camera around it."""
    left, right, top, bottom = points.x[0], points.x[-1], points.y[0], points.y[-1]
    return np.array([[0, 0, 1], [1, 0, -left], [-1, 0, right], [0, 1, -top], [0, -1, bottom]])


def _are_in_view(walls: Sequence[Wall], points: Points, *, margin: float = 0.3) -> list[bool]:
    """Tell whether some of each wall, or what is within a margin of metres, may be in view."""
    sides = _sides_of_view(points)
    return [
        bool(_is_in_view(sides, wall.normal, wall.offset, wall.axes, wall.low, wall.high, margin))
        for wall in walls
    ]


@njit(cache=True, nogil=True, error_model="numpy")
def _is_in_view(
    sides: Array,
    normal: Array,
    offset: float,
    axes: Array,
    low: Array,
    high: Array,
    margin: float,
) -> bool:
    """Tell whether a box around a wall is not all beyond one of the sides, see `_sides_of_view`."""
    for side in range(len(sides)):
        along, up, away = 0.0, 0.0, 0.0
        for axis in range(3):
            along += sides[side, axis] * axes[axis, 0]
            up += sides[side, axis] * axes[axis, 1]
            away += sides[side, axis] * normal[axis]
        # The corner farthest into the view.
        farthest = -offset * away + margin * abs(away)
        for slope, first, last in ((along, low[0], high[0]), (up, low[1], high[1])):
            farthest += slope * (last + margin if slope > 0 else first - margin)
        if farthest <= 0:
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_within(xyz: Array, where: Array, plane: Array, band: Array, inliers: Array) -> None:
    """Mark in (h, w) `inliers` the points within 2 cm and their band of a plane, of (n,) places.

    xyz: (h * w, 3). plane: (4,) normal and offset. band: (h, w) metres.
    """
    a, b, c, offset = plane
    flat, bands, wider = inliers.ravel(), band.ravel(), np.float32(0.02)
    for point in where:
        gap = abs(xyz[point, 0] * a + xyz[point, 1] * b + xyz[point, 2] * c + offset)
        flat[point] = gap < bands[point] + wider
