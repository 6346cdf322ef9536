"""Where depth ends inside the image: what ends there is cut, what ends before nothing is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation, Survey, Teacher, Verdict
from curiosight.teacher.cloud.outline import Side, cut_by, find_outline
from curiosight.teacher.cloud.points import Points, observe_points
from room import Box
from scenes import CAMERA, ON_TABLE, TABLE_TOP, WALL, kinect_noise, see

NEAR_WALL = replace(WALL, centre=(0.0, 1.6, 1.25))
CUBE = Box((0.0, 0.0, 0.15), (0.30, 0.30, 0.30), (200, 40, 40))
V, U = np.mgrid[: CAMERA.height, : CAMERA.width]
Mask = npt.NDArray[np.bool_]


def without(frame: Frame, is_blind: Mask) -> Frame:
    assert frame.depth is not None
    noisy = kinect_noise(frame.depth, np.random.default_rng(0))
    return replace(frame, depth=np.where(is_blind, np.float32(np.nan), noisy))


def outside(u_min: int, v_min: int, u_max: int, v_max: int) -> Mask:
    """(H, W) bool: what registered depth does not show."""
    return (u_min > U) | (v_min > V) | (u_max <= U) | (v_max <= V)


def blind_strip(frame: Frame, baseline: float) -> Mask:
    """(H, W) bool: what the second camera of a stereo pair does not see, at the left."""
    assert frame.depth is not None
    return U * frame.depth < baseline * CAMERA.fx


def points_of(frame: Frame) -> Points:
    assert frame.depth is not None
    assert frame.camera is not None
    return observe_points(frame.depth, frame.camera, stride=3)


def verdicts(found: Segmentation) -> list[Verdict]:
    return [cluster.verdict for cluster in found.clusters]


@pytest.mark.parametrize("u_max", [300, 345])
def test_object_is_cut_where_registered_depth_ends(u_max: int) -> None:
    frame, view = see((CUBE, NEAR_WALL))
    columns = np.flatnonzero((view.surface == 1).any(axis=0))
    assert columns[0] < u_max < columns[-1]
    assert verdicts(Teacher().segment(without(frame, U < 0))) == [Verdict.OBJECT]
    found = Teacher().segment(without(frame, outside(14, 20, u_max, 470)))
    assert verdicts(found) == [Verdict.CUT]


def test_object_is_cut_by_the_blind_strip_of_a_stereo_camera() -> None:
    cube = replace(CUBE, centre=(-0.95, 0.0, 0.15))
    wall = replace(WALL, centre=(0.0, 2.4, 1.25))
    frame, view = see((cube, wall))
    baseline = 0.12
    is_blind = blind_strip(frame, baseline)
    is_cube = view.surface == 1
    assert 0.05 < np.mean(is_blind[is_cube]) < 0.9
    assert not is_cube[:, :11].any()
    assert verdicts(Teacher().segment(without(frame, U < 0)))[0] is Verdict.OBJECT
    found = Teacher().segment(without(frame, is_blind))
    assert (found.labels[is_cube] != Label.SALIENT).all()


def test_sides_are_where_the_readings_end() -> None:
    frame, _ = see((CUBE, NEAR_WALL))
    sides = find_outline([points_of(without(frame, outside(30, 60, 600, 450)))])
    assert [(side.axis, side.sign) for side in sides] == [(0, 1), (0, -1), (1, 1), (1, -1)]
    ends = [(30 - 319.5) / 525, -(600 - 319.5) / 525, (60 - 239.5) / 525, -(450 - 239.5) / 525]
    np.testing.assert_allclose([side.offset for side in sides], ends, atol=4 / 525)


def test_side_of_a_blind_strip_follows_the_distance() -> None:
    frame, _ = see((CUBE, replace(CUBE, centre=(-0.9, -0.6, 0.15)), NEAR_WALL))
    points = points_of(without(frame, blind_strip(frame, 0.09)))
    left = find_outline([points])[0]
    assert (left.axis, left.sign) == (0, 1)
    assert left.shift > 0
    is_cut = cut_by([left], points)
    first = np.isfinite(points.depth).argmax(axis=1)
    assert first.max() > first.min() + 5
    assert np.mean(is_cut[np.arange(len(first)), first]) > 0.95
    assert np.mean(is_cut) < 0.04


@pytest.mark.parametrize("teacher", [Teacher(), Teacher(Survey("table"))])
def test_object_before_what_the_sensor_cannot_reach_is_not_cut(teacher: Teacher) -> None:
    frame, view = see((TABLE_TOP, ON_TABLE), distance=1.3, height=1.0, tilt_deg=20)
    assert frame.depth is not None
    found = teacher.segment(without(frame, frame.depth > 1.9))
    is_thing = view.surface == 2
    assert is_thing.any()
    assert np.mean(found.labels[is_thing] == Label.SALIENT) > 0.85


def test_side_that_a_frame_looks_beyond_is_none() -> None:
    # Where the table ended before nothing, something stands now.
    frame, view = see((TABLE_TOP, ON_TABLE), distance=1.3, height=1.0, tilt_deg=20)
    assert frame.depth is not None
    rows = np.flatnonzero((view.surface == 1).any(axis=1))
    edge = Side(1, 1, float((rows[0] - CAMERA.cy) / CAMERA.fy), 0.0, 0.0)
    shown = without(frame, frame.depth > 1.9)
    found = Teacher(Survey("table", outline=(edge,))).segment(shown)
    assert np.mean(found.labels[view.surface == 2] == Label.SALIENT) > 0.85


def test_only_what_is_close_to_a_side_is_cut() -> None:
    frame, _ = see((CUBE, NEAR_WALL))
    points = points_of(without(frame, outside(30, 60, 600, 450)))
    is_cut = cut_by(find_outline([points]), points)
    rows, columns = np.nonzero(~is_cut & np.isfinite(points.depth))
    assert 30 + 3 < 3 * columns.min() < 30 + 16
    assert 600 - 16 < 3 * columns.max() < 600 - 3
    assert 60 + 3 < 3 * rows.min() < 60 + 16
    assert 450 - 16 < 3 * rows.max() < 450 - 3


def test_given_window_stands() -> None:
    frame, _ = see((CUBE, NEAR_WALL))
    camera = replace(CAMERA, depth_window=(0, 0, 640, 480))
    given = replace(without(frame, outside(14, 20, 345, 470)), camera=camera)
    assert verdicts(Teacher().segment(given)) == [Verdict.OBJECT]
