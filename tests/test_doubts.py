"""Faults of unit, bits and poses are named, and right recordings are left alone."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from curiosight.datasets import open_dataset
from curiosight.datasets.depth_bits import are_rotated
from curiosight.datasets.depth_files import rotate_right
from curiosight.datasets.doubts import Doubt, find_doubts
from curiosight.datasets.doubts.values import (
    StoredDepth,
    disparity_step,
    stored_depth,
)
from curiosight.datasets.reading import Reading
from curiosight.datasets.recording import Recording
from curiosight.frame import Pose
from curiosight.rooms import RoomSettings, RoomViews, draw_room
from recordings import FIRST_STAMP, pose_line, write_camera_file, write_depth, write_image
from room import kinect, look, render

KINECT_STEP = 0.00289
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])
TURN = np.diag([1.0, -1.0, -1.0, 1.0])
Metres = npt.NDArray[np.float32]

# Views from all around, near and far, high and low: motion in every direction.
POSES = [
    look(-30, distance=1.9),
    look(-15, distance=1.6, height=1.2, tilt_deg=32),
    look(0, distance=2.0),
    look(12, distance=1.7, height=0.8, tilt_deg=20),
    look(25, distance=2.2, height=1.1),
    look(35, distance=1.8, height=1.3, tilt_deg=35),
]


def steps(depth: Metres) -> Metres:
    """Return what a Kinect's steps of disparity make of depth."""
    return (1 / (np.round(1 / depth / KINECT_STEP) * KINECT_STEP)).astype(np.float32)


def write_room(
    folder: Path,
    *,
    pose: Callable[[Pose], Pose] | None = None,
    depth: Callable[[Metres], Metres] = lambda metres: metres,
    depth_scale: float = 0.001,
) -> Path:
    """Write the room in millimetres, read with `depth_scale`; without `pose` without poses."""
    camera = kinect()
    lines = []
    for index, T_world_camera in enumerate(POSES):
        view = render(camera, T_world_camera)
        write_image(folder / f"rgb/{index:06d}.png", view.rgb)
        write_depth(folder / f"depth/{index:06d}.png", depth(view.depth))
        if pose is not None:
            lines.append(pose_line(FIRST_STAMP + 0.1 * index, pose(T_world_camera)))
    if pose is not None:
        (folder / "poses.txt").write_text("\n".join(lines))
    write_camera_file(folder, camera, depth_scale=depth_scale)
    return folder


def as_given(pose: Pose) -> Pose:
    return pose


def in_millimetres(pose: Pose) -> Pose:
    return np.block([[pose[:3, :3], 1000 * pose[:3, 3:]], [pose[3:]]])


def doubts_of(folder: Path) -> list[tuple[str, float | None, str]]:
    doubts = find_doubts(open_dataset(folder))
    return [(doubt.code, doubt.factor, doubt.fix) for doubt in doubts]


@pytest.mark.parametrize("pose", [as_given, None])
@pytest.mark.parametrize("depth", [steps, lambda metres: metres])
def test_right_recordings_are_not_doubted(tmp_path: Path, pose: Any, depth: Any) -> None:
    assert doubts_of(write_room(tmp_path, pose=pose, depth=depth)) == []


@pytest.mark.parametrize("pose", [as_given, None], ids=["poses", "no poses"])
@pytest.mark.parametrize(
    ("depth_scale", "factor"), [(0.0002, 5), (0.005, 0.2), (0.01, 0.1), (0.0001, 10), (1e-6, 1000)]
)
def test_wrong_unit_is_named(tmp_path: Path, pose: Any, depth_scale: float, factor: float) -> None:
    write_room(tmp_path, pose=pose, depth=steps, depth_scale=depth_scale)
    [(code, found, fix)] = doubts_of(tmp_path)
    assert (code, fix) == ("unit", "--depth-scale 0.001")
    assert found == pytest.approx(factor)


@pytest.mark.parametrize(
    ("pose", "code", "fix"),
    [
        (np.linalg.inv, "poses-inverted", "--invert-poses"),
        (lambda pose: MIRROR @ pose @ MIRROR, "poses-mirrored", "--pose-axes right,up,forward"),
        (lambda pose: pose @ TURN, "poses-axes", "--pose-axes right,up,backward"),
        (in_millimetres, "poses-unit", "--fix-units"),
    ],
)
def test_wrong_poses_are_named(tmp_path: Path, pose: Any, code: str, fix: str) -> None:
    [(found, _, named)] = doubts_of(write_room(tmp_path, pose=pose))
    assert (found, named) == (code, fix)


def w_first(pose: Pose) -> Pose:
    """Return what a quaternion w, x, y, z becomes when it is read as x, y, z, w."""
    other = pose.copy()
    quaternion = Rotation.from_matrix(pose[:3, :3]).as_quat()
    other[:3, :3] = Rotation.from_quat(np.roll(quaternion, 1)).as_matrix()
    return other


def test_quaternions_of_another_order_are_named_and_a_header_mends_them(tmp_path: Path) -> None:
    [(code, _, header)] = doubts_of(write_room(tmp_path, pose=w_first))
    assert code == "poses-quaternion"
    path = tmp_path / "poses.txt"
    path.write_text(header.strip('"') + "\n" + path.read_text())
    assert doubts_of(tmp_path) == []
    assert open_dataset(tmp_path).poses[0] == pytest.approx(POSES[0], abs=1e-5)


def test_principal_point_at_the_edge_is_doubted(tmp_path: Path) -> None:
    write_room(tmp_path)
    write_camera_file(tmp_path, replace(kinect(), cx=0.0, cy=0.0))
    assert [code for code, _, _ in doubts_of(tmp_path)] == ["camera"]


def test_axes_of_a_body_are_named(tmp_path: Path) -> None:
    """A robot's camera whose axes are forward, left, up."""
    body = np.eye(4)
    body[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    [(code, _, fix)] = doubts_of(write_room(tmp_path, pose=lambda pose: pose @ body.T))
    assert (code, fix) == ("poses-axes", "--pose-axes forward,left,up")


def test_turning_on_the_spot_tells_nothing_of_units(tmp_path: Path) -> None:
    """Depth without steps, poses that only turn: any unit of positions explains them."""
    camera = kinect()
    lines = []
    for index, heading in enumerate((-20, -12, -4, 4, 12)):
        pose = look(heading)
        pose[:3, 3] = look(0)[:3, 3]
        view = render(camera, pose)
        write_image(tmp_path / f"rgb/{index}.png", view.rgb)
        write_depth(tmp_path / f"depth/{index}.png", view.depth)
        lines.append(pose_line(index, in_millimetres(pose)))
    (tmp_path / "poses.txt").write_text("\n".join(lines))
    write_camera_file(tmp_path, camera)
    lines_at_origin = [" ".join([line.split()[0], "0 0 0", *line.split()[4:]]) for line in lines]
    (tmp_path / "poses.txt").write_text("\n".join(lines_at_origin))
    assert doubts_of(tmp_path) == []


def write_table(folder: Path, height: float, unit: float, depth_scale: float) -> Path:
    """Write four looks straight down on a table with boxes of 5 and 10 cm, noise of 1 mm."""
    rng = np.random.default_rng(0)
    for index in range(4):
        depth = np.full((120, 160), height)
        depth[20:60, 30 + 5 * index : 70 + 5 * index] -= 0.05
        depth[70:100, 90:130] -= 0.1
        depth += rng.normal(0, 0.001, depth.shape)
        write_image(folder / f"rgb/{index}.png", np.full((120, 160, 3), 90, np.uint8))
        write_depth(folder / f"depth/{index}.png", depth.astype(np.float32), unit)
    write_camera_file(folder, kinect(), depth_scale=depth_scale)
    return folder


@pytest.mark.parametrize("unit", [0.001, 0.0002, 0.0001])
@pytest.mark.parametrize("height", [0.3, 0.8, 3.0])
def test_camera_over_a_table_is_not_doubted(tmp_path: Path, height: float, unit: float) -> None:
    assert doubts_of(write_table(tmp_path, height, unit, unit)) == []


@pytest.mark.parametrize(
    ("depth_scale", "factor"), [(0.0002, 5), (0.0001, 10), (0.005, 0.2), (0.01, 0.1)]
)
def test_unit_of_a_camera_over_a_table(tmp_path: Path, depth_scale: float, factor: float) -> None:
    [(code, found, _)] = doubts_of(write_table(tmp_path, 0.8, 0.001, depth_scale))
    assert (code, found) == ("unit", factor)


@pytest.mark.parametrize("unit", [0.001, 0.0001])
def test_rotated_bits_are_named(tmp_path: Path, unit: float) -> None:
    """In millimetres all is nearer than 8192 units; in tenths much is not, and wraps around."""
    write_room(tmp_path)
    for path in (tmp_path / "depth").glob("*.png"):
        stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.int64)
        stored = np.rint(stored * (0.001 / unit)).clip(max=65535).astype(np.int64)
        write_image(path, ((stored << 3 | stored >> 13) & 0xFFFF).astype(np.uint16))
    write_camera_file(tmp_path, kinect(), depth_scale=unit)
    assert [code for code, _, _ in doubts_of(tmp_path)] == ["bits"]


def test_eighths_of_a_millimetre_are_no_rotated_bits(tmp_path: Path) -> None:
    write_room(tmp_path, depth=lambda metres: np.round(metres, 3) * 8, depth_scale=0.001 / 8)
    assert doubts_of(tmp_path) == []


def test_turning_bits_back_is_the_inverse() -> None:
    stored = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    np.testing.assert_array_equal(rotate_right(stored << 3 | stored >> 13, 3), stored)


def test_step_of_disparity_is_measured_in_the_unit_of_the_file() -> None:
    depths = [steps(render(kinect(), pose).depth) for pose in POSES]
    stored = stored_depth([np.round(depth, 3) for depth in depths], None)
    assert stored is not None
    assert (stored.scale, stored.quantum) == (0.001, 0.001)
    step = disparity_step(stored)
    assert step == pytest.approx(KINECT_STEP, rel=0.03)
    as_fifths = disparity_step(StoredDepth(stored.images, 0.0002))
    assert as_fifths == pytest.approx(5 * KINECT_STEP, rel=0.03)
    assert not are_rotated(stored.images)


def test_floats_of_sixteen_bits_are_no_disparity() -> None:
    view = render(kinect(640, 480), look(distance=5.0)).depth
    rounded = view.astype(np.float16).astype(np.float32)
    stored = stored_depth([np.round(rounded, 3)], 0.001)
    assert stored is not None
    assert disparity_step(stored) is None


def test_depth_without_a_unit_has_no_stored_numbers() -> None:
    depth = np.random.default_rng(0).uniform(1, 2, (50, 50)).astype(np.float32)
    assert stored_depth([depth], 0.001) is None


def test_a_close_look_at_the_floor_of_a_drawn_room(tmp_path: Path) -> None:
    """Floor meets floor in any unit of the way: only what stands on it tells."""
    views = RoomViews(draw_room(RoomSettings(seed=7, height=0.4, tilt=30, views=6)))
    lines = []
    for index, pose in enumerate(views.poses):
        frame = views[index]
        assert frame.depth is not None
        write_image(tmp_path / f"rgb/{index}.png", frame.rgb)
        write_depth(tmp_path / f"depth/{index}.png", frame.depth)
        lines.append(pose_line(index, pose))
    (tmp_path / "poses.txt").write_text("\n".join(lines))
    write_camera_file(tmp_path, views.camera)
    assert doubts_of(tmp_path) == []
    write_camera_file(tmp_path, views.camera, depth_scale=0.005)
    assert doubts_of(tmp_path) == [("unit", 0.2, "--depth-scale 0.001")]


def test_recordings_without_depth_are_not_doubted(tmp_path: Path) -> None:
    write_image(tmp_path / "a.png", np.zeros((20, 30, 3), np.uint8))
    assert find_doubts(open_dataset(tmp_path)) == []


def test_frames_without_readings_are_not_doubted(tmp_path: Path) -> None:
    write_room(tmp_path, pose=as_given, depth=np.zeros_like)
    assert find_doubts(open_dataset(tmp_path)) == []


def test_number_of_frames_is_checked(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="n_frames: expected at least 1, got 0"):
        find_doubts(open_dataset(write_room(tmp_path)), n_frames=0)


@pytest.mark.parametrize(
    "folder", ["redkitchen", "rgbd_dataset_freiburg1_rpy", "osd_learn", "floor_boxes"]
)
def test_real_recordings(folder: str) -> None:
    root = os.environ.get("CURIOSIGHT_TEST_DATA")
    if not root:
        pytest.skip("CURIOSIGHT_TEST_DATA is not set")
    dataset = open_dataset(Path(root) / "data" / folder)
    assert isinstance(dataset, Recording)
    assert find_doubts(dataset) == []
    fivefold = dataset.read_as(Reading(depth_scale=5 * dataset.depth_scale))
    [doubt] = find_doubts(fivefold)
    assert isinstance(doubt, Doubt)
    assert (doubt.code, doubt.factor) == ("unit", 0.2)
