"""Which way is up is carried from frame to frame while the view stays about the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Frame
from curiosight.teacher import Segmentation, Teacher, TemporalTeacher
from curiosight.teacher.cloud.planes import Plane
from curiosight.teacher.cloud.tracking import UpTracker
from scenes import ON_TABLE, TABLE_TOP, see

UP = np.array([0.0, -0.9, -0.436])
TILT = 25
TRUE_UP = np.array([0.0, -np.cos(np.radians(TILT)), -np.sin(np.radians(TILT))])
SHAPE = (64, 96)


def level(value: float = 2.0) -> np.ndarray:
    return np.full(SHAPE, value, np.float32)


def floor(n_inliers: int = 900, up: np.ndarray = UP) -> Plane:
    inliers = np.zeros((32, 48), np.bool_)
    inliers.ravel()[:n_inliers] = True
    return Plane(up, 1.0, inliers)


def test_up_is_that_of_the_largest_support() -> None:
    tracker = UpTracker()
    assert tracker.up_in(level()) is None
    other = np.array([0.0, -1.0, 0.0])
    tracker.update(level(), (floor(200, other), floor(900)))
    assert tracker.up_in(level(2.1)) is UP


def test_another_view_ends_it() -> None:
    tracker = UpTracker()
    tracker.update(level(), (floor(),))
    assert tracker.up_in(level(2.5)) is None
    assert tracker.up_in(np.full((32, 48), 2.0, np.float32)) is None
    assert tracker.up_in(np.full(SHAPE, np.nan, np.float32)) is None


@pytest.mark.parametrize("n_lost", [3, 4])
def test_too_many_frames_without_a_support_end_it(n_lost: int) -> None:
    tracker = UpTracker(max_lost=3)
    tracker.update(level(), (floor(),))
    for _ in range(n_lost):
        tracker.update(level(), ())
    assert (tracker.up_in(level()) is None) == (n_lost == 4)


def test_ramp_is_no_floor_where_the_frame_before_knew_better() -> None:
    before, view = see((TABLE_TOP, ON_TABLE), tilt_deg=TILT)
    is_left = np.arange(view.depth.shape[1]) < 300
    ramp = _with_ramp(before, (view.surface == 0) & is_left)
    assert _lean(Teacher().segment(ramp)) > 20
    teacher = TemporalTeacher(Teacher())
    assert _lean(teacher.segment(before)) < 2
    assert _lean(teacher.segment(ramp)) < 2


def _lean(segmentation: Segmentation) -> float:
    """Return by how many degrees the largest support leans."""
    supports = segmentation.supports
    largest = max(supports, key=lambda support: np.count_nonzero(support.plane.inliers))
    return float(np.degrees(np.arccos(min(1.0, largest.plane.normal @ TRUE_UP))))


def _with_ramp(frame: Frame, is_ramp: npt.NDArray[np.bool_], *, lean_deg: float = 30) -> Frame:
    """Return a frame with a plane where `is_ramp`, that falls away from the camera."""
    assert frame.depth is not None
    assert frame.camera is not None
    steeper = np.radians(TILT - lean_deg)
    rays = (np.arange(frame.camera.height) - frame.camera.cy) / frame.camera.fy
    # 1.1 m below the camera, measured along the plane's own normal.
    towards = rays * np.cos(steeper) + np.sin(steeper)
    z = np.where(towards > 0.05, 1.1 / np.maximum(towards, 0.05), np.nan)
    depth = np.where(is_ramp, z[:, None], frame.depth).astype(np.float32)
    return replace(frame, depth=depth)
