"""Pairs of images in one file, in the form of TUM RGB-D."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from curiosight.datasets import check_dataset, open_dataset
from curiosight.errors import DataError
from recordings import FIRST_STAMP, write_camera_file, write_depth, write_tum
from room import kinect, poses_around

SIZE = (160, 120)


def write_associated(root: Path, *, depth_first: bool, name: str = "associations.txt") -> list:
    """Write a recording of TUM's form with pairs instead of two lists."""
    views = write_tum(root)
    lines = []
    for colour, depth in zip(
        (root / "rgb.txt").read_text().splitlines(),
        (root / "depth.txt").read_text().splitlines(),
        strict=True,
    ):
        lines.append(f"{depth} {colour}" if depth_first else f"{colour} {depth}")
    (root / name).write_text("\n".join(["# pairs", *lines[1:], lines[-1], ""]))
    (root / "rgb.txt").unlink()
    (root / "depth.txt").unlink()
    write_camera_file(root, kinect(*SIZE), depth_scale=1 / 5000)
    return views


@pytest.mark.parametrize("depth_first", [False, True])
@pytest.mark.parametrize("name", ["associations.txt", "associate.txt", "assoc.txt"])
def test_pairs_are_read_in_either_order(tmp_path: Path, depth_first: bool, name: str) -> None:
    views = write_associated(tmp_path, depth_first=depth_first, name=name)
    dataset = open_dataset(tmp_path)
    check_dataset(dataset)
    assert dataset.name == "TUM RGB-D, associated"
    assert dataset.ids == tuple(f"{FIRST_STAMP + 0.2 * i:.6f}" for i in range(3))
    for index, (view, pose) in enumerate(zip(views, poses_around(3), strict=True)):
        frame = dataset[index]
        assert frame.stamp_ns == round((FIRST_STAMP + 0.2 * index) * 1e9)
        np.testing.assert_array_equal(frame.rgb, view.rgb)
        np.testing.assert_allclose(frame.depth, view.depth, atol=0.0002)
        np.testing.assert_allclose(frame.T_world_camera, pose, atol=1e-6)
    assert any("1 lines of" in remark for remark in dataset.remarks)


def test_both_lists_are_preferred(tmp_path: Path) -> None:
    write_associated(tmp_path / "a", depth_first=True)
    write_tum(tmp_path / "b")
    (tmp_path / "b/associations.txt").write_text((tmp_path / "a/associations.txt").read_text())
    assert open_dataset(tmp_path / "b").name == "TUM RGB-D"


def test_folder_named_depth_may_hold_colour(tmp_path: Path) -> None:
    """What images hold tells which is depth, whatever their folders are called."""
    write_associated(tmp_path, depth_first=True)
    (tmp_path / "rgb").rename(tmp_path / "x")
    (tmp_path / "depth").rename(tmp_path / "rgb")
    (tmp_path / "x").rename(tmp_path / "depth")
    file = tmp_path / "associations.txt"
    text = file.read_text().replace("rgb/", "x/").replace("depth/", "rgb/").replace("x/", "depth/")
    file.write_text(text)
    assert open_dataset(tmp_path)[0].problem is None


def test_pairs_without_stamps_or_without_files_are_another_program_s(tmp_path: Path) -> None:
    write_associated(tmp_path, depth_first=True)
    file = tmp_path / "associations.txt"
    lines = [line.split() for line in file.read_text().splitlines()[1:]]
    file.write_text("\n".join(f"{words[1]} {words[3]}" for words in lines))
    assert open_dataset(tmp_path).name == "plain folder"
    file.write_text("\n".join(f"0 a/{words[1]} 0 b/{words[3]}" for words in lines))
    assert open_dataset(tmp_path).name == "plain folder"


def test_pairs_of_two_colour_images_are_refused(tmp_path: Path) -> None:
    write_associated(tmp_path, depth_first=False)
    file = tmp_path / "associations.txt"
    words = [line.split() for line in file.read_text().splitlines()[1:]]
    file.write_text("\n".join(f"{w[0]} {w[1]} {w[0]} {w[1]}" for w in words))
    with pytest.raises(DataError, match="pairs no colour image with depth"):
        open_dataset(tmp_path)


def test_missing_depth_is_a_bad_frame(tmp_path: Path) -> None:
    write_associated(tmp_path, depth_first=False)
    sorted((tmp_path / "depth").iterdir())[1].unlink()
    dataset = open_dataset(tmp_path)
    problems = [dataset[index].problem for index in range(3)]
    assert [problem is None for problem in problems] == [True, False, True]
    write_depth(tmp_path / "depth/again.png", np.ones((120, 160), np.float32))
    assert "is missing" in str(problems[1])


@pytest.mark.parametrize("missing", ["rgb.txt", "depth.txt"])
def test_one_of_two_lists(tmp_path: Path, missing: str) -> None:
    views = write_tum(tmp_path)
    write_camera_file(tmp_path, kinect(*SIZE), depth_scale=1 / 5000)
    (tmp_path / missing).unlink()
    dataset = open_dataset(tmp_path)
    check_dataset(dataset)
    assert dataset.name == "TUM RGB-D, one list"
    assert dataset.ids == tuple(f"{FIRST_STAMP + 0.2 * i:.6f}" for i in range(3))
    for index, (view, pose) in enumerate(zip(views, poses_around(3), strict=True)):
        np.testing.assert_allclose(dataset[index].depth, view.depth, atol=0.0002)
        np.testing.assert_allclose(dataset.poses[index], pose, atol=1e-6)
