"""Bad recordings: one bad frame is told in words; a source without use is a `DataError`."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.datasets import open_dataset
from curiosight.errors import DataError
from recordings import (
    truncate,
    write_camera_file,
    write_depth,
    write_folder,
    write_image,
    write_osd,
    write_seven_scenes,
    write_tum,
)
from room import kinect


def damage(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(bytes(content))


def shrink(path: Path) -> None:
    write_depth(path, np.ones((60, 80), np.float32))


def make_eight_bit(path: Path) -> None:
    write_image(path, np.full((120, 160), 90, np.uint8))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (truncate, "frame-000001.depth.png is truncated"),
        (lambda path: truncate(path, 0.0), "frame-000001.depth.png is empty"),
        (damage, "frame-000001.depth.png is damaged"),
        (Path.unlink, "frame-000001.depth.png is missing"),
        (lambda path: path.write_text("depth"), "frame-000001.depth.png is not an image"),
        (shrink, "frame-000001.depth.png is 80x60, not 160x120"),
        (make_eight_bit, "frame-000001.depth.png has 8 bits"),
    ],
    ids=["truncated", "empty", "damaged", "missing", "text", "other size", "8 bits"],
)
def test_bad_depth_file_costs_one_frame(
    spoil: Callable[[Path], Any], words: str, tmp_path: Path
) -> None:
    views = write_seven_scenes(tmp_path)
    spoil(tmp_path / "seq-01/frame-000001.depth.png")
    dataset = open_dataset(tmp_path)
    frame = dataset[1]
    assert frame.problem is not None
    assert words in frame.problem
    assert frame.depth is not None
    assert np.isnan(frame.depth).all()
    np.testing.assert_array_equal(frame.rgb, views[1].rgb)
    assert dataset[0].problem is None
    assert dataset[2].problem is None


@pytest.mark.parametrize("ending", ["png", "jpg"])
def test_truncated_colour_is_black_and_told(ending: str, tmp_path: Path) -> None:
    write_seven_scenes(tmp_path, ending=ending)
    truncate(tmp_path / f"seq-01/frame-000000.color.{ending}", 0.6)
    dataset = open_dataset(tmp_path)
    assert dataset[0].problem == f"frame-000000.color.{ending} is truncated"
    assert not dataset[0].rgb.any()
    assert dataset[1].problem is None


def test_colour_of_another_size_is_told(tmp_path: Path) -> None:
    write_folder(tmp_path)
    write_image(tmp_path / "rgb/000002.png", np.zeros((60, 80, 3), np.uint8))
    problem = open_dataset(tmp_path)[2].problem
    assert problem == "000002.png is 80x60, not 160x120 as the recording"


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.full((4, 4), np.nan), "holds NaN"),
        (np.diag([2.0, 1, 1, 1]), "is not a rigid pose"),
        (np.diag([-1.0, 1, 1, 1]), "is not a rigid pose"),
        (np.eye(3), "holds 9 numbers"),
    ],
)
def test_bad_pose_is_told_and_left_out(matrix: np.ndarray, words: str, tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    np.savetxt(tmp_path / "seq-01/frame-000001.pose.txt", matrix)
    dataset = open_dataset(tmp_path)
    assert dataset.poses[1] is None
    problem = dataset[1].problem
    assert problem is not None
    assert words in problem
    assert dataset[1].depth is not None
    assert np.isfinite(dataset[1].depth).any()


def test_nan_in_trajectories(tmp_path: Path) -> None:
    write_folder(tmp_path / "folder")
    write_tum(tmp_path / "tum")
    for path in (tmp_path / "folder/poses.txt", tmp_path / "tum/groundtruth.txt"):
        lines = path.read_text().splitlines()
        path.write_text("\n".join([lines[0], lines[1].split()[0] + " nan" * 7, *lines[2:]]))
    folder, tum = open_dataset(tmp_path / "folder"), open_dataset(tmp_path / "tum")
    assert folder.poses[1] is None
    assert folder[1].problem == "poses.txt holds no valid pose for it"
    assert any("1 lines of groundtruth.txt" in remark for remark in tum.remarks)


def test_damaged_ground_truth_is_an_error_of_its_file(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    truncate(tmp_path / "ground_truth/frame-000000.png")
    write_image(tmp_path / "ground_truth/frame-000002.png", np.zeros((60, 80), np.uint8))
    dataset = open_dataset(tmp_path)
    with pytest.raises(DataError, match="is truncated"):
        dataset.ground_truth(0)
    with pytest.raises(DataError, match="make it 160x120"):
        dataset.ground_truth(2)


def refusal(path: Path) -> str:
    """Return the one line that refuses a source."""
    with pytest.raises(DataError) as caught:
        open_dataset(path)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_paths_that_are_no_recordings(tmp_path: Path) -> None:
    assert "does not exist" in refusal(tmp_path / "nowhere")
    assert "is an empty folder" in refusal(tmp_path)
    (tmp_path / "notes.txt").write_text("hello")
    assert "is a file, and no video" in refusal(tmp_path / "notes.txt")
    told = refusal(tmp_path)
    assert "put colour into rgb/ and depth" in told
    assert "TUM RGB-D" in told
    assert len(told) - len(str(tmp_path)) < 600
    write_osd(tmp_path / "scenes")
    assert f"did you mean {tmp_path / 'scenes'}?" in refusal(tmp_path)


def test_file_that_only_looks_like_a_video(tmp_path: Path) -> None:
    path = tmp_path / "clip.mp4"
    path.write_bytes(b"not a video")
    assert "cannot be read as a video" in refusal(path)
    # In a process of its own: FFmpeg asks how much to say only once.
    code = (
        f"import curiosight as cs\ntry: cs.open_dataset({str(path)!r})\nexcept cs.DataError: pass"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_eight_bit_depth_throughout(tmp_path: Path) -> None:
    write_folder(tmp_path)
    make_eight_bit(tmp_path / "depth/000000.png")
    assert open_dataset(tmp_path)[1].problem is None
    for path in (tmp_path / "depth").iterdir():
        make_eight_bit(path)
    assert "16-bit PNG" in refusal(tmp_path)


def test_folder_without_its_parts(tmp_path: Path) -> None:
    write_folder(tmp_path)
    for file in (tmp_path / "depth").iterdir():
        file.unlink()
    assert "depth: holds no .png, .pgm" in refusal(tmp_path)
    for file in (tmp_path / "rgb").iterdir():
        file.unlink()
    assert "rgb: holds no images" in refusal(tmp_path)
    shutil.rmtree(tmp_path / "depth")
    assert "put colour into rgb/ and depth" in refusal(tmp_path)


def test_all_colour_images_damaged(tmp_path: Path) -> None:
    write_tum(tmp_path)
    for path in (tmp_path / "rgb").iterdir():
        truncate(path)
    assert "none of the 3 colour images can be read" in refusal(tmp_path)


def test_two_files_of_one_frame(tmp_path: Path) -> None:
    write_folder(tmp_path)
    write_image(tmp_path / "rgb/000001.jpg", np.zeros((120, 160, 3), np.uint8))
    assert "000001.jpg and 000001.png are the same frame" in refusal(tmp_path)


@pytest.mark.parametrize("name", ["rgb", "depth", "groundtruth"])
@pytest.mark.parametrize("line", ["hello", "1.5 2 3", "12:30:01 rgb/1.png"])
def test_malformed_tum_list(name: str, line: str, tmp_path: Path) -> None:
    write_tum(tmp_path)
    with (tmp_path / f"{name}.txt").open("a") as file:
        file.write(line + "\n")
    message = refusal(tmp_path)
    assert f"{name}.txt" in message
    assert line in message


def test_tum_without_pairs(tmp_path: Path) -> None:
    write_tum(tmp_path)
    (tmp_path / "depth.txt").write_text("1.0 depth/1.png\n")
    assert "within 20 ms" in refusal(tmp_path)


def test_two_frames_of_one_name(tmp_path: Path) -> None:
    write_tum(tmp_path)
    lines = (tmp_path / "rgb.txt").read_text().splitlines()
    stamp, name = lines[2].split()
    shutil.copytree(tmp_path / "rgb", tmp_path / "left")
    (tmp_path / "rgb.txt").write_text("\n".join([*lines, f"{stamp} {name.replace('rgb', 'left')}"]))
    message = refusal(tmp_path)
    assert "two frames are called '1305031229.700000'" in message
    assert str(tmp_path / "rgb/1305031229.700000.png") in message
    assert str(tmp_path / "left/1305031229.700000.png") in message
    assert "give every colour image a name of its own" in message


def test_cameras_without_a_common_view(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    write_camera_file(tmp_path, kinect(), cx=-500.0)
    assert "have no view in common" in refusal(tmp_path)


def test_poses_that_fit_no_frames(tmp_path: Path) -> None:
    write_folder(tmp_path)
    lines = (tmp_path / "poses.txt").read_text().splitlines()
    (tmp_path / "poses.txt").write_text("\n".join(lines[:2]))
    message = refusal(tmp_path)
    assert "holds 2 poses for 3 colour images" in message
    assert "its stamps are the names of none of them" in message
    (tmp_path / "poses.txt").write_text(" ".join(["1.0", *lines[1].split()[1:]]))
    assert "its stamps are the names of 1 of them" in refusal(tmp_path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"fx": None, "cy": None}, "lacks fx, cy"),
        ({"focal": 500}, 'unknown key "focal"'),
        ({"depth_scal": 1}, 'use "depth_scale"?'),
        ({"fx": 0}, "fx is 0; expected a positive number"),
        ({"fy": "525"}, 'fy is "525"'),
        ({"fy": 10**400}, "expected a positive number"),
        ({"cx": float("nan")}, "cx is NaN"),
        ({"width": 160.5}, "width is 160.5; expected a whole number"),
        ({"height": True}, "height is true"),
        ({"width": 320}, "for 320x120 images, but the images are 160x120"),
        ({"depth_scale": 1000}, "depth_scale is 1000; expected metres per unit"),
        ({"labels": [1]}, "labels is [1]"),
        ({"labels": {"support": [1]}}, "objects_from"),
        ({"labels": {"objects_from": 2, "suport": [1]}}, 'use "support"?'),
        ({"labels": {"objects_from": 2, "ignore": 0}}, "labels.ignore is 0"),
        ({"depth_window": [0, 0, 170, 100]}, "inside the 160x120 image, got (0, 0, 170, 100)"),
        ({"depth_window": [80, 0, 80, 100]}, "expected u_min < u_max"),
        ({"depth_window": [0, 0]}, "depth_window is [0, 0]"),
    ],
    ids=lambda value: json.dumps(value)[:60] if isinstance(value, dict) else "",
)
def test_bad_camera_file(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    write_folder(tmp_path)
    write_camera_file(tmp_path, kinect(), **changes)
    assert words in refusal(tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "\x00\xff"])
def test_damaged_camera_file(text: str, tmp_path: Path) -> None:
    write_folder(tmp_path)
    (tmp_path / "camera.json").write_bytes(text.encode("latin-1"))
    assert "camera.json" in refusal(tmp_path)


def test_ground_truth_folder_that_fits_nothing(tmp_path: Path) -> None:
    write_folder(tmp_path / "room")
    with pytest.raises(DataError, match="is not a folder"):
        open_dataset(tmp_path / "room", ground_truth=tmp_path / "truth")
    (tmp_path / "truth").mkdir()
    with pytest.raises(DataError, match=r"name files such as 000000\.png"):
        open_dataset(tmp_path / "room", ground_truth=tmp_path / "truth")


@pytest.mark.parametrize("write", [write_seven_scenes, write_folder])
def test_recording_that_lost_all_its_poses_is_read_without(
    write: Callable[[Path], object], tmp_path: Path
) -> None:
    write(tmp_path)
    for path in (tmp_path / "seq-01").glob("*.pose.txt"):
        path.write_text("\n".join([" ".join(["-inf"] * 4)] * 4))
    if (tmp_path / "poses.txt").is_file():
        lines = [f"{k} " + " ".join(["nan"] * 7) for k in range(3)]
        (tmp_path / "poses.txt").write_text("\n".join(lines))
    dataset = open_dataset(tmp_path)
    assert [frame.problem for frame in (dataset[0], dataset[2])] == [None, None]
    assert list(dataset.poses) == [None, None, None]
    assert "none of its poses is one: read without" in dataset.remarks
