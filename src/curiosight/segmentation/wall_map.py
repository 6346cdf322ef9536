"""The walls of a recording: joined from what its frames show, known again in each frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask, fit_plane
from curiosight.segmentation.points import Points
from curiosight.segmentation.walls import MAX_GAP, Wall

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


def recognise(points: Points, walls: Iterable[Wall], *, free: Mask, band: Array) -> list[Wall]:
    """Return known walls, given in the camera's frame, as this frame shows them.

    free: (h, w) bool, the points that may belong to a wall. band: (h, w) metres, see
    `noise_band`. Where a frame shows little of a wall, it has no inliers and stays as it was.
    """
    found = []
    nothing = np.zeros(free.shape, np.bool_)
    wide_band = 0.06 + band
    for wall in walls:
        if not _is_in_view(points, wall):
            found.append(replace(wall, inliers=nothing))
            continue
        near = wall.near(points, free, wide_band)
        near = near[points.normals_at(near) @ wall.normal.astype(np.float32) > 0.85]
        inliers = np.zeros(free.shape, np.bool_)
        fit = fit_plane(points.xyz_at(near), band.take(near) + 0.02, wall.normal, wall.offset)
        if fit is not None and fit[0] @ wall.normal > 0.99:
            inliers.ravel()[near[fit[2]]] = True
            wall = replace(wall, normal=fit[0], offset=fit[1])
        found.append(replace(wall, inliers=inliers))
    return found


def _is_in_view(points: Points, wall: Wall, *, margin: float = 0.3) -> bool:
    """Tell whether some of a wall, or what is within a margin in metres of it, may be in view."""
    ends = np.array([wall.low - margin, wall.high + margin])
    along, up = wall.axes.T
    corners = [
        ends[i, 0] * along + ends[j, 1] * up - (wall.offset + side) * wall.normal
        for i, j, side in product((0, 1), (0, 1), (-margin, margin))
    ]
    x, y, z = np.transpose(corners)
    left, right, top, bottom = points.x[0], points.x[-1], points.y[0], points.y[-1]
    inside = (z, x - left * z, right * z - x, y - top * z, bottom * z - y)
    return all(distance.max() > 0 for distance in inside)
