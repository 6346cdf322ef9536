"""The node's parts that need no ROS: teacher, model, parameters; and where ROS is missing."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from command import refusal
from curiosight.config import Config
from curiosight.errors import DataError
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.ros import packages
from curiosight.experiments.ros.inputs import beside
from curiosight.experiments.ros.learning import Learning
from curiosight.experiments.ros.parameters import PARAMETERS, check
from curiosight.experiments.ros.surveying import SurveyingTeacher, mount_by_poses
from curiosight.frame import Camera, Frame, Label
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.teacher import Segmentation

Capsys = pytest.CaptureFixture[str]
CAMERA = Camera(64, 48, 50, 50, 31.5, 23.5)


def frame(stamp_ns: int | None = None, problem: str | None = None) -> Frame:
    rgb = np.random.default_rng(0).integers(0, 255, (48, 64, 3), np.uint8)
    depth = np.full((48, 64), 2, np.float32)
    return Frame("1", rgb, depth, CAMERA, None, stamp_ns, problem)


class AllSalient:
    def segment(self, frame: Frame) -> Segmentation:
        return Segmentation.of_labels(np.full(frame.rgb.shape[:2], Label.SALIENT, np.uint8))


def test_teacher_looks_round_before_it_teaches_and_once_more() -> None:
    surveyed: list[list[int | None]] = []

    def make(frames: Sequence[Frame]) -> Teaches:
        surveyed.append([one.stamp_ns for one in frames])
        return AllSalient()

    teacher = SurveyingTeacher(make, (3, 4))
    ms = 1_000_000
    for stamp in (0, 100, 300):  # the second is too soon
        told = teacher.segment(frame(stamp * ms))
        assert (told.labels == Label.UNKNOWN).all()
        assert told.problem is not None
        assert told.problem.startswith("looking round: ")
    assert teacher.segment(frame(600 * ms, problem="no depth within 20 ms")).problem is not None
    assert not teacher.is_ready
    assert (teacher.segment(frame(900 * ms)).labels == Label.SALIENT).all()
    assert teacher.is_ready
    for stamp in (1500, 2900, 9000):
        assert teacher.segment(frame(stamp * ms)).problem is None
    assert surveyed == [[0, 300 * ms, 900 * ms], [0, 300 * ms, 900 * ms, 2900 * ms]]


def test_survey_that_fails_begins_anew() -> None:
    surveyed: list[int] = []

    def make(frames: Sequence[Frame]) -> Teaches:
        surveyed.append(len(frames))
        if len(surveyed) < 2:
            raise ValueError("frames: expected a floor")
        return AllSalient()

    teacher = SurveyingTeacher(make, (2, 2))
    seconds = 1_000_000_000
    problems = [teacher.segment(frame(number * seconds)).problem for number in range(4)]
    assert problems[1] == "looking round: frames: expected a floor"
    assert problems[3] is None
    assert surveyed == [2, 2]


@pytest.mark.parametrize(
    ("R", "mount"),
    [
        ([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], "up"),
        ([[0, 0, 1], [1, 0, 0], [0, 1, 0]], "down"),
        ([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], "left"),
        ([[0, 0, 1], [0, -1, 0], [1, 0, 0]], "right"),
        ([[1, 0, 0], [0, -1, 0], [0, 0, -1]], "towards"),
        # Tilted down by 30 degrees.
        ([[0, -0.5, 0.866], [-1, 0, 0], [0, -0.866, -0.5]], "up"),
    ],
)
def test_poses_tell_how_the_camera_is_held(R: list[list[float]], mount: str) -> None:
    pose = np.eye(4)
    pose[:3, :3] = R
    assert mount_by_poses([replace(frame(), T_world_camera=pose), frame()]) == mount
    assert mount_by_poses([frame()]) is None


@pytest.fixture
def learning(tmp_path: Path) -> Learning:
    folder = OutputFolder(tmp_path / "run", "ros", None)
    made = Learning(Config(), folder, is_learning=True)
    made._take(made.learner)
    return made


def test_what_is_replaced_unsaved_is_kept_beside(learning: Learning, tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert learning.replace(None) == "begun anew"
    assert not run.exists()
    learning.n_unsaved = 3
    before = learning.version
    assert learning.replace(None) == f"begun anew; the one before is kept as {run / 'before-1.npz'}"
    assert learning.version == before + 1
    assert learning.n_unsaved == 0
    learning.n_unsaved = 1
    learning.replace(None)
    assert sorted(path.name for path in run.glob("*.npz")) == ["before-1.npz", "before-2.npz"]
    assert SaliencyLearner.load(run / "before-2.npz").n_samples == 0


def test_model_that_cannot_be_read_replaces_none(learning: Learning, tmp_path: Path) -> None:
    learner = learning.learner
    with pytest.raises(DataError):
        learning.replace(tmp_path / "none.npz")
    assert learning.learner is learner
    saved = learning.save()
    assert learning.replace(saved) == f"loaded {saved}"
    assert learning.learner is not learner


def test_teacher_without_depth_is_refused(tmp_path: Path) -> None:
    config = Config()
    config = replace(config, teacher=replace(config.teacher, source="masks:x"))
    with pytest.raises(ValueError, match="teacher: expected depth for a node, got 'masks:x'"):
        Learning(config, OutputFolder(tmp_path / "run", "ros", None), is_learning=True)


def test_defaults_are_inside_their_ranges_and_described() -> None:
    for one in PARAMETERS:
        assert one.description
        if isinstance(one.default, int | float) and not isinstance(one.default, bool):
            assert one.least is not None
            assert one.most is not None
            assert one.least <= one.default <= one.most
    check({one.name: one.default for one in PARAMETERS}, is_configured=False)


@pytest.mark.parametrize(
    ("values", "is_configured", "said"),
    [
        ({"strategy": "iacc"}, False, "did you mean iac?"),
        ({"reliability": "best"}, False, "reliability: expected best_effort or reliable"),
        ({"color_topic": "/a"}, True, "color_topic: can be changed while the node is not"),
    ],
)
def test_values_that_cannot_be_are_refused(
    values: dict[str, str], is_configured: bool, said: str
) -> None:
    with pytest.raises(ValueError, match=said.replace("?", r"\?")):
        check(values, is_configured=is_configured)


def test_values_that_may_change_are_taken_while_it_runs() -> None:
    check({"strategy": "iac", "threshold": 0.7, "model": "x"}, is_configured=True)


@pytest.mark.parametrize(
    ("topic", "info"),
    [
        ("/camera/color/image_raw", "/camera/color/camera_info"),
        ("/camera/color/image_raw/compressed", "/camera/color/camera_info"),
        ("/depth/image/compressedDepth", "/depth/camera_info"),
    ],
)
def test_camera_info_lies_beside_the_image(topic: str, info: str) -> None:
    assert beside(topic) == info


def test_missing_ros_is_told_in_one_line(
    capsys: Capsys, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    line = refusal(capsys, "ros", "--learn", "--out", tmp_path / "run")
    assert "rclpy cannot be imported" in line
    assert "source /opt/ros/jazzy/setup.bash" in line
    assert not (tmp_path / "run").exists()


def test_words_that_are_not_for_ros_are_refused(capsys: Capsys, tmp_path: Path) -> None:
    line = refusal(capsys, "ros", "--learn", "--out", tmp_path / "run", "image:=/a")
    assert "expected options, then --ros-args, got 'image:=/a'" in line
    assert "--lern" in refusal(capsys, "ros", "--lern", "--ros-args", "-p", "learn:=true")


def test_missing_messages_are_told_with_their_package(monkeypatch: pytest.MonkeyPatch) -> None:
    def imported(name: str) -> object:
        if name == "vision_msgs.msg":
            raise ImportError("No module named 'vision_msgs'")
        return object()

    monkeypatch.setattr(packages, "import_module", imported)
    with pytest.raises(ValueError, match=r"apt install ros-\$ROS_DISTRO-vision-msgs"):
        packages.import_ros()


def test_missing_navigation_is_no_mistake(monkeypatch: pytest.MonkeyPatch) -> None:
    def imported(name: str) -> object:
        if name in packages.USEFUL:
            raise ImportError
        return name

    monkeypatch.setattr(packages, "import_module", imported)
    ros = packages.import_ros()
    assert ros.nav2_msgs_action is None
    assert ros.rclpy_qos == "rclpy.qos"
