"""Walls: vertical planes, found as peaks of a histogram over heading and distance.

As with the supports (`planes.py`), the known vertical leaves few unknowns, here two.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask, Plane, fit_plane, horizontal_axes, scatter
from curiosight.segmentation.points import Points, ends

Array = npt.NDArray[Any]

SECTOR = np.radians(3.0)
N_SECTORS = 120
ROW = 0.05
# Pieces of one wall are no farther apart than this, metres.
MAX_GAP = 0.45


@dataclass(frozen=True, slots=True, eq=False)
class Wall(Plane):
    """A vertical plane that ends somewhere.

    axes: (3, 2) its horizontal and its upward direction. low, high: (2,) metres along them
    from the origin, the camera or that of the world.
    """

    axes: Array
    low: Array
    high: Array

    def is_before(self, xyz: Array, *, margin: float = 0.10) -> Mask:
        """(n,) bool: which of (n, 3) points are straight before or behind the wall."""
        along, height = (self.axes.T.astype(xyz.dtype) @ xyz.T).astype(np.float64)
        low, high = self.low - margin, self.high + margin
        is_before = (along > low[0]) & (along < high[0]) & (height > low[1]) & (height < high[1])
        return np.asarray(is_before)

    def near(self, points: Points, free: Mask, band: Array) -> Array:
        """Return the flat indices of the `free` points within `band` of the wall, before it."""
        where = np.flatnonzero(free & (np.abs(self.distance(points.xyz)) < band))
        return where[self.is_before(points.xyz.reshape(-1, 3)[where])]


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
    vertical = free & (np.abs(points.normals @ up.astype(np.float32)) < max_cosine)
    xyz, normals, area = points.xyz[vertical], points.normals[vertical], points.area[vertical]
    thickness, is_border, is_over_table = band[vertical], border[vertical], over_tables[vertical]
    headings = _Headings(xyz, normals, up)
    is_free = np.ones(len(xyz), np.bool_)
    walls: list[Wall] = []
    for _ in range(2 * max_walls):
        normal, distance, peak_area = headings.peak(np.where(is_free, area, 0))
        if peak_area < 0.3 * min_area or len(walls) == max_walls:
            break
        near = is_free & (np.abs(xyz @ normal.astype(np.float32) + distance) < 0.08 + thickness)
        near &= normals @ normal.astype(np.float32) > 0.85
        where = np.flatnonzero(near)
        fit = fit_plane(xyz[where], thickness[where] + 0.02, normal, distance)
        if fit is None or abs(fit[0] @ up) > 0.15:
            is_free[where] = False
            continue
        normal, distance, inliers = fit
        axes = _axes_of(normal, up)
        along, height = (xyz @ axes.astype(np.float32)).T
        first, last = _longest_run(along[where[inliers]], area[where[inliers]])
        is_in_run = (along >= first) & (along <= last)
        is_near = np.abs(xyz @ normal.astype(np.float32) + distance) < thickness + 0.03
        is_free &= ~(is_near & is_in_run)
        is_free[where[inliers & is_in_run[where]]] = False
        where = where[inliers & is_in_run[where]]
        where = where[_below_top(height[where], is_over_table[where])]
        least = min_cut_diagonal if is_border[where].any() else min_diagonal
        if area[where].sum() < min_area or visible_diagonal(xyz[where], axes) < least:
            continue
        places = np.stack([along[where], height[where]], axis=1).astype(np.float64)
        low, high = places.min(axis=0), places.max(axis=0)
        walls.append(Wall(normal, distance, scatter(where, vertical), axes, low, high))
    return walls


def _axes_of(normal: Array, up: Array) -> Array:
    """Return the (3, 2) horizontal and upward directions of a wall."""
    along = np.cross(up, normal)
    return np.stack([along / np.linalg.norm(along), up], axis=1)


def _longest_run(along: Array, area: Array, *, cell: float = 0.05) -> tuple[float, float]:
    """Return the ends of the stretch without a gap of `MAX_GAP` that has the most area.

    What stands in the plane of a wall somewhere else is no part of it.
    """
    index = ((along - along.min()) / cell).astype(np.int64)
    filled = np.flatnonzero(np.bincount(index))
    run_of_cell = np.zeros(filled[-1] + 1, np.int64)
    run_of_cell[filled[1:]] = np.cumsum(np.diff(filled) * cell > MAX_GAP)
    best = int(np.argmax(np.bincount(run_of_cell[index], area)))
    chosen = along[run_of_cell[index] == best]
    return float(chosen.min()), float(chosen.max())


def _below_top(height: Array, is_over_table: Array, *, margin: float = 0.05) -> Mask:
    """(n,) bool: points over a table only as high as the wall is elsewhere, if it is."""
    elsewhere = height[~is_over_table]
    if len(elsewhere) < 50:
        return np.ones(len(height), np.bool_)
    return np.asarray(~is_over_table | (height < ends(elsewhere, 0.02)[1] + margin))


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


def visible_diagonal(xyz: Array, axes: Array) -> float:
    """Return the diagonal in metres of (n, 3) wall points, without the outermost 1 %.

    axes: (3, 2) along the wall.
    """
    if len(xyz) == 0:
        return 0.0
    low, high = np.transpose([ends(place) for place in (xyz @ axes).T])
    return float(np.linalg.norm(high - low))
