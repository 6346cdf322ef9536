"""Level surfaces on a map: which of them is a top, and where a wall is."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.supports.table_map import level_surface, map_tables
from curiosight.teacher.supports.tops import CELL, Kind, of_walls
from room import kinect

Array = npt.NDArray[Any]
UP = np.array([0.0, 0.0, 1.0])
CAMERA = kinect(160, 120)


def slab(width: float, low: float, high: float, *, at: tuple[float, float] = (0, 0)) -> Array:
    """Return points, 2 cm apart, of a square block around a place."""
    along = np.arange(-width / 2, width / 2, 0.02)
    x, y, z = np.meshgrid(along + at[0], along + at[1], np.arange(low, high, 0.02))
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)


def test_the_larger_of_two_surfaces_over_each_other_is_the_top() -> None:
    floor, top, apron = slab(2.0, 0, 0.01), slab(0.5, 0.55, 0.56), slab(0.4, 0.37, 0.38)
    jar = slab(0.12, 0.57, 0.8)
    (table,) = map_tables([top, apron], [floor, top, apron, jar], UP, 0.0)
    assert abs(table.height - 0.55) < 0.02
    assert table.kind is Kind.DOUBTFUL


def test_a_wall_goes_on_below_its_window_and_a_back_before_it_does_not() -> None:
    highest = np.full((60, 100), -np.inf)
    highest[20], highest[20, 30:70] = 2.0, 0.9
    highest[26, 30:70] = 0.9
    is_wall = of_walls(highest)
    assert is_wall[20].all()
    assert not is_wall[26].any()


def test_a_wall_without_an_end_beyond_is_not_made_longer() -> None:
    highest = np.full((60, 100), -np.inf)
    highest[20, :40], highest[20, 40:] = 2.0, 0.9
    assert not of_walls(highest)[20, 50:].any()
    assert CELL * 40 > 0.6


def before_wall() -> tuple[Points, Array]:
    """Return an upright board before a wall, tied together by veils along its upper edge."""
    depth = np.full((120, 160), 2.0)
    depth[100:, 40:120] = 1.0
    depth[97:100, 40:120] = np.array([1.75, 1.5, 1.25])[:, None]
    is_veil = np.zeros(depth.shape, np.bool_)
    is_veil[96:101] = True
    return observe_points(depth.astype(np.float32), CAMERA, stride=1), is_veil


def test_veils_are_no_level_surface() -> None:
    points, is_veil = before_wall()
    up = np.array([0.0, -1.0, 0.0])
    assert len(level_surface(points, up, 0.003, np.zeros_like(is_veil))) > 50
    assert len(level_surface(points, up, 0.003, is_veil)) == 0
