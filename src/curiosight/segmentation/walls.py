"""Walls: vertical planes, found as peaks of a histogram over heading and distance.

As with the supports (`planes.py`), the known vertical leaves few unknowns, here two.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask, Plane, fit_plane, horizontal_axes, scatter
from curiosight.segmentation.points import Points

Array = npt.NDArray[Any]

SECTOR = np.radians(3.0)
N_SECTORS = 120
ROW = 0.05


def find_walls(
    points: Points,
    up: Array,
    *,
    free: Mask,
    band: Array,
    border: Mask,
    max_cosine: float = 0.3,
    min_diagonal: float = 1.5,
    min_cut_diagonal: float = 1.0,
    min_area: float = 0.3,
    max_walls: int = 6,
) -> list[Plane]:
    """Find the vertical planes whose visible part has a diagonal of at least `min_diagonal`.

    free: (h, w) bool, the points that may belong to a wall.
    border: (h, w) bool; what touches it needs no more than `min_cut_diagonal`.
    max_cosine: |normal·up| of a point below which it votes for a wall.
    """
    vertical = free & (np.abs(points.normals @ up.astype(np.float32)) < max_cosine)
    xyz, normals, area = points.xyz[vertical], points.normals[vertical], points.area[vertical]
    thickness, is_border = band[vertical], border[vertical]
    headings = _Headings(xyz, normals, up)
    is_free = np.ones(len(xyz), np.bool_)
    walls: list[Plane] = []
    for _ in range(2 * max_walls):
        normal, distance, peak_area = headings.peak(np.where(is_free, area, 0))
        if peak_area < 0.3 * min_area or len(walls) == max_walls:
            break
        near = is_free & (np.abs(xyz @ normal.astype(np.float32) + distance) < 0.08 + thickness)
        near &= normals @ normal.astype(np.float32) > 0.85
        where = np.flatnonzero(near)
        is_free[where] = False
        fit = fit_plane(xyz[where], thickness[where] + 0.02, normal, distance)
        if fit is None or abs(fit[0] @ up) > 0.15:
            continue
        normal, distance, inliers = fit
        where = where[inliers]
        least = min_cut_diagonal if is_border[where].any() else min_diagonal
        if area[where].sum() < min_area or visible_diagonal(xyz[where], up, normal) < least:
            continue
        walls.append(Plane(normal, distance, scatter(where, vertical)))
        is_free &= np.abs(xyz @ normal.astype(np.float32) + distance) > thickness + 0.03
    return walls


class _Headings:
    """The histogram of vertical surface over heading (3°) and distance (5 cm)."""

    def __init__(self, xyz: Array, normals: Array, up: Array) -> None:
        self._right, self._forward = horizontal_axes(up)
        axes = np.stack([self._right, self._forward], axis=1).astype(np.float32)
        x, y = (xyz @ axes).T
        heading = np.arctan2(*(normals @ axes).T)
        sector = np.minimum(((heading + np.pi) / SECTOR).astype(np.int64), N_SECTORS - 1)
        centre = ((np.arange(N_SECTORS) + 0.5) * SECTOR - np.pi).astype(np.float32)
        along = np.sin(centre)[sector] * x + np.cos(centre)[sector] * y
        self._low = float(along.min()) if len(along) else 0.0
        row = ((along - self._low) / ROW).astype(np.int64)
        self._n_rows = int(row.max()) + 1 if len(row) else 1
        self._cell = sector * self._n_rows + row

    def peak(self, weights: Array) -> tuple[Array, float, float]:
        """Return normal, offset and weight of the heaviest wall: 3 sectors by 2 rows."""
        votes = np.bincount(self._cell, weights, minlength=N_SECTORS * self._n_rows)
        votes = votes.reshape(N_SECTORS, self._n_rows)
        votes[:, 1:] += votes[:, :-1]
        votes = votes + np.roll(votes, 1, axis=0) + np.roll(votes, -1, axis=0)
        sector, row = np.unravel_index(int(np.argmax(votes)), votes.shape)
        angle = (sector + 0.5) * SECTOR - np.pi
        normal = np.sin(angle) * self._right + np.cos(angle) * self._forward
        return normal, -(self._low + row * ROW), float(votes[sector, row])


def visible_diagonal(xyz: Array, up: Array, normal: Array) -> float:
    """Return the diagonal in metres of (n, 3) wall points, without the outermost 1 %."""
    if len(xyz) == 0:
        return 0.0
    along = np.cross(up, normal)
    extent = [np.ptp(np.percentile(xyz @ axis, (1, 99))) for axis in (up, along)]
    return float(np.hypot(*extent))
