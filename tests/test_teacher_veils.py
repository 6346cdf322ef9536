"""Readings between a thing and what is behind it are of no surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.veils import MIN_SLOPE, find_veils
from room import kinect

Array = npt.NDArray[Any]
CAMERA = kinect(160, 120)


def points_of(depth: Array) -> Points:
    return observe_points(depth.astype(np.float32), CAMERA, stride=1)


def plain_veils(points: Points) -> Array:
    """Return the veils by whole arrays."""
    z, found = points.depth, np.zeros(points.depth.shape, np.bool_)
    for axis, steps in ((1, points.x), (0, points.y)):
        rise = np.diff(z, axis=axis)
        one, other = (np.delete(rise, end, axis=axis) for end in (-1, 0))
        middle = z[:, 1:-1] if axis == 1 else z[1:-1]
        least = np.float32(MIN_SLOPE * abs(steps[1] - steps[0])) * middle
        steep = ((one > least) & (other > least)) | ((one < -least) & (other < -least))
        found |= np.pad(steep, ((0, 0), (1, 1)) if axis == 1 else ((1, 1), (0, 0)))
    return found


def test_veils_are_those_of_whole_arrays() -> None:
    rng = np.random.default_rng(0)
    depth = 2 + np.cumsum(rng.normal(0, 0.05, (120, 160)), axis=1)
    depth[rng.random(depth.shape) < 0.1] = np.nan
    points = points_of(depth)
    found = find_veils(points)
    assert 0.01 < found.mean() < 0.9
    np.testing.assert_array_equal(found, plain_veils(points))


def test_a_string_of_points_to_what_is_behind_is_a_veil_and_a_clean_edge_is_none() -> None:
    clean = np.full((120, 160), 1.0)
    clean[:, 80:] = 2.0
    assert not find_veils(points_of(clean)).any()
    strung = clean.copy()
    strung[:, 79:82] = 1.25, 1.5, 1.75
    expected = np.zeros(clean.shape, np.bool_)
    expected[:, 79:82] = True
    np.testing.assert_array_equal(find_veils(points_of(strung)), expected)


@pytest.mark.parametrize("height", [0.2, 0.3, 1.5])
def test_a_floor_is_no_veil_up_to_where_it_can_be_measured(height: float) -> None:
    rows = (np.arange(120) - CAMERA.cy) / CAMERA.fy
    with np.errstate(divide="ignore"):
        floor = np.where(rows > 0, height / rows, np.nan)
    floor[floor > 5 * height] = np.nan
    assert not find_veils(points_of(np.tile(floor[:, None], 160))).any()


def test_a_few_by_chance_are_none() -> None:
    depth = np.full((120, 160), 1.0)
    depth[:, 81:] = 2.0
    depth[:40, 80] = 1.5
    assert not find_veils(points_of(depth)).any()
    depth[:, 80] = 1.5
    assert np.count_nonzero(find_veils(points_of(depth))) == 120


def test_too_small_an_image_has_none() -> None:
    assert not find_veils(points_of(np.ones((2, 2)))).any()
