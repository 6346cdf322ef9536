"""What the level surfaces of one frame belong to, where no survey knows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask, Plane, noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.footprint import REACH_PX, largest_piece
from curiosight.teacher.supports.ground import Ground, area, closed, diagonal, opened
from curiosight.teacher.supports.tops import (
    MAX_HEIGHT,
    MIN_HEIGHT,
    MIN_SURE,
    WIDEST_GAP,
    Kind,
    SeenFromAbove,
)

Array = npt.NDArray[Any]


def tops_in_frame(
    points: Points, lowest: Plane, planes: Sequence[Plane], settings: SegmentationSettings
) -> list[tuple[Plane, Kind]]:
    """Return which of the planes over the lowest are tops, and of what kind, lowest first.

    The top of what stands on another is none; small lids are left out.
    """
    planes = [plane for plane in planes if plane.inliers.any()]
    if not planes:
        return []
    where = np.flatnonzero(points.depth <= settings.max_range)
    xyz = points.xyz_at(where)
    ground = Ground.around([xyz], lowest.normal)
    cells, heights = ground.cells(xyz), lowest.distance(xyz)
    above = SeenFromAbove(
        ground,
        cells,
        heights,
        max_size=settings.floor.max_size,
        max_small_height=settings.max_small_height,
        band=noise_band(points.depth.take(where), 0.0, settings.noise),
    )
    tops: list[tuple[float, Mask, Plane]] = []
    for plane in planes:
        piece = largest_piece(plane.inliers, points.steps(REACH_PX)).ravel()[where]
        if not piece.any():
            continue
        height = float(np.median(heights[piece]))
        # Narrow strips are edges of something else, such as the back of a chair.
        top = closed(opened(closed(ground.count(cells[piece]) > 0, 0.12), 0.04), WIDEST_GAP)
        if not MIN_HEIGHT < height < MAX_HEIGHT or not top.any():
            continue
        if area(top) < settings.min_table_area or diagonal(top) < settings.min_table_diagonal:
            continue
        tops.append((height, top, plane))
    found: list[tuple[Plane, Kind]] = []
    for height, top, plane in sorted(tops, key=lambda found: -area(found[1])):
        kind = above.judge(height, top, plane.distance(xyz))
        if kind is not None and (kind is not Kind.THING or diagonal(top) >= MIN_SURE):
            found.append((plane, kind))
    return sorted(found, key=lambda found: -found[0].offset)
