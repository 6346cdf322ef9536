"""Walls: vertical planes, found as peaks of a histogram over heading and distance.

As with the supports (`planes.py`), the known vertical leaves few unknowns, here two.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask, Plane, fit_plane, horizontal_axes, scatter
from curiosight.segmentation.points import Points

Array = npt.NDArray[Any]

SECTOR = np.radians(3.0)
N_SECTORS = 120
ROW = 0.05
# Pieces of one wall are no farther apart, metres.
MAX_GAP = 0.45


@dataclass(frozen=True, slots=True, eq=False)
class Wall(Plane):
    """A vertical plane that ends somewhere.

    axes: (3, 2) its horizontal and its upward direction. low, high: (2,) metres along them,
    from the camera or, for a wall of a recording, from the world's origin.
    """

    axes: Array
    low: Array
    high: Array

    def is_beside(self, xyz: Array, *, margin: float = 0.10) -> Mask:
        """(...) bool: which (..., 3) points are straight before or behind the wall."""
        place = xyz @ self.axes.astype(xyz.dtype)
        beside: Mask = ((place > self.low - margin) & (place < self.high + margin)).all(axis=-1)
        return beside

    def moved(self, rotation: Array, translation: Array) -> Wall:
        """Return it in other coordinates: rotation @ p + translation."""
        normal, axes = rotation @ self.normal, rotation @ self.axes
        offset = self.offset - float(normal @ translation)
        shift = translation @ axes
        return Wall(normal, offset, self.inliers, axes, self.low + shift, self.high + shift)


def known_walls(points: Points, walls: Iterable[Wall], *, free: Mask, band: Array) -> list[Wall]:
    """Return the known walls, in the camera's frame, as this frame shows them.

    Where it shows little of one, the wall stays as it was, without inliers.
    """
    found = []
    for wall in walls:
        near = free & (np.abs(wall.distance(points.xyz)) < 0.06 + band)
        near &= points.normals @ wall.normal.astype(np.float32) > 0.85
        near &= wall.is_beside(points.xyz)
        fit = fit_plane(points.xyz[near], band[near] + 0.02, wall.normal, wall.offset)
        if fit is None or fit[0] @ wall.normal < 0.99:
            found.append(replace(wall, inliers=np.zeros(free.shape, np.bool_)))
            continue
        normal, offset, inliers = fit
        found.append(replace(wall, normal=normal, offset=offset, inliers=scatter(inliers, near)))
    return found


def join_walls(walls: Iterable[Wall], *, max_gap: float = MAX_GAP) -> tuple[Wall, ...]:
    """Return the walls of a recording from what its frames saw of them, in the world's frame.

    max_gap: metres between pieces of one wall.
    """
    joined: list[Wall] = []
    for wall in sorted(walls, key=lambda wall: -float(np.prod(wall.high - wall.low))):
        corners = wall.axes @ np.stack([wall.low, wall.high], axis=1) - wall.offset * wall.normal[:, None]
        for place, other in enumerate(joined):
            if wall.normal @ other.normal < 0.985 or np.abs(other.distance(corners.T)).max() > 0.15:
                continue
            ends = corners.T @ other.axes
            low, high = ends.min(axis=0), ends.max(axis=0)
            if (low < other.high + max_gap).all() and (high > other.low - max_gap).all():
                low, high = np.minimum(low, other.low), np.maximum(high, other.high)
                joined[place] = replace(other, low=low, high=high)
                break
        else:
            joined.append(wall)
    return tuple(joined)


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
    thickness, is_border = band[vertical], border[vertical]
    height, is_over_table = xyz @ up.astype(np.float32), over_tables[vertical]
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
        along = np.cross(up, normal) / np.linalg.norm(np.cross(up, normal))
        place = xyz @ along.astype(np.float32)
        where = where[inliers]
        run = _longest_run(place[where], area[where])
        where = where[(place[where] >= run[0]) & (place[where] <= run[1])]
        where = where[_below_top(height[where], is_over_table[where])]
        is_near = np.abs(xyz @ normal.astype(np.float32) + distance) < thickness + 0.03
        is_free &= ~(is_near & (place >= run[0]) & (place <= run[1]))
        least = min_cut_diagonal if is_border[where].any() else min_diagonal
        if area[where].sum() < min_area or visible_diagonal(xyz[where], up, normal) < least:
            continue
        axes = np.stack([along, up], axis=1)
        low, high = np.percentile(xyz[where] @ axes, (1, 99), axis=0)
        walls.append(Wall(normal, distance, scatter(where, vertical), axes, low, high))
    return walls


def _below_top(height: Array, is_over_table: Array, *, margin: float = 0.05) -> Array:
    """(n,) bool: points over a table only as high as the wall is elsewhere, if it is."""
    rest = height[~is_over_table]
    if len(rest) < 50:
        return np.ones(len(height), np.bool_)
    low_enough: Array = ~is_over_table | (height < np.percentile(rest, 98) + margin)
    return low_enough


def _longest_run(place: Array, area: Array, *, cell: float = 0.05) -> tuple[float, float]:
    """Return the ends of the stretch without a gap of `MAX_GAP` that has the most area.

    What stands in the plane of a wall somewhere else is no part of it.
    """
    low = float(place.min())
    index = ((place - low) / cell).astype(np.int64)
    filled = np.flatnonzero(np.bincount(index))
    run_of_cell = np.zeros(filled[-1] + 1, np.int64)
    run_of_cell[filled[1:]] = np.cumsum(np.diff(filled) * cell > MAX_GAP)
    best = int(np.argmax(np.bincount(run_of_cell[index], area)))
    chosen = place[run_of_cell[index] == best]
    return float(chosen.min()), float(chosen.max())


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
