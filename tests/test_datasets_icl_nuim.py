"""ICL-NUIM, whose y axis points up, gives the poses that its depth agrees with."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from curiosight.datasets import Recording, Video, check_dataset, open_dataset
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.layouts.icl_nuim import CAMERA
from curiosight.errors import DataError
from curiosight.frame import Pose
from recordings import pose_line, write_camera_file, write_depth, write_folder, write_image
from room import kinect, poses_around, render

SIZE = (160, 120)
UPWARD = np.diag([1.0, -1.0, 1.0, 1.0])
# From the room's world with z up to one with y down, right-handed both.
T_READ_ROOM = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


def published(pose: Pose) -> Pose:
    """Return what ICL-NUIM writes for a camera: x_world = T x_camera.

    POV-Ray's axes are left-handed: x right, y up, z forward, of the camera and of the world.
    """
    T_published_room = UPWARD @ T_READ_ROOM
    return T_published_room @ pose @ UPWARD


def write_icl(root: Path, n_frames: int = 4, *, first_pose: int = 1) -> None:
    camera = scaled_camera(CAMERA, SIZE)
    lines = []
    for index, pose in enumerate(poses_around(n_frames)):
        view = render(camera, pose)
        write_image(root / f"rgb/{index}.png", view.rgb)
        write_depth(root / f"depth/{index}.png", view.depth, 1 / 5000)
        if index >= first_pose:
            lines.append(f"{index} {pose_line(0, published(pose)).partition(' ')[2]}")
    (root / "livingRoom1.gt.freiburg").write_text("\n".join(lines) + "\n")
    pairs = [f"{index} depth/{index}.png {index} rgb/{index}.png" for index in range(n_frames)]
    (root / "associations.txt").write_text("\n".join(pairs))


def points_in_world(dataset: Recording | Video, index: int) -> np.ndarray:
    frame = dataset[index]
    camera, depth, pose = frame.camera, frame.depth, frame.T_world_camera
    assert camera is not None
    assert depth is not None
    assert pose is not None
    v, u = np.nonzero(np.isfinite(depth))
    z = depth[v, u].astype(np.float64)
    points = np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z])
    return pose[:3, :3] @ points + pose[:3, 3:]


def assert_room(dataset: Recording | Video, first: int) -> None:
    """Check that all frames see one floor, at one height, and poses are the room's own."""
    for index, pose in enumerate(poses_around(len(dataset))):
        if index >= first:
            np.testing.assert_allclose(dataset.poses[index], T_READ_ROOM @ pose, atol=1e-6)
            down = points_in_world(dataset, index)
            # The floor is z = 0 of the room, y = 0 there, and nothing is below it.
            assert np.percentile(np.abs(down[1]), 30) < 0.02


def test_poses_agree_with_depth(tmp_path: Path) -> None:
    write_icl(tmp_path)
    dataset = open_dataset(tmp_path)
    check_dataset(dataset)
    assert dataset.name == "ICL-NUIM"
    assert list(dataset.ids) == ["0", "1", "2", "3"]
    assert dataset.poses[0] is None
    assert dataset.camera is not None
    assert dataset.camera.fx == pytest.approx(481.2 / 4)
    assert dataset.camera.fy == pytest.approx(480.0 / 4)
    assert_room(dataset, 1)
    expected = render(scaled_camera(CAMERA, SIZE), poses_around(4)[2]).depth
    np.testing.assert_allclose(dataset[2].depth, expected, atol=0.0002)


def test_as_many_poses_as_images_are_matched_by_number_nevertheless(tmp_path: Path) -> None:
    write_icl(tmp_path)
    (tmp_path / "rgb/0.png").unlink()
    dataset = open_dataset(tmp_path)
    assert list(dataset.ids) == ["1", "2", "3"]
    right = T_READ_ROOM @ poses_around(4)[1]
    np.testing.assert_allclose(dataset.poses[0], right, atol=1e-6)


def test_plain_folder_with_negative_fy(tmp_path: Path) -> None:
    write_folder(tmp_path, 4)
    camera = kinect(*SIZE)
    write_camera_file(tmp_path, camera, fy=-camera.fy)
    lines = [pose_line(i, published(pose)) for i, pose in enumerate(poses_around(4))]
    (tmp_path / "poses.txt").write_text("\n".join(lines))
    dataset = open_dataset(tmp_path)
    check_dataset(dataset)
    assert dataset.camera is not None
    assert dataset.camera.fy == camera.fy
    assert any("fy is negative" in remark for remark in dataset.remarks)
    assert_room(dataset, 0)


@pytest.mark.parametrize("fy", [0, "a", -1e309, True])
def test_fy_that_is_none_is_refused(tmp_path: Path, fy: object) -> None:
    write_folder(tmp_path, 1)
    write_camera_file(tmp_path, kinect(*SIZE))
    content = json.loads((tmp_path / "camera.json").read_text())
    (tmp_path / "camera.json").write_text(json.dumps({**content, "fy": fy}))
    with pytest.raises(DataError, match="fy is"):
        open_dataset(tmp_path)


def test_data_set_is_told_by_its_folder_where_poses_are_missing(tmp_path: Path) -> None:
    folder = tmp_path / "living_room_traj2_frei_png"
    write_icl(folder)
    (folder / "livingRoom1.gt.freiburg").rename(tmp_path / "livingRoom1.gt.freiburg")
    dataset = open_dataset(folder)
    assert dataset.name == "ICL-NUIM"
    assert set(dataset.poses) == {None}
    (tmp_path / "livingRoom1.gt.freiburg").rename(tmp_path / "livingRoom2.gt.freiburg")
    assert_room(open_dataset(folder), 1)


def test_pov_ray_files_are_refused_with_a_way_out(tmp_path: Path) -> None:
    write_image(tmp_path / "scene_00_0000.png", np.zeros((4, 4, 3), np.uint8))
    (tmp_path / "scene_00_0000.depth").write_text("100.0 101.0")
    with pytest.raises(DataError, match=r"along the ray.*TUM form"):
        open_dataset(tmp_path)
