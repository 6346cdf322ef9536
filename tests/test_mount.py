"""How the camera is held, as its owner says it: `--up`, config.toml, "mount" in camera.json."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import refusal, succeed
from curiosight import open_dataset
from curiosight.config import Config, load_config
from curiosight.errors import DataError
from curiosight.experiments.components import make_teacher
from curiosight.frame import MOUNTS, is_rigid
from curiosight.teacher import PaperTeacher, Segmentation, Teacher
from curiosight.teacher.turning import TurnedTeacher
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]


def upside_down(folder: Path) -> Path:
    """Write a recording whose camera hangs upside down, without poses."""
    write_folder(folder, 2, size=(320, 240), with_poses=False)
    for kind in ("rgb", "depth", "ground_truth"):
        for path in (folder / kind).iterdir():
            image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            assert cv2.imwrite(str(path), image[::-1, ::-1])
    return folder


def say(folder: Path, mount: object) -> None:
    file = folder / "camera.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "mount": mount}))


def first_labels(config: Config, folder: Path) -> tuple[object, Segmentation]:
    dataset = open_dataset(folder)
    teacher = make_teacher(config, dataset)
    return teacher, teacher.segment(dataset[0])


@pytest.mark.parametrize("mount", MOUNTS)
def test_camera_file_says_how_the_camera_is_held(mount: str, tmp_path: Path) -> None:
    write_folder(tmp_path, 1)
    assert open_dataset(tmp_path).mount is None
    say(tmp_path, mount)
    assert open_dataset(tmp_path).mount == mount


@pytest.mark.parametrize("mount", ["sideways", 90, ["up"], "auto"])
def test_mount_that_is_none_is_refused(mount: object, tmp_path: Path) -> None:
    write_folder(tmp_path, 1)
    say(tmp_path, mount)
    with pytest.raises(DataError, match=r"mount is .*expected one of up, down, left, right"):
        open_dataset(tmp_path)


def test_settings_win_over_the_camera_file(tmp_path: Path) -> None:
    folder = upside_down(tmp_path / "room")
    config = Config.of_preset("default")
    say(folder, "down")
    teacher, found = first_labels(config, folder)
    assert isinstance(teacher, Teacher)
    assert teacher.survey.up_camera is not None
    assert teacher.survey.up_camera[1] > 0.9
    assert found.supports[0].plane.normal[1] > 0.8
    told = replace(config, teacher=replace(config.teacher, up="up"))
    teacher, found = first_labels(told, folder)
    assert isinstance(teacher, Teacher)
    assert not any(support.plane.normal[1] > 0.5 for support in found.supports)


def test_paper_teacher_sees_upright_what_is_said_to_be_turned(tmp_path: Path) -> None:
    folder = upside_down(tmp_path / "room")
    config = Config.of_preset("paper")
    assert isinstance(first_labels(config, folder)[0], PaperTeacher)
    say(folder, "down")
    teacher, found = first_labels(config, folder)
    assert isinstance(teacher, TurnedTeacher)
    truth = open_dataset(folder).ground_truth(0)
    assert truth is not None
    assert np.mean(truth[found.labels == 255] == 255) > 0.9
    assert np.mean(found.labels[truth == 255] == 255) > 0.5


def test_option_is_kept_with_the_run(tmp_path: Path, capsys: Capsys) -> None:
    folder = upside_down(tmp_path / "room")
    succeed(capsys, "segment", folder, "--up", "down", "--out", tmp_path / "out")
    assert load_config(None, tmp_path / "out/config.toml").teacher.up == "down"
    labels = cv2.imread(str(tmp_path / "out/labels/000000.png"), cv2.IMREAD_UNCHANGED)
    truth = open_dataset(folder).ground_truth(0)
    assert truth is not None
    assert np.mean(labels[truth == 255] == 255) > 0.8


def test_option_that_is_none_is_refused(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 1)
    line = refusal(capsys, "segment", tmp_path / "room", "--up", "left-ish")
    assert "left-ish" in line
    assert "towards" in line


def test_pose_beyond_ten_kilometres_is_a_bad_frame(tmp_path: Path) -> None:
    pose = np.eye(4)
    pose[0, 3] = 9_999.0
    assert is_rigid(pose)
    pose[0, 3] = -10_001.0
    assert not is_rigid(pose)
    write_folder(tmp_path, 3)
    lines = (tmp_path / "poses.txt").read_text().splitlines()
    for far in ("60000", "1e15", "1e200"):
        stamp, _, *rest = lines[1].split()
        poses = [lines[0], " ".join([stamp, far, *rest]), lines[2]]
        (tmp_path / "poses.txt").write_text("\n".join(poses))
        dataset = open_dataset(tmp_path)
        assert [pose is None for pose in dataset.poses] == [False, True, False]
        assert "holds no valid pose" in str(dataset[1].problem)
