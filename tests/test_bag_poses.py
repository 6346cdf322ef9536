"""Poses of bags: tf, odometry and poses of something, at the stamps of the colour images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bags import (
    OPTICAL,
    START_NS,
    STEP_NS,
    Line,
    Messages,
    look_alike,
    write_bag,
    write_plain_mcap,
)
from curiosight.datasets import Reading, RosBag, open_dataset
from curiosight.frame import Pose

BODY_TO_OPTICAL = Rotation.from_matrix([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])


def pose_of(x: float, y: float = 0.0, z: float = 0.0, *, yaw_deg: float = 0.0) -> Pose:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", yaw_deg, degrees=True).as_matrix()
    pose[:3, 3] = x, y, z
    return pose


T_BASE_CAMERA = pose_of(0.1, 0.0, 1.0)
T_BASE_CAMERA[:3, :3] = BODY_TO_OPTICAL.as_matrix()


def opened(path: Path, topics: str = "") -> RosBag:
    dataset = open_dataset(path, reading=Reading(topics=topics))
    assert isinstance(dataset, RosBag)
    return dataset


def drive(make: Messages, *, with_map: bool = True) -> list[Line]:
    """Return tf of a drive along x at 1 m/s that turns by 90 deg/s, told between the images."""
    lines: list[Line] = []
    static = make.tf(("base_link", OPTICAL, T_BASE_CAMERA, 0))
    lines.append(("/tf_static", START_NS, static))
    for step in range(-1, 3):
        stamp = START_NS + step * STEP_NS + STEP_NS // 2
        seconds = (stamp - START_NS) / 1e9
        moved = make.tf(("odom", "base_link", pose_of(seconds, yaw_deg=90 * seconds), stamp))
        lines.append(("/tf", stamp, moved))
    if with_map:
        for second in (-3, 3):  # as seldom as a localisation may tell it
            stamp = START_NS + second * 10**9
            lines.append(("/tf", stamp, make.tf(("map", "odom", pose_of(0, 5), stamp))))
    return lines


def expected(number: int, *, y: float = 0.0) -> Pose:
    seconds = number * STEP_NS / 1e9
    return pose_of(seconds, y, yaw_deg=90 * seconds) @ T_BASE_CAMERA


@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
def test_tf_is_interpolated_along_its_chain(encoding: str, tmp_path: Path) -> None:
    make = Messages(encoding)
    kind = "ros1" if encoding == "ros1" else "mcap"
    lines = [*look_alike(make), *drive(make)]
    dataset = opened(write_bag(tmp_path / "a.bag", lines, kind))
    for number in range(2):
        np.testing.assert_allclose(dataset.poses[number], expected(number, y=5), atol=1e-9)
        np.testing.assert_array_equal(dataset[number].T_world_camera, dataset.poses[number])
    assert any(f"pose /tf, /tf_static (map → {OPTICAL})" in remark for remark in dataset.remarks)


def test_no_pose_is_made_up_beyond_tf_or_in_its_gaps(tmp_path: Path) -> None:
    make = Messages()
    lines = [*look_alike(make, 6), *drive(make, with_map=False)]
    late = START_NS + 10 * STEP_NS
    lines.append(("/tf", late, make.tf(("odom", "base_link", pose_of(1), late))))
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert [pose is not None for pose in dataset.poses] == [True] * 3 + [False] * 3


def test_frames_may_begin_with_a_slash(tmp_path: Path) -> None:
    make = Messages("ros1")
    lines = look_alike(make, 1)
    for _, _, message in lines:
        message.header.frame_id = f"/{OPTICAL}"
    link = make.tf(("/world", f"/{OPTICAL}", pose_of(1, 2, 3), START_NS))
    dataset = opened(write_bag(tmp_path / "a.bag", [*lines, ("/tf", START_NS, link)], "ros1"))
    np.testing.assert_allclose(dataset.poses[0], pose_of(1, 2, 3))


def test_static_links_within_a_camera_are_no_poses(tmp_path: Path) -> None:
    make = Messages()
    link = make.tf(("camera_link", OPTICAL, T_BASE_CAMERA, 0))
    lines = [*look_alike(make), ("/tf_static", START_NS, link)]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert dataset.poses == (None, None)
    assert f"tf does not say where {OPTICAL} is: no poses" in dataset.remarks


def test_a_camera_that_is_bolted_to_the_map_has_its_pose(tmp_path: Path) -> None:
    make = Messages()
    link = make.tf(("map", OPTICAL, T_BASE_CAMERA, 0))
    lines = [*look_alike(make), ("/tf_static", START_NS, link)]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    np.testing.assert_allclose(dataset.poses[1], T_BASE_CAMERA)


def odometry(make: Messages, child: str) -> list[Line]:
    stamps = [START_NS + step * STEP_NS + STEP_NS // 2 for step in range(-1, 2)]
    seconds = [(stamp - START_NS) / 1e9 for stamp in stamps]
    poses = [pose_of(second, yaw_deg=90 * second) for second in seconds]
    return [
        ("/odom", stamp, make.odometry("odom", child, pose, stamp))
        for stamp, pose in zip(stamps, poses, strict=True)
    ]


@pytest.mark.parametrize("topics", ["", "pose=/odom"])
def test_odometry_of_the_base_with_tf_to_the_camera(topics: str, tmp_path: Path) -> None:
    make = Messages()
    link = make.tf(("base_link", OPTICAL, T_BASE_CAMERA, 0))
    lines = [*look_alike(make), *odometry(make, "base_link"), ("/tf_static", START_NS, link)]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines), topics)
    for number in range(2):
        np.testing.assert_allclose(dataset.poses[number], expected(number), atol=1e-9)


def test_odometry_that_is_named_goes_before_tf(tmp_path: Path) -> None:
    make = Messages()
    lines = [*look_alike(make), *drive(make), *odometry(make, "base_link")]
    path = write_plain_mcap(tmp_path / "a.mcap", lines)
    np.testing.assert_allclose(opened(path).poses[1], expected(1, y=5), atol=1e-9)
    np.testing.assert_allclose(opened(path, "pose=/odom").poses[1], expected(1), atol=1e-9)


def test_odometry_without_tf_is_of_a_camera_that_looks_ahead(tmp_path: Path) -> None:
    make = Messages()
    lines = [*look_alike(make), *odometry(make, "base_link")]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    ahead = np.eye(4)
    ahead[:3, :3] = BODY_TO_OPTICAL.as_matrix()
    np.testing.assert_allclose(dataset.poses[0], ahead, atol=1e-9)
    assert any("no tf from base_link to the camera" in remark for remark in dataset.remarks)


def test_poses_of_something_are_taken_for_the_cameras(tmp_path: Path) -> None:
    make = Messages()
    told = [
        ("/slam/pose", stamp, make.pose_stamped("world", pose_of(x, 1, 2), stamp))
        for x, stamp in ((-1.0, START_NS - STEP_NS), (1.0, START_NS + STEP_NS))
    ]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", [*look_alike(make), *told]))
    np.testing.assert_allclose(dataset.poses[0], pose_of(0, 1, 2))
    np.testing.assert_allclose(dataset.poses[1], pose_of(1, 1, 2))
    assert any("taken for those of the colour camera" in remark for remark in dataset.remarks)
