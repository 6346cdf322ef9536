"""RGB-D Scenes v1 and v2, written small in the layout of the University of Washington."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from curiosight.datasets import ObjectBox, RgbdScenes, RgbdScenesV2, check_dataset, open_dataset
from curiosight.datasets.cameras import calibration
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.layouts import rgbd_scenes_v2
from curiosight.errors import DataError
from curiosight.frame import Pose
from recordings import SIZE, truncate, write_camera_file, write_depth, write_image
from room import View, kinect, poses_around, render

FIELDS = ("category", "instance", "top", "bottom", "left", "right")
BOWL = ("bowl", 2, 11, 40, 21, 60)
CAP = ("cap", 1, 1, 1, 1, 160)


def write_v1(root: Path, place: str = "desk_1", n_frames: int = 3) -> list[View]:
    """Write a sequence such as desk/desk_1, whose frames count from 1; no boxes."""
    camera = scaled_camera(calibration.KINECT, SIZE)
    folder = root / place.rpartition("_")[0] / place
    views = [render(camera, pose) for pose in poses_around(n_frames)]
    for number, view in enumerate(views, start=1):
        write_image(folder / f"{place}_{number}.png", view.rgb)
        write_depth(folder / f"{place}_{number}_depth.png", view.depth)
    return views


def write_boxes(path: Path, *frames: tuple[Any, ...]) -> None:
    """Write a cell of MATLAB structures a frame, empty where there are no boxes."""
    cells = np.empty((1, len(frames)), object)
    for place, boxes in enumerate(frames):
        structures = np.empty((1, len(boxes)), [(field, object) for field in FIELDS])
        for number, box in enumerate(boxes):
            structures[0, number] = box
        cells[0, place] = structures if boxes else np.empty((0, 0))
    savemat(path, {"bboxes": cells})


def write_v2(root: Path, scene: str = "01", n_frames: int = 3, *, with_poses: bool = True) -> None:
    """Write imgs/scene_NN in tenths of a millimetre and pc/NN.pose."""
    camera = scaled_camera(rgbd_scenes_v2.CAMERA, SIZE)
    lines = []
    for number, pose in enumerate(poses_around(n_frames)):
        view = render(camera, pose)
        stem = root / f"imgs/scene_{scene}/{number:05d}"
        write_image(stem.with_name(f"{stem.name}-color.png"), view.rgb)
        near = np.where(view.depth < 6.5, view.depth, np.nan).astype(np.float32)
        write_depth(stem.with_name(f"{stem.name}-depth.png"), near, 0.0001)
        lines.append(pose_line(pose))
    if with_poses:
        (root / "pc").mkdir(exist_ok=True)
        (root / f"pc/{scene}.pose").write_text("\n".join(lines))


def pose_line(pose: Pose) -> str:
    qx, qy, qz, qw = Rotation.from_matrix(pose[:3, :3]).as_quat()
    return " ".join(f"{number:.9f}" for number in (qw, qx, qy, qz, *pose[:3, 3]))


def v1(path: Path) -> RgbdScenes:
    dataset = open_dataset(path)
    assert isinstance(dataset, RgbdScenes)
    return dataset


@pytest.mark.parametrize("opened", [".", "desk", "desk/desk_1"])
def test_v1_is_guessed_at_each_level(opened: str, tmp_path: Path) -> None:
    views = write_v1(tmp_path, n_frames=11)
    dataset = v1(tmp_path / opened)
    assert dataset.name == "RGB-D Scenes v1"
    assert dataset.ids == tuple(f"desk_1_{number}" for number in range(1, 12))
    frame = dataset[9]
    assert frame.problem is None
    np.testing.assert_array_equal(frame.rgb, views[9].rgb)
    np.testing.assert_allclose(frame.depth, views[9].depth, atol=0.0006)
    assert dataset.poses == (None,) * 11
    assert dataset.camera is not None
    assert dataset.camera.fx == 525 / 4
    assert any("Kinect are assumed" in remark for remark in dataset.remarks)
    check_dataset(dataset)


def test_v1_sequences_prefix_their_ids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_v1(tmp_path, "table_small_2", 2)
    write_v1(tmp_path, "desk_1", 1)
    ids = ("desk/desk_1/desk_1_1", "table_small/table_small_2/table_small_2_1")
    assert v1(tmp_path).ids[:2] == ids
    monkeypatch.chdir(tmp_path / "desk/desk_1")
    assert v1(Path(".")).ids == ("desk_1_1",)


def test_v1_boxes_are_known_and_are_no_ground_truth(tmp_path: Path) -> None:
    write_v1(tmp_path)
    write_boxes(tmp_path / "desk/desk_1.mat", (BOWL,), (), (BOWL, CAP))
    dataset = v1(tmp_path / "desk/desk_1")
    bowl = ObjectBox("bowl", 2, (20, 10, 40, 30))
    cap = ObjectBox("cap", 1, (0, 0, 160, 1))
    assert [dataset.boxes(index) for index in range(3)] == [(bowl,), (), (bowl, cap)]
    assert not any(map(dataset.has_ground_truth, range(3)))
    assert any("boxes around objects are no masks" in remark for remark in dataset.remarks)
    check_dataset(dataset)


def test_v1_boxes_belong_to_the_frame_of_their_number(tmp_path: Path) -> None:
    write_v1(tmp_path)
    write_boxes(tmp_path / "desk/desk_1.mat", (), (CAP,))
    (tmp_path / "desk/desk_1/desk_1_1.png").unlink()
    dataset = v1(tmp_path)
    assert [bool(dataset.boxes(0)), dataset.boxes(1)] == [True, None]


def test_v1_without_boxes(tmp_path: Path) -> None:
    views = write_v1(tmp_path)
    assert v1(tmp_path).boxes(0) is None
    write_boxes(tmp_path / "desk/desk_1.mat", (BOWL,))
    write_image(tmp_path / "desk/desk_1/ground_truth/desk_1_2.png", views[1].ground_truth)
    dataset = v1(tmp_path)
    np.testing.assert_array_equal(dataset.ground_truth(1), views[1].ground_truth)
    assert not any("boxes" in remark for remark in dataset.remarks)


def test_v1_damaged_boxes_are_an_error_of_their_file(tmp_path: Path) -> None:
    write_v1(tmp_path)
    path = tmp_path / "desk/desk_1.mat"
    savemat(path, {"boxes": np.eye(3)})
    with pytest.raises(DataError, match=r"desk_1\.mat: cannot be read as boxes.*unpack"):
        v1(tmp_path).boxes(0)
    write_boxes(path, (BOWL,), (CAP,))
    truncate(path)
    dataset = v1(tmp_path)
    with pytest.raises(DataError, match=r"desk_1\.mat: cannot be read as boxes"):
        dataset.boxes(0)
    assert dataset[0].problem is None


def test_v1_missing_depth_costs_one_frame(tmp_path: Path) -> None:
    write_v1(tmp_path)
    (tmp_path / "desk/desk_1/desk_1_2_depth.png").unlink()
    dataset = v1(tmp_path)
    assert dataset[1].problem == "desk_1_2_depth.png is missing"
    assert dataset[2].problem is None


def test_v1_camera_file_wins(tmp_path: Path) -> None:
    write_v1(tmp_path)
    write_camera_file(tmp_path, kinect(), fx=142.6)
    dataset = v1(tmp_path)
    assert dataset.camera is not None
    assert dataset.camera.fx == 142.6
    assert dataset.remarks == ()


@pytest.mark.parametrize("opened", [".", "imgs", "imgs/scene_01"])
def test_v2_scene_is_guessed_with_its_poses(opened: str, tmp_path: Path) -> None:
    write_v2(tmp_path)
    dataset = open_dataset(tmp_path / opened)
    assert isinstance(dataset, RgbdScenesV2)
    assert dataset.name == "RGB-D Scenes v2"
    assert dataset.ids == ("00000", "00001", "00002")
    for pose, expected in zip(dataset.poses, poses_around(3), strict=True):
        np.testing.assert_allclose(pose, expected, atol=1e-6)
    expected_depth = render(scaled_camera(rgbd_scenes_v2.CAMERA, SIZE), poses_around(3)[1]).depth
    depth = dataset[1].depth
    assert depth is not None
    assert np.isfinite(depth).mean() > 0.5
    np.testing.assert_allclose(depth, np.where(np.isnan(depth), np.nan, expected_depth), atol=1e-4)
    assert dataset.camera is not None
    assert dataset.camera.fx == 570.3 / 4
    check_dataset(dataset)


def test_v2_scenes_share_no_world(tmp_path: Path) -> None:
    write_v2(tmp_path, "01", 2)
    write_v2(tmp_path, "12", 1)
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("scene_01/00000", "scene_01/00001", "scene_12/00000")
    assert dataset.poses == (None, None, None)
    assert any("open a single one to have poses" in remark for remark in dataset.remarks)
    check_dataset(dataset)
    assert open_dataset(tmp_path / "imgs/scene_12").poses[0] is not None


def test_v2_without_poses_says_where_it_looked(tmp_path: Path) -> None:
    write_v2(tmp_path, with_poses=False)
    dataset = open_dataset(tmp_path)
    assert dataset.poses == (None, None, None)
    assert f"no poses: they are looked for in {tmp_path / 'pc'}" in dataset.remarks


def test_v2_frames_take_the_pose_of_their_number(tmp_path: Path) -> None:
    write_v2(tmp_path)
    lines = (tmp_path / "pc/01.pose").read_text().splitlines()
    (tmp_path / "pc/01.pose").write_text(
        "\n".join([lines[0], "nan" + lines[1][lines[1].index(" ") :]])
    )
    dataset = open_dataset(tmp_path)
    assert [pose is not None for pose in dataset.poses] == [True, False, False]
    assert dataset[0].problem is None
    assert dataset[1].problem == "01.pose holds no valid pose for it"
    assert dataset[2].problem == "01.pose holds no valid pose for it"
    (tmp_path / "imgs/scene_01/00000-color.png").unlink()
    dataset = open_dataset(tmp_path)
    assert dataset.poses == (None, None)
    assert (dataset[0].problem, dataset[1].problem) == (None, None)


@pytest.mark.parametrize("line", ["1 0 0 0 1 2", "1 0 0 0 1 2 3 4", "1 0 0 zero 1 2 3"])
def test_v2_malformed_poses(line: str, tmp_path: Path) -> None:
    write_v2(tmp_path)
    with (tmp_path / "pc/01.pose").open("a") as file:
        file.write("\n" + line)
    with pytest.raises(DataError, match=r"01\.pose: line 4 is .*expected: qw qx qy qz") as caught:
        open_dataset(tmp_path)
    assert line in str(caught.value)
    (tmp_path / "pc/01.pose").write_text("")
    with pytest.raises(DataError, match=r"01\.pose: holds no poses"):
        open_dataset(tmp_path)


def test_v2_missing_depth_costs_one_frame(tmp_path: Path) -> None:
    write_v2(tmp_path)
    (tmp_path / "imgs/scene_01/00001-depth.png").unlink()
    dataset = open_dataset(tmp_path)
    assert dataset[1].problem == "00001-depth.png is missing"
    assert dataset[1].T_world_camera is not None
