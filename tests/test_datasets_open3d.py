"""Recordings of Open3D are read back as they were written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from curiosight.datasets import check_dataset, open_dataset
from recordings import write_camera_file, write_depth, write_image
from room import View, kinect, poses_around, render

SIZE = (160, 120)


def write_log(path: Path, poses: list[np.ndarray]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    for index, pose in enumerate(poses):
        lines += [f"{index} {index} {index + 1}", *(" ".join(map(str, row)) for row in pose)]
    path.write_text("\n".join(lines))


def write_open3d(
    root: Path,
    *,
    colour: str = "color",
    log: str = "trajectory.log",
    depth_name: str = "{:05d}.png",
    camera: Path | None = None,
) -> list[View]:
    """Write three views; the camera in columns, as Open3D has it."""
    intrinsics = kinect(*SIZE)
    poses = poses_around(3)
    views = [render(intrinsics, pose) for pose in poses]
    for index, view in enumerate(views):
        write_image(root / colour / f"{index:05d}.png", view.rgb)
        write_depth(root / "depth" / depth_name.format(index), view.depth)
    if log:
        write_log(root / log, poses)
    columns = [intrinsics.fx, 0, 0, 0, intrinsics.fy, 0, intrinsics.cx, intrinsics.cy, 1]
    content = {"width": SIZE[0], "height": SIZE[1], "intrinsic_matrix": columns}
    (camera or root / "camera_intrinsic.json").write_text(json.dumps(content))
    return views


def assert_read(path: Path, views: list[View], *, has_poses: bool = True) -> None:
    dataset = open_dataset(path)
    check_dataset(dataset)
    assert dataset.name == "Open3D"
    assert list(dataset.ids) == ["00000", "00001", "00002"]
    assert dataset.camera is not None
    intrinsics = kinect(*SIZE)
    assert (dataset.camera.fy, dataset.camera.cy) == (intrinsics.fy, intrinsics.cy)
    for index, (view, pose) in enumerate(zip(views, poses_around(3), strict=True)):
        frame = dataset[index]
        np.testing.assert_allclose(frame.depth, view.depth, atol=0.0006)
        assert frame.problem is None
        if has_poses:
            np.testing.assert_allclose(frame.T_world_camera, pose, atol=1e-9)
        else:
            assert frame.T_world_camera is None


@pytest.mark.parametrize("colour", ["color", "rgb", "image"])
@pytest.mark.parametrize("log", ["trajectory.log", "scene/trajectory.log", ""])
def test_folders_of_the_reconstruction_system(tmp_path: Path, colour: str, log: str) -> None:
    views = write_open3d(tmp_path, colour=colour, log=log)
    assert_read(tmp_path, views, has_poses=bool(log))


def test_camera_one_folder_up_and_that_folder_itself(tmp_path: Path) -> None:
    views = write_open3d(tmp_path / "RGBD", camera=tmp_path / "camera_primesense.json")
    (tmp_path / "RGBD/odometry.log").write_text((tmp_path / "RGBD/trajectory.log").read_text())
    write_log(tmp_path / "RGBD/odometry.log", [np.eye(4)] * 3)
    (tmp_path / "RGBD/rgbd.match").write_text("depth/00000.png color/00000.png\n")
    assert_read(tmp_path, views)
    assert_read(tmp_path / "RGBD", views)


def test_two_folders_have_two_worlds(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_open3d(tmp_path / name)
    dataset = open_dataset(tmp_path)
    assert list(dataset.ids)[::3] == ["a/00000", "b/00000"]
    assert set(dataset.poses) == {None}
    assert any("open a single one to have poses" in remark for remark in dataset.remarks)


def test_depth_of_other_names_is_paired_by_number(tmp_path: Path) -> None:
    assert_read(tmp_path, write_open3d(tmp_path, depth_name="d{:d}-1700.png"))


def test_plain_folder_with_a_camera_of_its_own_stays_one(tmp_path: Path) -> None:
    write_open3d(tmp_path, colour="rgb")
    write_camera_file(tmp_path, kinect(*SIZE))
    dataset = open_dataset(tmp_path)
    assert dataset.name == "plain folder"
    assert all(pose is not None for pose in dataset.poses)


def test_lost_poses_are_none(tmp_path: Path) -> None:
    write_open3d(tmp_path)
    write_log(tmp_path / "trajectory.log", [np.eye(4), np.full((4, 4), np.nan), np.eye(4)])
    dataset = open_dataset(tmp_path)
    assert [pose is None for pose in dataset.poses] == [False, True, False]
    assert any("1 of them are lost" in remark for remark in dataset.remarks)
