"""The supports of one frame: which horizontal planes are floor or table, and how far they reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask, Plane, find_supports, horizontal_axes, noise_band
from curiosight.segmentation.points import Points
from curiosight.segmentation.settings import SegmentationSettings, SupportSettings
from curiosight.segmentation.tables import MARGIN, MIN_TABLE_AREA, MIN_TABLE_DIAGONAL, SAME_HEIGHT

Array = npt.NDArray[Any]
Scene = Literal["floor", "table"]

# Half the thickness of a plane in the fits, beside the sensor's noise.
PLANE_BAND = 0.008


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """A plane that objects stand on, with the thresholds for what stands on it.

    extent: (h, w) bool, what is straight above or below a table; None for a floor.
    sure: (h, w) bool, the part of the extent that is not just beside the table.
    skirt: (h, w) bool, what is close to a known table, seen from above; None = not known.
    is_seat: a sofa or a bed, see `Table`.
    """

    plane: Plane
    settings: SupportSettings
    extent: Mask | None = None
    sure: Mask | None = None
    skirt: Mask | None = None
    is_seat: bool = False

    @property
    def is_table(self) -> bool:
        return self.extent is not None

    def heights(self, points: Points) -> Array:
        """(h, w) metres over the support."""
        return self.plane.distance(points.xyz)


@dataclass(frozen=True, slots=True, eq=False)
class KnownTable:
    """A table of the recording, as a frame's camera has it.

    offset: metres that it lies below the camera. inset: (h, w) metres, see `Table.inset`.
    """

    offset: float
    inset: Array
    is_seat: bool = False


def choose_supports(
    points: Points,
    up: Array,
    settings: SegmentationSettings,
    *,
    scene: Scene,
    camera_height: float | None = None,
    known_tables: Sequence[KnownTable] = (),
) -> list[Support]:
    """Return the supports in view, lowest first; empty when there is none.

    scene: what the lowest support is.
    camera_height: metres over the floor where the recording tells it: then the floor is
        known even where it is hidden, and nothing below it is a support.
    known_tables: there are tables even where little or nothing of their tops is in view.
    """
    planes = find_planes(points, up, settings)
    main = max(planes, key=lambda plane: _area(points, plane), default=None)
    large = [p for p in planes if p is main or _is_large(points, p, up)]
    if camera_height is None:
        first, *others = _lowest(large) or [None]
        if first is None:
            return []
        lowest = _table(points, first, settings) if scene == "table" else Support(first, settings.floor)
        return [lowest, *(_table(points, plane, settings) for plane in others)]
    floor = _plane_at(points, up, planes, camera_height, settings.noise)
    known = [
        _known_support(points, up, planes, table, settings)
        for table in known_tables
        if (table.inset > -MARGIN).any()
    ]
    is_known = np.any([support.extent for support in known], axis=0) if known else np.False_
    new = [
        _table(points, plane, settings)
        for plane in large
        if plane.offset < floor.offset - SAME_HEIGHT
        and np.count_nonzero(plane.inliers & is_known) < 0.5 * np.count_nonzero(plane.inliers)
    ]
    tables = sorted([*known, *new], key=lambda support: -support.plane.offset)
    return [Support(floor, settings.floor), *tables]


def _known_support(
    points: Points,
    up: Array,
    planes: list[Plane],
    table: KnownTable,
    settings: SegmentationSettings,
) -> Support:
    """Return a known table as this frame shows it.

    Where the frame shows its top, the outline there is sharper than the map's.
    """
    extent = table.inset > -MARGIN
    plane = _plane_at(points, up, planes, table.offset, settings.noise, extent)
    seen = above_footprint(points, plane)
    sure = table.inset > 0.25
    if np.count_nonzero(plane.inliers & extent & seen) >= 50:
        extent, sure = extent | seen, sure | seen
    beside = 0.25 if table.is_seat else 0.15
    return Support(plane, settings.table, extent, sure, table.inset > -beside, table.is_seat)


def _table(points: Points, plane: Plane, settings: SegmentationSettings) -> Support:
    return Support(plane, settings.table, above_footprint(points, plane))


def settle(free: Mask, support: Support, points: Points, noise: float) -> Mask:
    """(h, w) bool: a table's extent without what only leans over its edge, such as a chair.

    Free points that follow each other without a step in depth are one body. It is beside the
    table where most of it is, or where it goes on below the top and hardly reaches inside.
    """
    assert support.extent is not None
    depth, heights = points.depth, support.heights(points)
    smooth = free.copy()
    step = 0.02 + 2 * noise * depth**2
    smooth[:, 1:] &= np.abs(depth[:, 1:] - depth[:, :-1]) < step[:, 1:]
    smooth[1:] &= np.abs(depth[1:] - depth[:-1]) < step[1:]
    n_bodies, body = cv2.connectedComponents(smooth.astype(np.uint8), connectivity=4)
    size = np.bincount(body.ravel(), minlength=n_bodies)

    def share(where: Mask) -> Array:
        return np.bincount(body[where], minlength=n_bodies) / np.maximum(size, 1)

    is_beside = share(support.extent) < 0.5
    if support.sure is not None:
        leans = (share(heights > 0.03) > 0.05) & (share(heights < -0.03) > 0.05)
        is_beside |= leans & (share(support.sure) < 0.3)
    is_beside[0] = False
    settled: Mask = support.extent & ~is_beside[body]
    return settled


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


def _height(points: Points, plane: Plane, up: Array) -> float:
    """Return a plane's height over the camera where it was seen, not below the camera itself."""
    return float(np.median(points.xyz[plane.inliers] @ up.astype(np.float32)))


def _is_large(points: Points, plane: Plane, up: Array) -> bool:
    if _area(points, plane) < MIN_TABLE_AREA:
        return False
    xyz = points.xyz[plane.inliers]
    extent = [np.ptp(np.percentile(xyz @ axis, (2, 98))) for axis in horizontal_axes(up)]
    return float(np.hypot(*extent)) >= MIN_TABLE_DIAGONAL


def _plane_at(
    points: Points,
    up: Array,
    planes: list[Plane],
    offset: float,
    noise: float,
    extent: Mask | None = None,
) -> Plane:
    """Return the plane at a known height: as seen, else through the few level points near it."""
    tolerance = SAME_HEIGHT if extent is None else 0.06
    seen = [p for p in planes if abs(_height(points, p, up) + offset) < tolerance]
    if extent is not None:
        seen = [p for p in seen if np.count_nonzero(p.inliers & extent) >= 50]
    if seen:
        return max(seen, key=lambda plane: _area(points, plane))
    heights = points.xyz @ up.astype(np.float32)
    near = points.normals @ up.astype(np.float32) > 0.9
    near &= np.abs(heights + offset) < noise_band(points, 0.06, noise)
    if extent is not None:
        near &= extent
    measured = -float(np.median(heights[near])) if near.sum() >= 30 else offset
    return Plane(up, measured, near)


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
