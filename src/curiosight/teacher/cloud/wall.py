"""A wall: an upright plane that ends somewhere, and what is near or behind it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask, Plane, coordinates_on
from curiosight.teacher.cloud.points import Points

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
