"""What overrules a recording: unit, bits, poses, confidence, a depth camera beside colour's."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import call, refusal, succeed
from curiosight.config import load_config
from curiosight.datasets import AS_RECORDED, Reading, Recording, open_dataset
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.frame import Camera
from recordings import SIZE, pose_line, write_camera_file, write_depth, write_folder, write_image
from room import kinect, look, poses_around, render

OPTIONS = ("depth-scale", "fix-units", "invert-poses", "min-confidence", "depth-camera")
Capsys = pytest.CaptureFixture[str]


def opened(path: Path, **reading: object) -> Recording:
    dataset = open_dataset(path, reading=Reading(**reading))  # type: ignore[arg-type]
    assert isinstance(dataset, Recording)
    return dataset


def median_depth(dataset: Recording) -> float:
    depth = dataset[0].depth
    assert depth is not None
    return float(np.nanmedian(depth))


def test_nothing_is_overruled_by_default(tmp_path: Path) -> None:
    write_folder(tmp_path)
    assert median_depth(opened(tmp_path)) == median_depth(open_dataset(tmp_path))  # type: ignore[arg-type]


def test_depth_scale_wins_over_the_recordings(tmp_path: Path) -> None:
    write_folder(tmp_path)
    plain = median_depth(opened(tmp_path))
    assert median_depth(opened(tmp_path, depth_scale=0.0002)) == pytest.approx(plain / 5)


def test_unit_that_fits_is_found(tmp_path: Path) -> None:
    views = write_folder(tmp_path, 8)
    write_camera_file(tmp_path, kinect(*SIZE), depth_scale=0.005)
    fixed = opened(tmp_path, fix_units=True)
    assert fixed.depth_scale == pytest.approx(0.001)
    assert median_depth(fixed) == pytest.approx(float(np.nanmedian(views[0].depth)), abs=0.001)
    assert "depth is read in units of 0.001 m, which fit" in fixed.remarks


def test_rotated_bits_are_turned_back(tmp_path: Path) -> None:
    views = write_folder(tmp_path, 6)
    for path in (tmp_path / "depth").iterdir():
        raw = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), (raw << 3) | (raw >> 13))
    fixed = opened(tmp_path, fix_units=True)
    depth = fixed[2].depth
    np.testing.assert_allclose(depth, views[2].depth, atol=0.0006)


def test_poses_are_turned_round(tmp_path: Path) -> None:
    write_folder(tmp_path)
    lines = [pose_line(k, np.linalg.inv(pose)) for k, pose in enumerate(poses_around(3))]
    (tmp_path / "poses.txt").write_text("\n".join(lines))
    np.testing.assert_allclose(
        opened(tmp_path, invert_poses=True).poses, poses_around(3), atol=1e-8
    )


def test_axes_of_poses_are_brought_to_ours(tmp_path: Path) -> None:
    write_folder(tmp_path)
    opengl = np.diag([1.0, -1.0, -1.0, 1.0])
    lines = [pose_line(k, pose @ opengl) for k, pose in enumerate(poses_around(3))]
    (tmp_path / "poses.txt").write_text("\n".join(lines))
    poses = opened(tmp_path, pose_axes="right,up,backward").poses
    np.testing.assert_allclose(poses, poses_around(3), atol=1e-8)


def test_mirrored_poses_become_those_of_a_mirrored_world(tmp_path: Path) -> None:
    write_folder(tmp_path)
    flip = np.diag([1.0, -1.0, 1.0, 1.0])
    lines = [pose_line(k, flip @ pose @ flip) for k, pose in enumerate(poses_around(3))]
    (tmp_path / "poses.txt").write_text("\n".join(lines))
    poses = opened(tmp_path, pose_axes="right,up,forward").poses
    np.testing.assert_allclose(poses, poses_around(3), atol=1e-8)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"depth_scale": -1.0}, "depth_scale: expected metres per unit"),
        ({"depth_scale": 1000.0}, "depth_scale: expected metres per unit"),
        ({"min_confidence": -2}, "min_confidence: expected 0 or more"),
        ({"pose_axes": "right,right,up"}, "pose_axes: expected three of right, left"),
        ({"pose_axes": "x"}, "pose_axes: expected three of"),
        ({"fix_units": True, "depth_scale": 0.001}, "fix_units: expected it or depth_scale"),
    ],
)
def test_nonsense_is_refused(options: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Reading(**options)  # type: ignore[arg-type]


def test_depth_of_another_size_is_brought_to_colour(tmp_path: Path) -> None:
    write_folder(tmp_path)
    small = [render(kinect(80, 60), pose).depth for pose in poses_around(3)]
    for k, depth in enumerate(small):
        write_depth(tmp_path / f"depth/{k:06d}.png", depth)
    dataset = opened(tmp_path)
    depth = dataset[1].depth
    assert depth is not None
    assert "depth is 80x60: brought to 160x120 like colour, nearest reading" in dataset.remarks
    # Each pixel is one that was there: no surface between two others is made.
    was_there = np.round(np.nan_to_num(small[1]), 3)
    assert np.isin(np.round(np.nan_to_num(depth), 3).astype(np.float32), was_there).all()
    truth = render(kinect(*SIZE), poses_around(3)[1]).depth
    assert np.nanmedian(np.abs(depth - truth)) < 0.02


def test_depth_of_another_shape_is_a_bad_frame_until_its_camera_is_known(
    tmp_path: Path, capsys: Capsys
) -> None:
    write_folder(tmp_path)
    wide = Camera(200, 100, 120.0, 120.0, 99.5, 49.5)
    T_colour_depth = np.eye(4)
    T_colour_depth[0, 3] = -0.05
    poses = poses_around(3)
    for k, pose in enumerate(poses):
        write_depth(tmp_path / f"depth/{k:06d}.png", render(wide, pose @ T_colour_depth).depth)
    shown = succeed(capsys, "info", tmp_path).out
    assert "0 of 3 usable (200×100, colour 160×120)" in shown
    assert "--depth-camera FILE" in shown
    file = tmp_path / "depth_camera.json"
    numbers = {name: getattr(wide, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    file.write_text(json.dumps({**numbers, "T_colour_depth": T_colour_depth.tolist()}))
    dataset = opened(tmp_path, depth_camera=str(file))
    frame = dataset[1]
    assert frame.problem is None
    assert frame.depth is not None
    error = np.abs(frame.depth - render(kinect(*SIZE), poses[1]).depth)
    assert np.nanmedian(error) < 0.01
    assert np.isfinite(error).mean() > 0.5


def test_depth_camera_without_its_place_is_refused(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path)
    line = refusal(capsys, "info", tmp_path, "--depth-camera", tmp_path / "camera.json")
    assert "does not say where the depth camera is" in line
    assert "T_colour_depth" in line
    assert "is no file" in refusal(capsys, "info", tmp_path, "--depth-camera", tmp_path / "no.json")


def test_unsure_readings_are_none(tmp_path: Path) -> None:
    view = render(kinect(*SIZE), look())
    for k in range(3):
        write_image(tmp_path / f"color_{k}.png", view.rgb)
        write_depth(tmp_path / f"depth_{k}.png", view.depth)
        confidence = np.zeros(SIZE[::-1], np.uint8)
        confidence[:, 40:] = 1
        confidence[:, 80:] = 2
        write_image(tmp_path / f"confidence_{k}.png", confidence)
    write_camera_file(tmp_path, kinect(*SIZE))
    for least, first in ((-1, 40), (0, 0), (1, 40), (2, 80)):
        depth = opened(tmp_path, min_confidence=least)[0].depth
        assert depth is not None
        assert np.isnan(depth[:, :first]).all()
        np.testing.assert_array_equal(
            np.isfinite(depth[:, first:]), np.isfinite(view.depth[:, first:])
        )


def test_options_stand_in_the_config_of_a_run(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "source", 4)
    out = tmp_path / "out"
    options = (
        "--depth-scale",
        "0.001",
        "--min-confidence",
        "2",
        "--pose-axes",
        "right,down,forward",
    )
    succeed(capsys, "segment", tmp_path / "source", "--out", out, *options)
    reading = load_config(None, out / "config.toml").reading
    assert reading == Reading(depth_scale=0.001, min_confidence=2, pose_axes="right,down,forward")
    again = succeed(capsys, "info", tmp_path / "source", "--config", out / "config.toml", "--json")
    assert json.loads(again.out)["depth"]["unit_m"] == 0.001


def test_rooms_need_no_options(capsys: Capsys) -> None:
    line = refusal(capsys, "info", "room:7", "--depth-scale", "0.001")
    assert "reading: expected nothing of what is drawn to be overruled" in line
    assert Reading() == AS_RECORDED


def test_every_command_with_a_source_has_the_options(capsys: Capsys) -> None:
    names = "info explore learn map saliency evaluate segment propose export score-teacher bench"
    for name in names.split():
        shown = call(capsys, name, "--help").out
        for option in (
            "depth-scale",
            "fix-units",
            "invert-poses",
            "min-confidence",
            "depth-camera",
        ):
            assert f"--{option}" in shown, name


def test_window_of_a_scaled_camera(tmp_path: Path) -> None:
    write_folder(tmp_path)
    camera = kinect(640, 480)
    write_camera_file(tmp_path, camera)
    assert opened(tmp_path).camera == scaled_camera(camera, SIZE)


def test_unit_that_nothing_says_is_the_one_that_fits(tmp_path: Path) -> None:
    pose = look()
    view = render(kinect(*SIZE), pose)
    for k in range(3):
        write_image(tmp_path / f"{k}.png", view.rgb)
        write_depth(
            tmp_path / f"{k}_depth.png", np.where(view.depth < 6, view.depth, np.nan), 0.0001
        )
    numbers = {name: getattr(kinect(*SIZE), name) for name in ("fx", "fy", "cx", "cy")}
    (tmp_path / "kinect.json").write_text(json.dumps(numbers))
    dataset = opened(tmp_path)
    assert dataset.depth_scale == pytest.approx(0.0001)
    assert "depth is read in units of 0.0001 m, which fit" in dataset.remarks
    assert opened(tmp_path, depth_scale=0.001).depth_scale == 0.001
