"""SUN RGB-D, SUN3D, 3DMatch and MIT-Princeton's frames, whose depth may have rotated bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.datasets import check_dataset, open_dataset
from curiosight.datasets.depth_bits import rotated_bits
from curiosight.errors import DataError
from curiosight.frame import Camera
from recordings import write_camera_file, write_depth, write_image, write_seven_scenes
from room import View, kinect, poses_around, render

SIZE = (160, 120)
CAMERA = Camera(160, 120, 140.0, 142.0, 78.0, 61.0)


def write_rotated(path: Path, depth: npt.NDArray[np.float32], unit: float = 0.001) -> None:
    """Write depth with its 16 bits rotated by 3 to the left."""
    plain = np.nan_to_num(np.round(depth / unit)).clip(0, 65535).astype(np.uint16)
    write_image(path, (plain << 3) | (plain >> 13))


def write_matrix(path: Path, camera: Camera = CAMERA) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    path.write_text("\n".join(" ".join(map(str, row)) for row in rows))


def rows_of(pose: npt.NDArray[np.float64], n_rows: int = 4) -> str:
    return "\n".join(" ".join(map(str, row)) for row in pose[:n_rows])


# Bits.


def noisy(view: View, seed: int = 0) -> npt.NDArray[np.float32]:
    noise = np.random.default_rng(seed).normal(0, 0.002, view.depth.shape)
    return (view.depth + noise).astype(np.float32)


@pytest.mark.parametrize("unit", [0.001, 0.0001, 0.0002])
@pytest.mark.parametrize("is_noisy", [False, True])
def test_rotation_is_told_by_content(tmp_path: Path, unit: float, is_noisy: bool) -> None:
    view = render(CAMERA, poses_around(3)[0])
    depth = noisy(view) if is_noisy else view.depth
    write_rotated(tmp_path / "rotated.png", depth, unit)
    near = np.where(depth / unit < 65000, depth, np.nan).astype(np.float32)
    write_depth(tmp_path / "plain.png", near, unit)
    assert rotated_bits([tmp_path / "rotated.png"]) == 3
    assert rotated_bits([tmp_path / "plain.png"]) == 0


def test_rotation_of_what_says_nothing_is_none(tmp_path: Path) -> None:
    write_image(tmp_path / "flat.png", np.full((120, 160), 8000, np.uint16))
    write_image(tmp_path / "empty.png", np.zeros((120, 160), np.uint16))
    files = [tmp_path / "flat.png", tmp_path / "empty.png", tmp_path / "missing.png"]
    assert rotated_bits(files) == 0
    assert rotated_bits([]) == 0


# SUN RGB-D.


def write_sun_rgbd(folder: Path, stem: str, *, camera: Camera = CAMERA, place: int = 0) -> View:
    view = render(camera, poses_around(3)[place])
    write_image(folder / f"image/{stem}.jpg", view.rgb)
    write_rotated(folder / f"depth/{stem}.png", np.minimum(view.depth, np.float32(8.0)))
    filled = np.full(view.depth.shape, 1.0, np.float32)
    write_rotated(folder / f"depth_bfx/{stem}.png", filled)
    write_matrix(folder / "intrinsics.txt", camera)
    (folder / "scene.txt").write_text("office")
    return view


def test_sun_rgbd_image(tmp_path: Path) -> None:
    view = write_sun_rgbd(tmp_path, "NYU0001")
    dataset = open_dataset(tmp_path)
    check_dataset(dataset)
    assert dataset.name == "SUN RGB-D"
    assert dataset.ids == ("NYU0001",)
    assert dataset.camera == CAMERA
    depth = dataset[0].depth
    assert depth is not None
    is_far = view.depth >= 7.9995
    assert is_far.any()
    assert np.isnan(depth[is_far]).all()
    np.testing.assert_allclose(depth[~is_far], view.depth[~is_far], atol=0.0006)


def test_sun_rgbd_of_many_cameras(tmp_path: Path) -> None:
    other = Camera(160, 120, 133.0, 133.0, 80.0, 60.0)
    write_sun_rgbd(tmp_path / "kv1/NYUdata/NYU0001", "NYU0001")
    write_sun_rgbd(tmp_path / "kv1/b3dodata/img_0063", "img_0063", camera=other, place=1)
    (tmp_path / "kv1/NYUdata/NYU0001/depth/NYU0001.png").rename(
        tmp_path / "kv1/NYUdata/NYU0001/depth/0000007.png"
    )
    for root, prefix in ((tmp_path, "kv1/"), (tmp_path / "kv1", "")):
        dataset = open_dataset(root)
        assert dataset.ids == (
            f"{prefix}NYUdata/NYU0001/NYU0001",
            f"{prefix}b3dodata/img_0063/img_0063",
        )
        assert [dataset[index].camera for index in range(2)] == [CAMERA, other]
        assert [dataset[index].problem for index in range(2)] == [None, None]
        assert set(dataset.poses) == {None}


def test_sun_rgbd_with_filled_depth_only(tmp_path: Path) -> None:
    write_sun_rgbd(tmp_path, "a")
    for file in (tmp_path / "depth").iterdir():
        file.unlink()
    (tmp_path / "depth").rmdir()
    dataset = open_dataset(tmp_path)
    assert any("holes are filled" in remark for remark in dataset.remarks)


# SUN3D.


def write_sun3d(root: Path) -> list[View]:
    poses = poses_around(4)
    views = [render(CAMERA, pose) for pose in poses]
    for index, view in enumerate(views):
        write_image(root / f"image/{index + 1:07d}-{index * 33369:012d}.jpg", view.rgb)
        write_rotated(root / f"depth/{index + 2:07d}-{index * 33369 + 9000:012d}.png", view.depth)
    write_matrix(root / "intrinsics.txt")
    (root / "extrinsics").mkdir()
    (root / "extrinsics/20120101.txt").write_text(rows_of(np.eye(4), 3))
    (root / "extrinsics/20130512.txt").write_text("\n".join(rows_of(p, 3) for p in poses))
    return views


def test_sun3d(tmp_path: Path) -> None:
    views = write_sun3d(tmp_path)
    dataset = open_dataset(tmp_path)
    check_dataset(dataset)
    assert dataset.name == "SUN3D"
    assert dataset.ids[1] == "0000002-000000033369"
    assert dataset.camera == CAMERA
    for index, (view, pose) in enumerate(zip(views, poses_around(4), strict=True)):
        frame = dataset[index]
        np.testing.assert_allclose(frame.depth, view.depth, atol=0.0006)
        np.testing.assert_allclose(frame.T_world_camera, pose)
        assert frame.stamp_ns == index * 33369000


# 3DMatch and MIT-Princeton.


def write_frames(
    folder: Path, *, rotated: bool, unit: float = 0.001, poses: bool = True
) -> list[View]:
    views = []
    for index, pose in enumerate(poses_around(3)):
        view = render(CAMERA, pose)
        stem = f"frame-{index:06d}"
        write_image(folder / f"{stem}.color.png", view.rgb)
        (write_rotated if rotated else write_depth)(folder / f"{stem}.depth.png", view.depth, unit)
        if poses:
            (folder / f"{stem}.pose.txt").write_text(rows_of(pose))
        views.append(view)
    return views


def assert_frames(
    path: Path, views: list[View], *, prefix: str = "", tolerance: float = 0.0006
) -> None:
    dataset = open_dataset(path)
    check_dataset(dataset)
    assert dataset.name == "3DMatch / MIT-Princeton"
    assert dataset.ids[:3] == tuple(f"{prefix}frame-{index:06d}" for index in range(3))
    assert dataset.camera == CAMERA
    for index, (view, pose) in enumerate(zip(views, poses_around(3), strict=True)):
        frame = dataset[index]
        np.testing.assert_allclose(frame.depth, view.depth, atol=tolerance)
        np.testing.assert_allclose(frame.T_world_camera, pose, atol=1e-9)


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize(
    "name", ["camera-intrinsics.txt", "intrinsics.txt", "camera.intrinsics.txt"]
)
def test_camera_file_beside_or_above(tmp_path: Path, rotated: bool, name: str) -> None:
    views = write_frames(tmp_path / "seq-01", rotated=rotated)
    write_matrix(tmp_path / name)
    assert_frames(tmp_path, views)
    assert_frames(tmp_path / "seq-01", views)
    (tmp_path / name).rename(tmp_path / "seq-01" / name)
    assert_frames(tmp_path / "seq-01", views)


def test_sequences_of_a_scene_share_its_world(tmp_path: Path) -> None:
    views = write_frames(tmp_path / "seq-01", rotated=False)
    write_frames(tmp_path / "seq-02", rotated=False)
    write_matrix(tmp_path / "camera-intrinsics.txt")
    assert_frames_of_first(tmp_path, views)


def assert_frames_of_first(path: Path, views: list[View]) -> None:
    dataset = open_dataset(path)
    assert len(dataset) == 6
    assert all(pose is not None for pose in dataset.poses)
    np.testing.assert_allclose(dataset[0].depth, views[0].depth, atol=0.0006)


def write_cam_info(folder: Path) -> None:
    """Write the camera file of the picking challenge, with depth's own camera and the poses."""
    depth_camera = Camera(160, 120, 118.0, 118.0, 77.0, 61.0)
    T_colour_depth = np.eye(4)
    T_colour_depth[0, 3] = 0.025
    text = '# Environment: shelf\n# Bin ID: A\n# Objects: ["a","b"]\n'
    for name, camera in (("Color", CAMERA), ("Depth", depth_camera)):
        write_matrix(folder / "one.txt", camera)
        text += f"\n# {name} camera intrinsic matrix\n{(folder / 'one.txt').read_text()}\n"
    (folder / "one.txt").unlink()
    text += f"\n# Depth-to-color camera extrinsic matrix\n{rows_of(T_colour_depth)}\n"
    text += f"\n# Bin-to-world transformation matrix\n{rows_of(np.eye(4))}\n"
    for index, pose in enumerate(poses_around(3)):
        name = f"Camera-to-world extrinsic matrix (camera pose) for frame-{index:06d}"
        text += f"\n# {name}\n{rows_of(pose)}\n"
    (folder / "cam.info.txt").write_text(text)


def test_picking_challenge(tmp_path: Path) -> None:
    views = write_frames(tmp_path, rotated=True, unit=0.0001, poses=False)
    write_frames(tmp_path / "raw", rotated=True, unit=0.0001, poses=False)
    write_cam_info(tmp_path)
    for view in views:  # 16 bits of a tenth of a millimetre end at 6.5 m
        view.depth[view.depth > 6.5535] = np.float32(6.5535)
    dataset = open_dataset(tmp_path)
    assert dataset.ids == tuple(f"frame-{index:06d}" for index in range(3))
    assert dataset.camera == CAMERA
    for index, pose in enumerate(poses_around(3)):
        frame = dataset[index]
        assert frame.depth is not None
        seen = np.isfinite(frame.depth)
        np.testing.assert_allclose(frame.depth[seen], views[index].depth[seen], atol=0.0001)
        assert seen.mean() > 0.5
        np.testing.assert_allclose(frame.T_world_camera, pose)


def test_seven_scenes_without_camera_file_stays(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    (tmp_path / "TrainSplit.txt").write_text("sequence1\nsequence2\n")
    assert open_dataset(tmp_path).name == "7-Scenes"
    assert open_dataset(tmp_path / "seq-01").name == "7-Scenes"
    write_camera_file(tmp_path, kinect())
    assert open_dataset(tmp_path).name == "7-Scenes"


# What is refused.


def test_raw_nyu_is_refused_with_a_way_out(tmp_path: Path) -> None:
    write_image(tmp_path / "kitchen/r-1294.ppm", np.full((4, 4, 3), 30, np.uint8))
    write_image(tmp_path / "kitchen/d-1294.pgm", np.full((4, 4), 300, np.uint16))
    (tmp_path / "kitchen/a-1294.dump").write_bytes(b"\0")
    for path in (tmp_path, tmp_path / "kitchen"):
        with pytest.raises(DataError, match=r"raw NYU.*project_depth_map"):
            open_dataset(path)


def test_matlab_file_is_refused_with_a_way_out(tmp_path: Path) -> None:
    file = tmp_path / "nyu_depth_v2_labeled.mat"
    file.write_bytes(b"MATLAB 7.3 MAT-file")
    with pytest.raises(DataError, match=r"is a MATLAB file.*plain folder"):
        open_dataset(file)


@pytest.mark.parametrize("name", ["colorIntrinsics.txt", "K.txt", "camera.txt", "info.txt"])
def test_names_of_seven_scenes_with_a_camera_file_are_no_seven_scenes(
    name: str, tmp_path: Path
) -> None:
    """Depth of Intrinsic3D and of BundleFusion is registered already."""
    view = render(CAMERA, poses_around(3)[0])
    write_image(tmp_path / "frame-000000.color.png", view.rgb)
    write_depth(tmp_path / "frame-000000.depth.png", view.depth)
    write_matrix(tmp_path / name)
    dataset = open_dataset(tmp_path)
    assert dataset.name == "3DMatch / MIT-Princeton"
    assert dataset.camera == CAMERA
    assert np.nanmax(np.abs(dataset[0].depth - view.depth)) < 0.001
