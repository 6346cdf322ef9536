"""Cameras and frames refuse what cannot be one, and rigid poses are told from others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from curiosight.frame import Camera, Frame, is_rigid

INTRINSICS: dict[str, Any] = {
    "width": 64,
    "height": 48,
    "fx": 50.0,
    "fy": 50.0,
    "cx": 31.5,
    "cy": 23.5,
}


@pytest.mark.parametrize("window", [None, (0, 0, 64, 48), (63, 47, 64, 48)])
def test_windows_inside_the_image(window: Any) -> None:
    assert Camera(**INTRINSICS, depth_window=window).depth_window == window


@pytest.mark.parametrize(
    "window", [(-1, 0, 64, 48), (0, 0, 65, 48), (0, 0, 64, 49), (9, 0, 9, 48), (0, 30, 64, 20)]
)
def test_windows_empty_or_outside_are_refused(window: Any) -> None:
    with pytest.raises(ValueError, match=r"depth_window: expected .* inside the 64x48 image, got"):
        Camera(**INTRINSICS, depth_window=window)


@pytest.mark.parametrize("name", ["width", "height", "fx", "fy"])
@pytest.mark.parametrize("value", [0, -1, np.nan, np.inf])
def test_sizes_and_focal_lengths_are_positive_numbers(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name}: expected a positive number, got {value}"):
        Camera(**INTRINSICS | {name: value})


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (np.eye(3), r"T_world_camera: expected \(4, 4\), got \(3, 3\)"),
        (np.zeros(16), r"T_world_camera: expected \(4, 4\), got \(16,\)"),
        (np.diag([1, 1, np.nan, 1]), "T_world_camera: expected finite numbers"),
        (np.diag([1, 1, np.inf, 1]), "T_world_camera: expected finite numbers"),
    ],
)
def test_poses_that_are_none_are_refused(pose: Any, words: str) -> None:
    rgb = np.zeros((48, 64, 3), np.uint8)
    with pytest.raises(ValueError, match=words):
        Frame("a", rgb, T_world_camera=pose)
    depth = np.ones((48, 64), np.float32)
    with pytest.raises(ValueError, match=words):
        Frame("a", rgb, depth, Camera(**INTRINSICS), pose)


@given(st.lists(st.floats(-4, 4), min_size=6, max_size=6), st.floats(-0.004, 0.004))
def test_rotation_and_translation_are_rigid_up_to_rounding(six: list[float], noise: float) -> None:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(six[:3]).as_matrix() * (1 + noise)
    pose[:3, 3] = six[3:]
    assert is_rigid(pose)


@pytest.mark.parametrize(
    "pose",
    [
        np.eye(3),
        np.diag([1.02, 1, 1, 1]),
        np.diag([-1.0, 1, 1, 1]),
        np.diag([1.0, 1, 1, 2]),
        np.diag([1.0, 1, 1, np.nan]),
        np.zeros((4, 4)),
    ],
    ids=["small", "stretched", "mirrored", "projective", "NaN", "zero"],
)
def test_other_matrices_are_not_rigid(pose: Any) -> None:
    assert not is_rigid(pose)
