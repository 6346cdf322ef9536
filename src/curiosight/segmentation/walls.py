"""Walls: vertical planes, found as peaks of a histogram over heading and distance.

As with the supports (`planes.py`), the known vertical leaves few unknowns, here two.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from curiosight.segmentation.faces import Face, fit_face
from curiosight.segmentation.headings import Headings
from curiosight.segmentation.planes import (
    Mask,
    Plane,
    Surface,
    coordinates_on,
    facing,
    mask_of,
)
from curiosight.segmentation.points import Points

Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Wall(Plane):
    """A vertical plane that ends somewhere.

    axes: (3, 2) its horizontal and its upward direction. low, high: (2,) metres along them
    from the origin, the camera or that of the world.
    """

    axes: Array
    low: Array
    high: Array

    def near(
        self, points: Points, free: Mask, band: Array, *, min_facing: float, margin: float = 0.10
    ) -> Mask:
        """(h, w) bool: the `free` points within `band` of the wall, before it, and facing so.

        min_facing: least cosine between their normals and the wall's; unknown normals pass.
        """
        is_near = np.zeros(free.shape, np.bool_)
        to_wall, box = self._face(margin)
        x, y, normals = points.x, points.y, points.normals
        _mark_near(points.depth, x, y, normals, free, band, to_wall, box, min_facing, is_near)
        return is_near

    def count_sides(self, xyz: Array, *, margin: float = 0.10) -> tuple[int, int]:
        """Return how many of (n, 3) points are straight before or behind the wall, and behind.

        Behind is on or behind the wall's whole plane.
        """
        n_straight, n_behind = _count_sides(xyz, *self._face(margin))
        return n_straight, n_behind

    def _face(self, margin: float) -> tuple[Array, Array]:
        """Return (4, 3) from (x, y, z, 1) to the axes and the distance, and their (2, 2) ends."""
        box = np.empty((2, 2), np.float32)
        box[0], box[1] = self.low - margin, self.high + margin
        return coordinates_on(self.axes, self.normal, self.offset), box


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_near(
    depth: Array,
    x: Array,
    y: Array,
    normals: Array,
    free: Array,
    band: Array,
    to_wall: Array,
    box: Array,
    min_facing: float,
    is_near: Array,
) -> None:
    """Set (h, w) `is_near` as `Wall.near` says.

    depth, x, y, normals: see `Points`. to_wall, box: see `Wall._face`.
    """
    low, bottom, high, top = box[0, 0], box[0, 1], box[1, 0], box[1, 1]
    a, b, c, offset = to_wall[0], to_wall[1], to_wall[2], to_wall[3, 2]
    least = np.float32(min_facing)
    for v in range(len(y)):
        # What a row shares: the directions along its rays are those plus x times `a`.
        along_row, up_row, off_row = y[v] * b[0] + c[0], y[v] * b[1] + c[1], y[v] * b[2] + c[2]
        for u in range(len(x)):
            z = depth[v, u]
            along, up = z * (x[u] * a[0] + along_row), z * (x[u] * a[1] + up_row)
            gap = abs(z * (x[u] * a[2] + off_row) + offset)
            is_before = (along > low) & (along < high) & (up > bottom) & (up < top)
            is_near[v, u] = free[v, u] & is_before & (gap < band[v, u])
        for u in range(len(x)):
            if is_near[v, u]:
                cosine = normals[v, u, 0] * a[2] + normals[v, u, 1] * b[2] + normals[v, u, 2] * c[2]
                is_near[v, u] = not abs(cosine) < least


@njit(cache=True, nogil=True, error_model="numpy")
def _count_sides(xyz: Array, to_wall: Array, box: Array) -> tuple[int, int]:
    """Count the (n, 3) points as `Wall.count_sides` says; to_wall, box: see `Wall._face`."""
    low, bottom, high, top = box[0, 0], box[0, 1], box[1, 0], box[1, 1]
    a, b, c, offset = to_wall[0], to_wall[1], to_wall[2], to_wall[3, 2]
    n_straight, n_behind = 0, 0
    for point in range(len(xyz)):
        x, y, z = xyz[point, 0], xyz[point, 1], xyz[point, 2]
        along, up = x * a[0] + y * b[0] + z * c[0], x * a[1] + y * b[1] + z * c[1]
        n_straight += (along > low) & (along < high) & (up > bottom) & (up < top)
        n_behind += x * a[2] + y * b[2] + z * c[2] + offset <= 0
    return n_straight, n_behind


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
    vertical = facing(points, up, -max_cosine, max_cosine, free)
    rest = Surface.gather(points, band, np.flatnonzero(vertical))
    headings = Headings(rest, points.normals_at(rest.where), up)
    walls: list[Wall] = []
    for _ in range(2 * max_walls):
        normal, offset, peak_area = headings.peak(rest.area)
        if peak_area < 0.3 * min_area or len(walls) == max_walls:
            break
        face, is_used = fit_face(points, rest, up, normal, offset, band=band)
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
