"""Scans of phones and scanners, as they are published: written small, read back."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from curiosight.datasets import Recording, Video, check_dataset, open_dataset
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.errors import DataError
from recordings import write_camera_file, write_depth, write_image
from room import View, poses_around, render
from scan_writers import (
    CAMERA,
    COLOUR,
    LOW,
    matrix,
    write_arkit,
    write_replica,
    write_scanner_app,
    write_scannet,
    write_stray,
)

WRITERS: dict[str, Callable[[Path], list[View]]] = {
    "3D Scanner App": write_scanner_app,
    "Stray Scanner": write_stray,
    "ScanNet": write_scannet,
    "ARKitScenes": write_arkit,
    "Replica": write_replica,
}
WITH_CONFIDENCE = ("3D Scanner App", "Stray Scanner", "ARKitScenes")


def opened(path: Path) -> Recording:
    dataset = open_dataset(path)
    assert isinstance(dataset, Recording)
    return dataset


def name_of(path: Path) -> str:
    """Return what a folder is taken for, or what is said where it is refused."""
    try:
        return open_dataset(path).name
    except DataError as error:
        return str(error)


def assert_poses(dataset: Recording, n_frames: int = 3) -> None:
    assert len(dataset) == n_frames
    for pose, expected in zip(dataset.poses, poses_around(n_frames), strict=True):
        assert pose is not None
        np.testing.assert_allclose(pose, expected, atol=1e-6)


@pytest.mark.parametrize("name", WRITERS)
def test_scan_comes_back(name: str, tmp_path: Path) -> None:
    views = WRITERS[name](tmp_path / "scan")
    dataset = opened(tmp_path / "scan")
    assert dataset.name == name
    assert_poses(dataset)
    check_dataset(dataset)
    for index, view in enumerate(views):
        frame = dataset[index]
        assert frame.problem is None
        assert frame.depth is not None
        assert np.abs(frame.rgb.astype(int) - view.rgb).mean() < 6  # JPEG, MPEG
        error = np.abs(frame.depth - view.depth)
        # Of depth with half the pixels of colour, a reading is up to a pixel away.
        assert np.nanmedian(error) < (0.001 if dataset.depth_size == dataset.size else 0.02)
        assert np.nanmean(error > 0.1) < 0.05
        is_left = np.arange(view.depth.shape[1]) < view.depth.shape[1] // 4
        n_unsure = np.isfinite(error)[:, is_left].sum()
        assert (n_unsure == 0) == (name in WITH_CONFIDENCE)
    camera = dataset.camera
    assert camera is not None
    assert camera.fx == pytest.approx(scaled_camera(CAMERA, dataset.size).fx, rel=1e-5)


@pytest.mark.parametrize("name", WRITERS)
def test_folder_of_scans_has_no_common_world(name: str, tmp_path: Path) -> None:
    for scan in ("a", "b"):
        WRITERS[name](tmp_path / scan)
    dataset = opened(tmp_path)
    assert dataset.name == name
    assert len(dataset) == 6
    assert [id[:2] for id in dataset.ids] == ["a/"] * 3 + ["b/"] * 3
    assert dataset.poses == (None,) * 6
    assert any("open a single one to have poses" in remark for remark in dataset.remarks)
    alone, together = opened(tmp_path / "b")[1], dataset[4]
    np.testing.assert_array_equal(alone.rgb, together.rgb)
    np.testing.assert_array_equal(alone.depth, together.depth)
    assert alone.camera == together.camera
    check_dataset(dataset)


@pytest.mark.parametrize("name", WRITERS)
def test_ground_truth_beside_a_scan(name: str, tmp_path: Path) -> None:
    views = WRITERS[name](tmp_path / "scan")
    id = opened(tmp_path / "scan").ids[1]
    write_image(tmp_path / f"scan/ground_truth/{id}.png", views[1].ground_truth)
    dataset = opened(tmp_path / "scan")
    assert [dataset.has_ground_truth(index) for index in range(3)] == [False, True, False]


def test_scanner_app_reads_each_image_with_its_camera_and_time(tmp_path: Path) -> None:
    write_scanner_app(tmp_path)
    dataset = opened(tmp_path)
    assert dataset.ids == ("frame_00000", "frame_00003", "frame_00060")
    cameras = [dataset[index].camera for index in range(3)]
    assert [camera.fx - CAMERA.fx for camera in cameras if camera] == pytest.approx([0, 0.03, 0.6])
    assert dataset[1].stamp_ns == 103_500_000_000


def test_scanner_app_uses_the_frames_that_have_depth(tmp_path: Path) -> None:
    write_scanner_app(tmp_path, (0, 1, 2, 3))
    (tmp_path / "depth_00001.png").unlink()
    (tmp_path / "conf_00002.png").unlink()
    (tmp_path / "frame_00003.json").write_text('{"frame_index": 3, "intrin')
    dataset = opened(tmp_path)
    assert dataset.ids == ("frame_00000", "frame_00002", "frame_00003")
    assert [pose is None for pose in dataset.poses] == [False, False, True]
    assert "1 of 4 colour images have no depth: left out" in dataset.remarks
    assert any(remark.startswith("1 frames have no intrinsics") for remark in dataset.remarks)
    assert dataset[2].camera == dataset[1].camera
    check_dataset(dataset)


@pytest.mark.parametrize("content", ["{}", "[1, 2]", '{"intrinsics": [1, 2, 3]}', "\xff"])
def test_json_of_something_else_is_no_scanner_app(content: str, tmp_path: Path) -> None:
    write_scanner_app(tmp_path)
    for path in tmp_path.glob("frame_*.json"):
        path.write_bytes(content.encode("latin-1"))
    assert name_of(tmp_path) != "3D Scanner App"


@pytest.mark.parametrize("form", ["old", "middle", "new"])
def test_stray_scanner_writes_three_tables(form: str, tmp_path: Path) -> None:
    write_stray(tmp_path, form=form)
    dataset = opened(tmp_path)
    assert dataset.ids == ("000000", "000001", "000002")
    assert_poses(dataset)
    stamps = [dataset[index].stamp_ns for index in range(3)]
    expected = [None] * 3 if form == "old" else [10_000_000_000, 10_016_667_000, 10_033_333_000]
    assert stamps == expected
    last = dataset[2].camera
    assert last is not None
    assert last.fx == pytest.approx(CAMERA.fx + (0.2 if form == "new" else 0), abs=1e-4)
    assert np.nanmax(dataset[0].depth) < 12.5


def test_stray_scanner_is_read_as_stored_though_metadata_turn_it(tmp_path: Path) -> None:
    views = write_stray(tmp_path / "scan", turned=90)
    frame = opened(tmp_path / "scan")[1]
    assert np.abs(frame.rgb.astype(int) - views[1].rgb).mean() < 6
    # What is only to be looked at stays turned.
    video = open_dataset(tmp_path / "scan/rgb.mp4")
    assert isinstance(video, Video)
    assert video[0].rgb.shape == (COLOUR[0], COLOUR[1], 3)


def test_stray_scanner_whose_parts_differ_in_length(tmp_path: Path) -> None:
    write_stray(tmp_path, n_frames=4)
    table = (tmp_path / "odometry.csv").read_text().splitlines()
    lost = ",".join([*table[2].split(",")[:2], *["nan"] * 7, *table[2].split(",")[9:]])
    (tmp_path / "odometry.csv").write_text("\n".join([*table[:2], lost, table[4]]))
    shutil.copy(tmp_path / "depth/000003.png", tmp_path / "depth/000004.png")
    (tmp_path / "depth/000000.png").unlink()
    (tmp_path / "camera_matrix.csv").unlink()
    dataset = opened(tmp_path)
    assert dataset.ids == ("000001", "000002", "000003")
    assert dataset.poses[:2] == (None, None)
    np.testing.assert_allclose(dataset.poses[2], poses_around(4)[3], atol=1e-6)
    for remark in (
        "odometry.csv has 3 rows for the 4 frames of rgb.mp4",
        "1 of 4 colour images have no depth: left out",
        "1 of 4 depth images have no colour: left out",
        "2 of 3 frames have no valid pose: tracking was lost",
    ):
        assert remark in dataset.remarks


def test_stray_scanner_without_any_camera_is_refused(tmp_path: Path) -> None:
    write_stray(tmp_path, form="middle")
    (tmp_path / "camera_matrix.csv").write_text("")
    with pytest.raises(DataError, match=r"has no camera_matrix.csv of 3x3 numbers"):
        open_dataset(tmp_path)


def test_scannet_casts_depth_where_intrinsics_differ(tmp_path: Path) -> None:
    own = scaled_camera(CAMERA, LOW)
    views = write_scannet(tmp_path, depth_camera=replace(own, fx=own.fx * 1.1, fy=own.fy * 1.1))
    dataset = opened(tmp_path)
    assert "depth is cast into the colour image: their intrinsics differ" in dataset.remarks
    depth = dataset[0].depth
    assert depth is not None
    error = np.abs(depth - views[0].depth)
    assert np.nanmean(error > 0.1) < 0.05
    # The depth camera sees less; brought to size instead, its readings would be elsewhere.
    assert np.isnan(depth[:, 0]).all()
    assert np.isfinite(depth[60:90, 64]).all()
    assert dataset.camera is not None
    assert dataset.camera.depth_window is not None
    check_dataset(dataset)


@pytest.mark.parametrize("lost", ["-inf " * 16, "nan " * 16, "0 " * 16, ""])
def test_scannet_where_tracking_was_lost(lost: str, tmp_path: Path) -> None:
    write_scannet(tmp_path)
    (tmp_path / "pose/1.txt").write_text(lost)
    dataset = opened(tmp_path)
    assert [pose is None for pose in dataset.poses] == [False, True, False]
    assert "1 of 3 frames have no valid pose: tracking was lost" in dataset.remarks
    assert dataset[1].problem is None
    (tmp_path / "pose/0.txt").unlink()
    (tmp_path / "pose/2.txt").write_text(lost)
    assert "no frame has a valid pose" in opened(tmp_path).remarks


def test_scannet_in_frames_with_what_is_known_of_the_scene(tmp_path: Path) -> None:
    scene = tmp_path / "scene0000_00"
    write_scannet(scene / "frames")
    shutil.rmtree(scene / "frames/intrinsic")
    low = scaled_camera(CAMERA, LOW)
    lines = ["appVersionId = 10", "colorToDepthExtrinsics = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"]
    for kind, camera in (("color", CAMERA), ("depth", low)):
        numbers = (camera.fx, camera.fy, camera.cx, camera.cy)
        lines += [
            f"{k}_{kind} = {n}" for k, n in zip(("fx", "fy", "mx", "my"), numbers, strict=True)
        ]
    (scene / "scene0000_00.txt").write_text("\n".join([*lines, "sceneType = Office"]))
    dataset = opened(scene)
    assert dataset.name == "ScanNet"
    assert dataset.ids == ("0", "1", "2")
    assert_poses(dataset)
    assert dataset.camera == CAMERA
    assert opened(tmp_path).ids == dataset.ids


def test_scannet_frames_with_info_and_another_unit(tmp_path: Path) -> None:
    views = write_scannet(tmp_path, ids=("000000", "000100", "000200"))
    shutil.rmtree(tmp_path / "intrinsic")
    for index, id in enumerate(("000000", "000100", "000200")):
        pose = poses_around(3)[index]
        depth = render(scaled_camera(CAMERA, LOW), pose).depth
        write_depth(tmp_path / f"depth/{id}.png", depth, 0.0005)
    numbers = " ".join(map(str, matrix(CAMERA, 4).ravel()))
    (tmp_path / "_info.txt").write_text(
        f"m_versionNumber = 4\nm_depthShift = 2000\nm_calibrationColorIntrinsic = {numbers}\n"
    )
    dataset = opened(tmp_path)
    assert dataset.ids == ("000000", "000100", "000200")
    depth = dataset[1].depth
    assert depth is not None
    assert np.nanmedian(np.abs(depth - views[1].depth)) < 0.02


def test_scannet_intrinsics_of_images_before_they_were_made_smaller(tmp_path: Path) -> None:
    write_scannet(tmp_path)
    full = scaled_camera(CAMERA, (1296, 968))
    shutil.rmtree(tmp_path / "intrinsic")
    np.savetxt(tmp_path / "intrinsics_color.txt", matrix(full, 4))
    np.savetxt(tmp_path / "intrinsics_depth.txt", matrix(scaled_camera(CAMERA, (640, 480)), 4))
    camera = opened(tmp_path).camera
    assert camera is not None
    assert (camera.fx, camera.cx) == pytest.approx((CAMERA.fx, CAMERA.cx))


def test_colour_and_depth_without_scannets_intrinsics_are_not_scannet(tmp_path: Path) -> None:
    write_scannet(tmp_path)
    shutil.rmtree(tmp_path / "intrinsic")
    write_camera_file(tmp_path, CAMERA)
    assert name_of(tmp_path) != "ScanNet"


def test_arkit_scenes_in_a_folder_of_frames(tmp_path: Path) -> None:
    write_arkit(tmp_path / "41069021/41069021_frames")
    dataset = opened(tmp_path / "41069021")
    assert dataset.ids == ("41069021_305.377", "41069021_305.477", "41069021_305.577")
    assert_poses(dataset)
    assert dataset[1].stamp_ns == 305_477_000_000
    assert opened(tmp_path).ids == dataset.ids


def test_arkit_scenes_has_no_pose_far_from_those_written(tmp_path: Path) -> None:
    write_arkit(tmp_path)
    lines = (tmp_path / "lowres_wide.traj").read_text().splitlines()
    late = lines[1].replace(lines[1].split()[0], "305.387")
    (tmp_path / "lowres_wide.traj").write_text("\n".join([late, *lines[2:4]]))
    poses = opened(tmp_path).poses
    # The first is 10 ms before the first of the table, the last 80 ms after its last.
    assert [pose is None for pose in poses] == [False, False, True]
    (tmp_path / "lowres_wide.traj").write_text("305.4 0 0 0 1 2")
    with pytest.raises(DataError, match=r'line 1 is "305.4 0 0 0 1 2"'):
        open_dataset(tmp_path)


def test_replica_takes_its_usual_camera(tmp_path: Path) -> None:
    views = write_replica(tmp_path / "room0")
    (tmp_path / "cam_params.json").unlink()
    dataset = opened(tmp_path / "room0")
    assert dataset.camera is not None
    assert dataset.camera.fx == pytest.approx(600 * COLOUR[0] / 1200)
    assert any("0.00015259 m is taken" in remark for remark in dataset.remarks)
    depth = dataset[0].depth
    assert depth is not None
    assert np.nanmedian(np.abs(depth - np.minimum(views[0].depth, 9))) < 0.001


def test_replica_says_its_unit(tmp_path: Path) -> None:
    write_replica(tmp_path / "room0", depth_scale=0.001)
    assert opened(tmp_path / "room0").depth_scale == pytest.approx(0.001)


def test_scans_of_cameras_of_their_own(tmp_path: Path) -> None:
    write_scannet(tmp_path / "a")
    own = scaled_camera(CAMERA, LOW)
    write_scannet(tmp_path / "b", depth_camera=replace(own, fx=own.fx * 1.1, fy=own.fy * 1.1))
    dataset = opened(tmp_path)
    for index, scan in ((1, "a"), (4, "b")):
        np.testing.assert_array_equal(dataset[index].depth, opened(tmp_path / scan)[1].depth)


def test_scans_in_different_units_are_opened_one_at_a_time(tmp_path: Path) -> None:
    for scale, scan in ((0.001, "a"), (0.0002, "b")):
        write_replica(tmp_path / scan, depth_scale=scale)
        shutil.move(tmp_path / "cam_params.json", tmp_path / scan / "cam_params.json")
    assert opened(tmp_path / "a").depth_scale == pytest.approx(0.001)
    with pytest.raises(DataError, match="differ in the unit of depth"):
        open_dataset(tmp_path)


@pytest.mark.parametrize("ending", ["sens", "oni", "klg"])
def test_files_of_other_programs_are_refused_with_a_remedy(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"table.{ending}"
    path.write_bytes(b"anything")
    for opened_path in (path, tmp_path):
        with pytest.raises(DataError, match="which is not read") as error:
            open_dataset(opened_path)
        assert error.value.path == path
        assert "16-bit PNG" in str(error.value) or "SensReader" in str(error.value)


def test_matroska_that_is_no_video_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.mkv").write_bytes(b"\x1aE\xdf\xa3...")
    with pytest.raises(DataError, match="cannot be read as a video"):
        open_dataset(tmp_path / "other.mkv")


def test_export_of_record3d_as_exr_is_refused_with_a_remedy(tmp_path: Path) -> None:
    write_image(tmp_path / "rgb/0.jpg", np.zeros((6, 8, 3), np.uint8))
    for file in ("metadata.json", "depth/0.exr"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text("{}")
    with pytest.raises(DataError, match=r"is a recording of Record3D.*16-bit PNG"):
        open_dataset(tmp_path)
