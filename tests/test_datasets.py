"""Recordings in every layout: written small, read back, compared with what was written."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from curiosight.datasets import Video, check_dataset, open_dataset
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.layouts import osd, seven_scenes, tum_rgbd
from curiosight.datasets.listing import natural_key
from curiosight.datasets.trajectory import Trajectory, parse_stamp
from curiosight.frame import Camera
from recordings import (
    FIRST_STAMP,
    annotation,
    write_camera_file,
    write_depth,
    write_folder,
    write_image,
    write_osd,
    write_seven_scenes,
    write_tum,
)
from room import kinect, poses_around, render

WRITERS = {
    "7-Scenes": write_seven_scenes,
    "TUM RGB-D": write_tum,
    "OSD / OCID": write_osd,
    "plain folder": write_folder,
}


@pytest.mark.parametrize("name", WRITERS)
def test_layout_is_guessed_and_keeps_the_contract(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path)
    dataset = open_dataset(tmp_path)
    assert dataset.name == name
    assert len(dataset) == 3
    assert dataset.has_depth
    check_dataset(dataset)


@pytest.mark.parametrize("name", WRITERS)
def test_colour_and_depth_come_back(name: str, tmp_path: Path) -> None:
    views = WRITERS[name](tmp_path)
    frame = open_dataset(tmp_path)[1]
    assert frame.problem is None
    np.testing.assert_array_equal(frame.rgb, views[1].rgb)
    assert frame.depth is not None
    error = np.abs(frame.depth - views[1].depth)
    assert np.nanmedian(error) < 0.01
    # Registered depth lacks a border, and its outlines are a pixel uncertain.
    assert np.isfinite(error).mean() > 0.75
    assert np.nanmean(error > 0.1) < 0.02


@pytest.mark.parametrize("name", ["7-Scenes", "TUM RGB-D", "plain folder"])
def test_poses_are_the_colour_cameras(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path)
    dataset = open_dataset(tmp_path)
    for pose, expected in zip(dataset.poses, poses_around(3), strict=True):
        assert pose is not None
        np.testing.assert_allclose(pose, expected, atol=1e-6)


def test_seven_scenes_ground_truth_ids_and_window(tmp_path: Path) -> None:
    views = write_seven_scenes(tmp_path)
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("frame-000000", "frame-000001", "frame-000002")
    assert [dataset.has_ground_truth(index) for index in range(3)] == [True, False, True]
    np.testing.assert_array_equal(dataset.ground_truth(2), views[2].ground_truth)
    assert dataset.ground_truth(1) is None
    assert dataset.camera is not None
    assert dataset.camera.depth_window is not None
    u_min, v_min, u_max, v_max = dataset.camera.depth_window
    assert 0 < u_min < 10
    assert 140 < u_max < 150
    assert (v_min, v_max) == (6, 113)


@pytest.mark.parametrize("way", ["seq-01", "."])
def test_opening_one_sequence_finds_ground_truth_beside_it(
    way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_seven_scenes(tmp_path)
    monkeypatch.chdir(tmp_path if way != "." else tmp_path / "seq-01")
    dataset = open_dataset(way)
    assert dataset.ids[0] == "frame-000000"
    assert dataset.has_ground_truth(0)


def test_several_sequences_prefix_their_ids(tmp_path: Path) -> None:
    views = write_seven_scenes(tmp_path, n_frames=2, sequence="seq-02")
    write_seven_scenes(tmp_path, n_frames=1, sequence="seq-10", ending="jpg")
    write_image(tmp_path / "ground_truth/seq-02/frame-000001.png", views[1].ground_truth)
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("seq-02/frame-000000", "seq-02/frame-000001", "seq-10/frame-000000")
    assert [dataset.has_ground_truth(index) for index in range(3)] == [False, True, False]
    check_dataset(dataset)
    # A bare id in ground_truth/ would be ambiguous, so it belongs to no sequence.
    assert not open_dataset(tmp_path / "seq-10").has_ground_truth(0)


def test_camera_file_beside_a_recording_wins(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    write_camera_file(tmp_path, kinect(), fx=140.0, depth_window=[8, 8, 150, 110])
    camera = open_dataset(tmp_path).camera
    assert camera is not None
    assert camera.fx == 140.0
    assert camera.depth_window == (8, 8, 150, 110)


def test_tum_pairs_within_20_ms_and_keeps_exact_stamps(tmp_path: Path) -> None:
    write_tum(tmp_path, n_frames=3)
    depth_list = (tmp_path / "depth.txt").read_text().splitlines()
    late = f"{FIRST_STAMP + 0.225:.6f} {depth_list[2].split()[1]}"
    (tmp_path / "depth.txt").write_text("\n".join([depth_list[1], late, depth_list[3]]))
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("1305031229.500000", "1305031229.900000")
    assert dataset[0].stamp_ns == 1305031229_500000000
    assert any("1 colour images have no depth" in remark for remark in dataset.remarks)
    assert any("default intrinsics" in remark for remark in dataset.remarks)


def test_tum_leaves_out_repeated_lines(tmp_path: Path) -> None:
    write_tum(tmp_path)
    lines = (tmp_path / "rgb.txt").read_text().splitlines()
    (tmp_path / "rgb.txt").write_text("\n".join([*lines, lines[1], lines[3], lines[1]]))
    dataset = open_dataset(tmp_path)
    assert len(dataset) == 3
    assert "3 lines of rgb.txt repeat another: left out" in dataset.remarks
    check_dataset(dataset)


@given(
    st.lists(st.integers(0, 30), min_size=1),
    st.lists(st.integers(0, 30), min_size=1),
)
def test_tum_pairs_as_a_plain_search_does(colour_steps: list[int], depth_steps: list[int]) -> None:
    # Steps of 5 ms: ties between neighbours, equal stamps and gaps of just 20 ms are frequent.
    first = 1305031229_000000000
    colour = [(first + 5_000_000 * step, Path(f"c{step}")) for step in sorted(colour_steps)]
    depth = sorted(
        (first + 5_000_000 * step, Path(f"d{number}")) for number, step in enumerate(depth_steps)
    )
    expected = []
    for stamp, rgb in colour:
        depth_stamp, file = min(depth, key=lambda image: abs(image[0] - stamp))
        if abs(depth_stamp - stamp) <= 20_000_000:
            expected.append((stamp, rgb, file))
    assert tum_rgbd.associate(colour, depth) == expected


def test_tum_without_poses(tmp_path: Path) -> None:
    write_tum(tmp_path, with_poses=False)
    assert open_dataset(tmp_path).poses == (None, None, None)


def test_poses_are_interpolated_only_between_near_neighbours() -> None:
    half = np.sqrt(0.5)
    trajectory = Trajectory(
        stamps_ns=np.array([0, 400, 1100]) * 1_000_000,
        positions=np.array([[0, 0, 0], [4, 0, 0], [11, 0, 0.0]]),
        quaternions=np.array([[0, 0, 0, 1], [0, 0, half, half], [0, 0, 0, 1]]),
    )
    queries = [-1, 0, 200_000_000, 700_000_000, 1_100_000_000, 1_100_000_001]
    before, first, middle, gap, last, after = trajectory.interpolated(queries)
    assert before is None
    assert gap is None
    assert after is None
    assert first is not None
    assert last is not None
    assert middle is not None
    np.testing.assert_allclose(last[:3, 3], [11, 0, 0])
    np.testing.assert_allclose(middle[:3, 3], [2, 0, 0])
    np.testing.assert_allclose(middle[:2, :2], [[half, -half], [half, half]], atol=1e-12)


@given(st.integers(0, 9 * 10**9), st.integers(0, 999_999_999))
def test_stamps_are_parsed_without_loss(seconds: int, nanoseconds: int) -> None:
    assert parse_stamp(f"{seconds}.{nanoseconds:09d}") == seconds * 10**9 + nanoseconds


@pytest.mark.parametrize(
    ("text", "stamp_ns"),
    [
        ("1.305031229528748000e+09", 1305031229528748000),
        ("1.3050312295287481e+09", 1305031229528748100),
        ("1.5E-3", 1_500_000),
        ("25e1", 250 * 10**9),
        ("0.0e+00", 0),
        ("1305031229528748033", 1305031229528748033),
        ("1.305031229528748e+18", 1305031229528748000),
        ("1305031229528748", 1305031229528748000),
        ("1305031229528", 1305031229528000000),
        ("1305031229528.25", 1305031229528250000),
    ],
)
def test_stamps_of_other_forms(text: str, stamp_ns: int) -> None:
    assert parse_stamp(text) == stamp_ns


@pytest.mark.parametrize("text", ["1e99", "1e999", "-1", "nan", "9" * 30, "9" * 5000, "1e", ".5.5"])
def test_what_is_no_stamp(text: str) -> None:
    with pytest.raises(ValueError, match="expected seconds"):
        parse_stamp(text)


@pytest.mark.parametrize("form", ["exponents", "nanoseconds"])
def test_tum_with_stamps_of_other_forms(form: str, tmp_path: Path) -> None:
    write_tum(tmp_path)
    expected = open_dataset(tmp_path)
    for name in ("rgb", "depth", "groundtruth"):
        lines = (tmp_path / f"{name}.txt").read_text().splitlines()[1:]
        words = [line.split() for line in lines]
        for line in words:
            stamp_ns = parse_stamp(line[0])
            line[0] = str(stamp_ns) if form == "nanoseconds" else f"{stamp_ns / 1e9:.18e}"
        (tmp_path / f"{name}.txt").write_text("\n".join(map(" ".join, words)))
    dataset = open_dataset(tmp_path)
    assert dataset.ids == expected.ids
    np.testing.assert_allclose(np.array(dataset.poses), np.array(expected.poses), atol=1e-6)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize("separator", [" ", "\t", ", ", ","])
def test_tum_lists_with_names_as_people_give_them(
    separator: str, encoding: str, tmp_path: Path
) -> None:
    write_tum(tmp_path)
    expected = open_dataset(tmp_path)[1].rgb
    for folder in ("rgb", "depth"):
        (tmp_path / folder).rename(tmp_path / f"my {folder} #1, left")
        lines = (tmp_path / f"{folder}.txt").read_text().splitlines()
        words = [
            line.replace(f"{folder}/", f"my {folder} #1, left\\").split(" ", 1) for line in lines
        ]
        text = "\r\n".join([lines[0], *(separator.join(line) for line in words[1:])])
        (tmp_path / f"{folder}.txt").write_bytes((text + "\r\n  \r\n").encode(encoding))
    dataset = open_dataset(tmp_path)
    assert len(dataset) == 3
    assert dataset[1].problem is None
    np.testing.assert_array_equal(dataset[1].rgb, expected)


def test_tum_list_with_comments_behind_names(tmp_path: Path) -> None:
    write_tum(tmp_path)
    text = (tmp_path / "rgb.txt").read_text()
    (tmp_path / "rgb.txt").write_text(text.replace(".png\n", ".png  # a good one\n"))
    assert open_dataset(tmp_path)[2].problem is None


def test_osd_labels_by_camera_file(tmp_path: Path) -> None:
    views = write_osd(tmp_path)
    truth = open_dataset(tmp_path).ground_truth(0)
    expected = np.where(annotation(views[0]) == 0, 125, views[0].ground_truth)
    np.testing.assert_array_equal(truth, expected)


def test_original_osd_has_objects_from_1_and_no_intrinsics(tmp_path: Path) -> None:
    views = write_osd(tmp_path, with_camera=False)
    dataset = open_dataset(tmp_path)
    expected = np.where(annotation(views[0]) == 0, 0, 255)
    np.testing.assert_array_equal(dataset.ground_truth(0), expected)
    assert dataset.camera is not None
    assert dataset.camera.fx == 525 / 4
    assert any("Kinect are assumed" in remark for remark in dataset.remarks)


def test_ground_truth_folder_wins_over_annotation(tmp_path: Path) -> None:
    views = write_osd(tmp_path)
    write_image(tmp_path / "ground_truth/learn1.png", 255 - views[1].ground_truth)
    dataset = open_dataset(tmp_path)
    np.testing.assert_array_equal(dataset.ground_truth(1), 255 - views[1].ground_truth)
    assert not dataset.has_ground_truth(0)


def test_ocid_is_found_below_its_root(tmp_path: Path) -> None:
    for name in ("seq01", "seq02"):
        sequence = tmp_path / "floor/left/box" / name
        write_folder(sequence, n_frames=1, with_poses=False, with_ground_truth=False)
        (sequence / "camera.json").unlink()
        write_image(sequence / "label/000000.png", np.ones((120, 160), np.uint16))
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("floor/left/box/seq01/000000", "floor/left/box/seq02/000000")
    assert dataset.has_ground_truth(1)
    check_dataset(dataset)


def write_ocid(sequence: Path, *, n_support: int) -> np.ndarray:
    """Write a frame of OCID; return its true mask."""
    (view,) = write_folder(sequence, n_frames=1, with_poses=False, with_ground_truth=False)
    (sequence / "camera.json").unlink()
    labels = annotation(view).astype(np.uint16)
    labels[labels >= 2] += n_support - 1
    if n_support == 2:
        labels[:, :80][labels[:, :80] == 1] = 2
    write_image(sequence / "label/000000.png", labels)
    return np.where(labels == 0, 125, view.ground_truth)


@pytest.mark.parametrize("link", [False, True])
def test_ocid_has_its_own_labels_on_floors_and_tables(link: bool, tmp_path: Path) -> None:
    root = tmp_path / "table/ARID20"  # where the user keeps it says nothing
    floor = write_ocid(root / "floor/bottom/seq01", n_support=1)
    table = write_ocid(root / "table/bottom/seq01", n_support=2)
    both = open_dataset(root)
    np.testing.assert_array_equal(both.ground_truth(0), floor)
    np.testing.assert_array_equal(both.ground_truth(1), table)
    assert isinstance(both, osd.Osd)
    instances = both.instance_truth(1)
    assert instances is not None
    np.testing.assert_array_equal(instances > 0, table == 255)
    np.testing.assert_array_equal(instances < 0, table == 125)
    sequence = root / "table/bottom/seq01"
    if link:
        (tmp_path / "mine").symlink_to(sequence)
        sequence = tmp_path / "mine"
    one = open_dataset(sequence)
    np.testing.assert_array_equal(one.ground_truth(0), table)
    assert any("OCID's floor and table, objects from 3" in remark for remark in one.remarks)
    write_camera_file(sequence, kinect(), labels={"support": [1], "objects_from": 2})
    assert (open_dataset(sequence).ground_truth(0) == 255).sum() > (table == 255).sum()


def test_osd_in_a_folder_called_table_is_no_ocid(tmp_path: Path) -> None:
    views = write_osd(tmp_path / "table", n_frames=1, with_camera=False)
    expected = np.where(annotation(views[0]) == 0, 0, 255)
    np.testing.assert_array_equal(open_dataset(tmp_path / "table").ground_truth(0), expected)


def test_ground_truth_behind_and_beside_links(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path / "disk")
    scene = tmp_path / "scene"
    scene.mkdir()
    (tmp_path / "disk/ground_truth").rename(tmp_path / "disk/truth")
    (tmp_path / "disk/seq-01").rename(tmp_path / "disk/recorded")
    (scene / "seq-01").symlink_to(tmp_path / "disk/recorded")
    (scene / "ground_truth").symlink_to(tmp_path / "disk/truth")
    (tmp_path / "mine").symlink_to(scene / "seq-01")
    for way in (scene, scene / "seq-01", tmp_path / "mine"):
        dataset = open_dataset(way)
        assert [dataset.has_ground_truth(index) for index in range(3)] == [True, False, True]
    (tmp_path / "disk/recorded").rename(tmp_path / "disk/seq-07")
    (tmp_path / "disk/truth").rename(tmp_path / "disk/ground_truth")
    (tmp_path / "by-day").symlink_to(tmp_path / "disk/seq-07")
    assert open_dataset(tmp_path / "by-day").has_ground_truth(2)


def test_folder_matches_poses_by_stamps_in_names(tmp_path: Path) -> None:
    write_folder(tmp_path, n_frames=10)
    restamp(tmp_path, [float(index) for index in range(10)], left_out=3)
    dataset = open_dataset(tmp_path)
    assert [index for index in range(10) if dataset.poses[index] is None] == [3]
    expected = poses_around(10)
    np.testing.assert_allclose(dataset.poses[4], expected[4], atol=1e-6)
    assert dataset[4].stamp_ns == 4 * 10**9
    assert dataset.remarks == ()


def test_folder_whose_names_count_from_1_takes_poses_in_order(tmp_path: Path) -> None:
    write_folder(tmp_path, n_frames=10, with_ground_truth=False)
    for folder in ("rgb", "depth"):
        for index in reversed(range(10)):
            file = tmp_path / folder / f"{index:06d}.png"
            file.rename(file.with_stem(f"{index + 1:06d}"))
    restamp(tmp_path, [float(index) for index in range(10)])
    dataset = open_dataset(tmp_path)
    assert dataset.ids[0] == "000001"
    for pose, expected in zip(dataset.poses, poses_around(10), strict=True):
        np.testing.assert_allclose(pose, expected, atol=1e-6)
    assert dataset.remarks == (
        "poses.txt is taken line by line: its stamps are not the images' names",
    )


def test_folder_whose_names_are_no_numbers_takes_poses_in_order(tmp_path: Path) -> None:
    write_folder(tmp_path, with_ground_truth=False)
    for folder in ("rgb", "depth"):
        for file in list((tmp_path / folder).iterdir()):
            file.rename(file.with_stem(f"view{file.stem}"))
    dataset = open_dataset(tmp_path)
    assert all(pose is not None for pose in dataset.poses)
    assert dataset.remarks == ()


def restamp(folder: Path, stamps: list[float], *, left_out: int | None = None) -> None:
    """Give the lines of poses.txt other stamps, and leave one of them out."""
    lines = (folder / "poses.txt").read_text().splitlines()
    lines = [
        " ".join([f"{stamp:.6f}", *line.split()[1:]])
        for number, (stamp, line) in enumerate(zip(stamps, lines, strict=True))
        if number != left_out
    ]
    (folder / "poses.txt").write_text("\n".join(lines))


def test_folder_leaves_out_what_its_confidence_calls_unsure(tmp_path: Path) -> None:
    views = write_folder(tmp_path)
    height, width = views[0].depth.shape
    before = open_dataset(tmp_path)
    for id in before.ids[:-1]:  # the last frame has none
        confidence = np.full((height // 2, width // 2), 2, np.uint8)
        confidence[:, :10], confidence[:10, 10:] = 0, 1
        write_image(tmp_path / "confidence" / f"{id}.png", confidence)
    recording = open_dataset(tmp_path)
    first, last = recording[0].depth, recording[len(recording) - 1].depth
    assert first is not None
    assert np.isnan(first[:, :20]).all()
    np.testing.assert_array_equal(first[:, 20:], before[0].depth[:, 20:])
    np.testing.assert_array_equal(last, before[len(before) - 1].depth)


def test_images_have_no_depth_and_come_in_natural_order(tmp_path: Path) -> None:
    view = render(kinect(), poses_around(1)[0])
    for name in ("img10.jpg", "img2.png", "img1.color.png", "img1.depth.png"):
        write_image(tmp_path / name, view.rgb)
    dataset = open_dataset(tmp_path)
    assert dataset.name == "folder of images"
    assert dataset.ids == ("img1", "img2", "img10")
    assert not dataset.has_depth
    assert dataset[1].depth is None
    check_dataset(dataset)


@given(st.lists(st.integers(0, 10**6), min_size=2))
def test_natural_order_sorts_numbers_by_value(numbers: list[int]) -> None:
    names = sorted((f"frame{number}b" for number in numbers), key=natural_key)
    assert names == [f"frame{number}b" for number in sorted(numbers)]


@pytest.mark.parametrize("size", [(2, 2), (5, 4), (33, 25), (320, 240), (1280, 1024)])
@pytest.mark.parametrize(
    "camera",
    [seven_scenes.DEPTH_CAMERA, tum_rgbd.CAMERA, osd.CAMERA],
    ids=["7-Scenes", "TUM RGB-D", "OSD"],
)
def test_default_cameras_fit_images_of_other_sizes(camera: Camera, size: tuple[int, int]) -> None:
    scaled = scaled_camera(camera, size)
    assert (scaled.width, scaled.height) == size
    np.testing.assert_allclose(scaled.fx / camera.fx, size[0] / 640)
    window = scaled.depth_window
    if size >= (33, 25):
        assert window is not None
        assert camera.depth_window is not None
        expected = np.array(camera.depth_window) * np.tile(size, 2) / (640, 480, 640, 480)
        np.testing.assert_allclose(window, expected, atol=1)


def test_video_is_read_in_order_and_back(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    codec = cv2.VideoWriter.fourcc(*"MJPG")
    writer = cv2.VideoWriter(str(path), cv2.CAP_OPENCV_MJPEG, codec, 10, (64, 48))
    for grey in (20, 90, 160, 230):
        writer.write(np.full((48, 64, 3), grey, np.uint8))
    writer.release()
    dataset = open_dataset(path)
    assert isinstance(dataset, Video)
    assert dataset.ids == ("000000", "000001", "000002", "000003")
    means = [int(dataset[index].rgb.mean()) for index in (0, 3, 1, 2)]
    np.testing.assert_allclose(means, [20, 230, 90, 160], atol=4)
    assert dataset[3].stamp_ns == 300_000_000
    check_dataset(dataset)


def test_other_ground_truth_can_be_given(tmp_path: Path) -> None:
    views = write_folder(tmp_path / "room")
    write_image(tmp_path / "truth/000001.png", 255 - views[1].ground_truth)
    dataset = open_dataset(tmp_path / "room", ground_truth=tmp_path / "truth")
    assert [dataset.has_ground_truth(index) for index in range(3)] == [False, True, False]
    np.testing.assert_array_equal(dataset.ground_truth(1), 255 - views[1].ground_truth)


def test_saturated_depth_is_no_reading(tmp_path: Path) -> None:
    write_folder(tmp_path)
    depth = np.full((120, 160), 65.535, np.float32)
    depth[60:] = 2.0
    write_depth(tmp_path / "depth/000000.png", depth)
    read = open_dataset(tmp_path)[0].depth
    assert read is not None
    assert np.isnan(read[:60]).all()
    np.testing.assert_allclose(read[60:], 2.0)


@pytest.mark.parametrize(
    ("folder", "name", "n_frames", "n_poses", "n_ground_truths"),
    [
        ("redkitchen", "7-Scenes", 500, 500, 50),
        ("rgbd_dataset_freiburg1_rpy", "TUM RGB-D", 121, 121, 0),
        ("osd_learn", "OSD / OCID", 45, 0, 45),
        ("floor_boxes", "plain folder", 10, 0, 0),
    ],
)
def test_real_recordings(
    folder: str, name: str, n_frames: int, n_poses: int, n_ground_truths: int
) -> None:
    root = os.environ.get("CURIOSIGHT_TEST_DATA")
    if not root:
        pytest.skip("CURIOSIGHT_TEST_DATA is not set")
    dataset = open_dataset(Path(root) / "data" / folder)
    assert (dataset.name, len(dataset)) == (name, n_frames)
    assert sum(pose is not None for pose in dataset.poses) == n_poses
    assert sum(map(dataset.has_ground_truth, range(n_frames))) == n_ground_truths
    check_dataset(dataset, n_frames=3)
    assert dataset[0].problem is None
