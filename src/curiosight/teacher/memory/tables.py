"""The tables of a recording, by the frames of a survey together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.veils import find_veils
from curiosight.teacher.memory.places import neighbourhoods
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.table_map import Table, level_surface, map_tables

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]
# Of a 640x480 image, every so many rows and columns are looked at.
SURVEY_STRIDE = 2


def find_tables(
    posed: list[tuple[Points, Pose]], up: Array, floor: float, settings: SegmentationSettings
) -> tuple[Table, ...]:
    """Return the tables of every place where the camera was."""
    parts = neighbourhoods(np.array([pose[:3, 3] for _, pose in posed]))
    places = [[posed[row] for row in rows] for rows in parts]
    return tuple(table for near in places for table in _tables_at(near, up, floor, settings))


def _tables_at(
    posed: list[tuple[Points, Pose]], up: Array, floor: float, settings: SegmentationSettings
) -> tuple[Table, ...]:
    veils = [find_veils(points) for points, _ in posed]
    # A sensor that smooths does so in every frame; a frame alone may show a table from the edge.
    smooths = 2 * sum(bool(is_veil.any()) for is_veil in veils) > len(veils)
    views = [
        _View(points, pose, is_veil & smooths, settings.max_range)
        for (points, pose), is_veil in zip(posed, veils, strict=True)
    ]
    return map_tables(
        (view.level(up, settings.noise) for view in views),
        _Seen(views),
        up,
        floor,
        max_size=settings.floor.max_size,
        min_area=settings.min_table_area,
        min_diagonal=settings.min_table_diagonal,
        density=float(np.mean([points.count(SURVEY_STRIDE**2) for points, _ in posed])),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """What a frame shows up to a range in metres; is_veil: (h, w) bool, what is no surface."""

    points: Points
    T_world_camera: Pose
    is_veil: Mask
    max_range: float

    def level(self, up: Array, noise: float) -> Array:
        """Return (n, 3) points in the world of the level surfaces."""
        up_camera = self.T_world_camera[:3, :3].T @ up
        return self._in_world(level_surface(self.points, up_camera, noise, self.is_veil))

    def seen(self) -> Array:
        """Return (n, 3) points in the world of all surfaces."""
        return self._in_world(self.points.xyz[~self.is_veil])

    def _in_world(self, xyz: Array) -> Array:
        near = xyz[xyz[:, 2] < self.max_range]
        world: Array = near @ self.T_world_camera[:3, :3].T + self.T_world_camera[:3, 3]
        return world


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """The points that each view shows, made anew whenever they are gone through."""

    views: Sequence[_View]

    def __iter__(self) -> Iterator[Array]:
        return (view.seen() for view in self.views)
