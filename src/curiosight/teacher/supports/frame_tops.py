"""What the level surfaces of one frame belong to, where no survey knows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Plane, noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.footprint import REACH_PX, largest_piece
from curiosight.teacher.supports.ground import Ground, Mask, area, closed, diagonal, opened
from curiosight.teacher.supports.tops import (
    MAX_HEIGHT,
    MAX_RISE,
    MIN_HEIGHT,
    MIN_RISE,
    MIN_SURE,
    WIDEST_GAP,
    Kind,
    TopView,
    stands_on_any,
)

Array = npt.NDArray[Any]


def tops_in_frame(
    points: Points, lowest: Plane, planes: Sequence[Plane], settings: SegmentationSettings
) -> list[tuple[Plane, Kind]]:
    """Return which of the planes over the lowest are tops, and of what kind, lowest first.

    The top of what stands on another is none; small lids are left out.
    """
    if not planes:
        return []
    where = np.flatnonzero(points.depth <= settings.max_range)
    xyz = points.xyz_at(where)
    ground = Ground.around(xyz, lowest.normal)
    cells, heights = ground.cells(xyz), lowest.distance(xyz)
    band = noise_band(points.depth.take(where), 0.0, settings.noise)
    highest = ground.highest(cells, heights)
    n_over_floor = ground.count(cells[heights > 0.10 + band])
    is_seen = ground.count(cells) > 0
    found: list[tuple[Plane, Kind]] = []
    lower: list[Mask] = []
    highest_small = settings.max_small_height
    seats: list[Mask] = []
    for plane in sorted(planes, key=lambda plane: -plane.offset):
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
        if stands_on_any(top, lower):
            continue
        over = plane.distance(xyz)
        rises = (over > MIN_RISE + band) & (over < MAX_RISE)
        n_rising = ground.count(cells[rises])
        n_sides = ground.count(cells[(heights > 0.3 * height) & (heights < 0.8 * height)])
        view = TopView(
            height, top, highest, n_sides, n_rising, n_over_floor, is_seen, highest_small
        )
        kind = view.kind(settings.floor.max_size, seats)
        if kind is Kind.FURNITURE:
            seats.append(top)
        lower.append(top)
        if kind is not Kind.THING or diagonal(top) >= MIN_SURE:
            found.append((plane, kind))
    return found
