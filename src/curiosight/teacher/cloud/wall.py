"""A wall: an upright plane that ends somewhere, and what is near or behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

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
        grids = points.depth, points.x, points.y, points.normals, free, band
        near: Mask = _find_near(*grids, *self._face(margin), min_facing)
        return near

    def _face(self, margin: float) -> tuple[Array, Array]:
        """Return (4, 3) from (x, y, z, 1) to the axes and the distance, and their (2, 2) ends."""
        box = np.array([self.low - margin, self.high + margin], np.float32)
        return coordinates_on(self.axes, self.normal, self.offset), box


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Some walls in one piece: (n, 4, 3) and (n, 2, 2), see `Wall._face`."""

    to_walls: Array
    boxes: Array

    @classmethod
    def of(cls, walls: Sequence[Wall], *, margin: float = 0.10) -> Self:
        """Return the faces of walls, which go on for a margin in metres."""
        faces = [wall._face(margin) for wall in walls]
        to_walls, boxes = zip(*faces, strict=True) if faces else ((), ())
        return cls(np.reshape(to_walls, (-1, 4, 3)), np.reshape(boxes, (-1, 2, 2)))

    def count_sides(self, points: Points, where: Array, gap: float) -> Array:
        """(n, 4) how many points at (m,) flat indices are where, as seen from each wall.

        They are those straight before or behind it; those behind or on its whole plane; those
        within a gap in metres of that, and within two.
        """
        xyz = points.xyz.reshape(-1, 3)
        counts: Array = _count_sides(xyz, where, self.to_walls, self.boxes, gap)
        return counts


@njit(cache=True, nogil=True, error_model="numpy")
def _find_near(
    depth: Array,
    x: Array,
    y: Array,
    normals: Array,
    free: Array,
    band: Array,
    to_wall: Array,
    box: Array,
    min_facing: float,
) -> Array:
    """Return what `Wall.near` does; depth, x, y, normals: see `Points`."""
    is_near = np.zeros(free.shape, np.bool_)
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
    return is_near


@njit(cache=True, nogil=True, error_model="numpy")
def _count_sides(xyz: Array, where: Array, to_walls: Array, boxes: Array, gap: float) -> Array:
    """Return what `Faces.count_sides` does; xyz: (k, 3)."""
    counts = np.zeros((len(boxes), 4), np.int64)
    least, wide = np.float32(gap), np.float32(2 * gap)
    for wall in range(len(counts)):
        low, bottom = boxes[wall, 0, 0], boxes[wall, 0, 1]
        high, top = boxes[wall, 1, 0], boxes[wall, 1, 1]
        a, b, c = to_walls[wall, 0], to_walls[wall, 1], to_walls[wall, 2]
        offset = to_walls[wall, 3, 2]
        for point in where:
            x, y, z = xyz[point, 0], xyz[point, 1], xyz[point, 2]
            along, up = x * a[0] + y * b[0] + z * c[0], x * a[1] + y * b[1] + z * c[1]
            distance = x * a[2] + y * b[2] + z * c[2] + offset
            counts[wall, 0] += (along > low) & (along < high) & (up > bottom) & (up < top)
            counts[wall, 1] += distance <= 0
            counts[wall, 2] += abs(distance) < least
            counts[wall, 3] += abs(distance) < wide
    return counts
