"""The third stage: supports to supports and walls, which things are found in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import MIN_FACING, Mask, noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.wall import Faces, Wall
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.footing import Supports
from curiosight.teacher.supports.slab import NOTHING
from curiosight.teacher.supports.supports import PLANE_BAND, Support
from curiosight.teacher.walls.wall_map import moved, recognise
from curiosight.teacher.walls.walls import find_walls

Array = npt.NDArray[Any]
# A wall goes on for so many metres beyond what was seen of it.
WALL_MARGIN = 0.05


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What things are found in and judged against.

    supports: lowest first. border: (h, w) bool, what no object may touch.
    kinds: (h, w) uint8, what a point is on, see `Supports`. is_wall: (h, w) bool, within the range.
    free: (h, w) bool, within the range and on neither.
    lids: see `Supports`.
    """

    points: Points
    supports: list[Support]
    walls: list[Wall]
    border: Mask
    settings: SegmentationSettings
    kinds: Array
    is_wall: Mask
    free: Mask
    lids: Sequence[Mask] = ()

    @cached_property
    def faces(self) -> Faces:
        """The walls in one piece."""
        return Faces.of(self.walls)

    @property
    def is_support(self) -> Mask:
        """(h, w) bool: on a support, within the range."""
        is_support: Mask = self.kinds > NOTHING
        return is_support


def find_surroundings(supports: Supports, known: Iterable[Wall] = ()) -> Surroundings:
    """Return the supports of a frame with the walls around them, known ones first.

    known: the recording's walls, in the world's frame.
    """
    points, settings, free = supports.points, supports.settings, supports.free
    border = np.zeros(free.shape, np.bool_) if points.border is None else points.border
    band = noise_band(points.depth, PLANE_BAND, settings.noise)
    known = recognise(points, _before_camera(points, known), free=free, band=band)
    is_known = _on_walls(points, known, free, settings.noise)
    rest = free & ~is_known
    new = find_walls(
        points,
        # The largest support in view is the best measured vertical.
        max(supports.found, key=lambda s: np.count_nonzero(s.plane.inliers)).plane.normal,
        free=rest,
        over_tables=_over_tables(supports),
        band=band,
        border=border,
        min_diagonal=settings.min_wall_diagonal,
        min_cut_diagonal=settings.min_cut_wall_diagonal,
    )
    is_wall = is_known | _on_walls(points, new, rest, settings.noise)
    return Surroundings(
        points,
        supports.found,
        known + new,
        border,
        settings,
        supports.kinds,
        is_wall,
        free & ~is_wall,
        supports.lids,
    )


def _before_camera(points: Points, walls: Iterable[Wall]) -> list[Wall]:
    """Return walls of the world's frame in the camera's, those that face it."""
    if points.pose is None:
        return []
    rotation, centre = points.pose[:3, :3].T, points.pose[:3, 3]
    facing = [wall for wall in walls if wall.normal @ centre + wall.offset > 0]
    return [moved(wall, rotation, -rotation @ centre) for wall in facing]


def _over_tables(supports: Supports) -> Mask:
    """(h, w) bool: straight above the top of a table."""
    found = np.zeros(supports.free.shape, np.bool_)
    for support in supports.found[1:]:
        if support.extent is not None:
            found |= support.extent & (support.heights > 0)
    return found


def _on_walls(points: Points, walls: Sequence[Wall], free: Mask, noise: float) -> Mask:
    """(h, w) bool: free, within the band of a wall that this frame shows, and not facing away."""
    found = np.zeros(points.depth.shape, np.bool_)
    in_view = [wall for wall in walls if wall.inliers.any()]
    if in_view:
        band = noise_band(points.depth, 0.04, 2 * noise)
        for wall in in_view:
            found |= wall.near(points, free, band, min_facing=MIN_FACING, margin=WALL_MARGIN)
    return found
