"""The supports of one frame: which horizontal planes are floor or table, and how far they reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask, Plane, find_supports, horizontal_axes, noise_band
from curiosight.segmentation.points import Points
from curiosight.segmentation.settings import SegmentationSettings, SupportSettings

Array = npt.NDArray[Any]
Scene = Literal["floor", "table"]

# Half the thickness of a plane in the fits, beside the sensor's noise.
PLANE_BAND = 0.008
# An elevated support is a table, not a box's lid or a seat, from this size on.
MIN_TABLE_AREA = 0.25
MIN_TABLE_DIAGONAL = 0.7
# Supports within this height (metres) are one; pose drift and tilt stay below it.
SAME_HEIGHT = 0.10


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """A plane that objects stand on, with the thresholds for what stands on it."""

    plane: Plane
    settings: SupportSettings
    is_table: bool

    def heights(self, points: Points) -> Array:
        """(h, w) metres over the support."""
        return self.plane.distance(points.xyz)


def choose_supports(
    points: Points,
    up: Array,
    settings: SegmentationSettings,
    *,
    scene: Scene,
    camera_height: float | None = None,
    table_heights: tuple[float, ...] = (),
) -> list[Support]:
    """Return the supports in view, lowest first; empty when there is none.

    scene: what the lowest support is.
    camera_height: metres over the floor where the recording tells it: then the floor is
        known even where it is hidden, and nothing below it is a support.
    table_heights: metres over the floor; a plane there is a table even where little of it is
        in view.
    """
    planes = find_planes(points, up, settings)
    main = max(planes, key=lambda plane: _area(points, plane), default=None)
    known = [camera_height - h for h in table_heights] if camera_height is not None else []
    planes = [
        p
        for p in planes
        if p is main or _is_large(points, p, up) or any(abs(p.offset - k) < 0.06 for k in known)
    ]
    if camera_height is not None:
        floor = _floor_at(points, up, planes, camera_height, settings.noise)
        planes = [p for p in planes if p.offset < floor.offset - SAME_HEIGHT]
        tables = [Support(plane, settings.table, True) for plane in _lowest(planes)]
        return [Support(floor, settings.floor, False), *tables]
    supports = []
    for rank, plane in enumerate(_lowest(planes)):
        is_table = scene == "table" or rank > 0
        supports.append(Support(plane, settings.table if is_table else settings.floor, is_table))
    return supports


def find_planes(points: Points, up: Array, settings: SegmentationSettings) -> list[Plane]:
    """Return the horizontal planes within range, whatever they are."""
    band = noise_band(points, PLANE_BAND, settings.noise)
    return find_supports(points, up, band=band, max_range=settings.max_range)


def share_below(points: Points, plane: Plane) -> float:
    """Return the share of the points with a reading that lie clearly below a plane."""
    seen = np.isfinite(points.depth)
    gap = 0.10 + 0.02 * points.depth[seen] ** 2
    return float(np.mean(plane.distance(points.xyz[seen]) < -gap))


def _lowest(planes: list[Plane]) -> list[Plane]:
    """Sort by height, the lowest (farthest below the camera) first."""
    return sorted(planes, key=lambda plane: -plane.offset)


def _area(points: Points, plane: Plane) -> float:
    return float(points.area[plane.inliers].sum())


def _is_large(points: Points, plane: Plane, up: Array) -> bool:
    right, forward = horizontal_axes(up)
    xyz = points.xyz[plane.inliers]
    extent = [np.ptp(np.percentile(xyz @ axis, (2, 98))) for axis in (right, forward)]
    is_wide = float(np.hypot(*extent)) >= MIN_TABLE_DIAGONAL
    return is_wide and _area(points, plane) >= MIN_TABLE_AREA


def _floor_at(
    points: Points, up: Array, planes: list[Plane], camera_height: float, noise: float
) -> Plane:
    """Return the floor's plane: as seen, else through the few level points near its height."""
    seen = [p for p in planes if abs(p.offset - camera_height) < SAME_HEIGHT]
    if seen:
        return max(seen, key=lambda plane: _area(points, plane))
    heights = points.xyz @ up.astype(np.float32)
    near = points.normals @ up.astype(np.float32) > 0.9
    near &= np.abs(heights + camera_height) < noise_band(points, 0.06, noise)
    offset = -float(np.median(heights[near])) if near.sum() >= 30 else camera_height
    return Plane(up, offset, near)


def above_footprint(
    points: Points, plane: Plane, *, margin: float = 0.05, cell: float = 0.02
) -> Mask:
    """(h, w) bool: points straight above or below the convex hull of the plane's largest piece.

    margin: metres around the hull.
    """
    right, forward = horizontal_axes(plane.normal)
    pieces, piece, stats, _ = cv2.connectedComponentsWithStats(
        cv2.dilate(plane.inliers.astype(np.uint8), np.ones((5, 5), np.uint8))
    )
    inside = np.zeros(plane.inliers.shape, np.bool_)
    if pieces < 2:
        return inside
    largest = plane.inliers & (piece == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
    axes = np.stack([right, forward], axis=1).astype(np.float32)
    hull = cv2.convexHull(np.ascontiguousarray(points.xyz[largest] @ axes)).reshape(-1, 2)
    low = (hull.min(axis=0) - 2 * margin).astype(np.float32)
    width, height = np.ceil((hull.max(axis=0) + 2 * margin - low) / cell).astype(int) + 1
    drawn = np.zeros((height, width), np.uint8)
    cv2.fillConvexPoly(drawn, np.round((hull - low) / cell).astype(np.int32), 1)
    reach = 2 * round(margin / cell) + 1
    drawn = cv2.dilate(drawn, np.ones((reach, reach), np.uint8))
    column, row = np.moveaxis((points.xyz @ axes - low) / cell, -1, 0)
    # Points without a reading are NaN and compare false.
    is_drawn = (column > -0.5) & (column < width - 0.5) & (row > -0.5) & (row < height - 0.5)
    column, row = (np.rint(x[is_drawn]).astype(np.int64) for x in (column, row))
    inside[is_drawn] = drawn[np.minimum(row, height - 1), np.minimum(column, width - 1)] > 0
    return inside
