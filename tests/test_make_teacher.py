"""Who labels the frames: settings choose one teacher, and every command hears it."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import files, refusal, succeed
from curiosight import open_dataset
from curiosight.config import PRESETS, Config
from curiosight.experiments.components import make_learner, make_teacher, survey_dataset
from curiosight.experiments.timing import Timing
from curiosight.teacher import PaperTeacher, Teacher, TemporalTeacher
from curiosight.teacher.given import MaskTeacher
from recordings import truncate, write_folder

Capsys = pytest.CaptureFixture[str]
TEACHER_OF = {"paper": PaperTeacher, "default": Teacher}


def named(config: Config, source: str) -> Config:
    return replace(config, teacher=replace(config.teacher, source=source))


@pytest.mark.parametrize("preset", PRESETS)
def test_preset_chooses_the_teacher(preset: str, room: Path) -> None:
    config, dataset = Config.of_preset(preset), open_dataset(room)
    teacher = make_teacher(config, dataset)
    assert type(teacher) is TEACHER_OF[preset]
    assert type(Timing(config, dataset, stages=("segment",)).teacher) is TEACHER_OF[preset]
    other = named(config, f"masks:{room / 'ground_truth'}")
    assert isinstance(make_teacher(other, dataset), MaskTeacher)
    heard = make_learner(config, teacher).teacher
    assert isinstance(heard, TemporalTeacher) == (preset == "default")


@pytest.mark.parametrize("scene", ["floor", "table"])
def test_paper_teacher_gets_the_scene_and_the_settings(scene: str, room: Path) -> None:
    paper = Config.of_preset("paper")
    settings = replace(paper.paper_segmentation, seed=7)
    chosen = replace(paper.teacher, scene=scene)  # type: ignore[arg-type]
    teacher = make_teacher(
        replace(paper, teacher=chosen, paper_segmentation=settings), open_dataset(room)
    )
    assert isinstance(teacher, PaperTeacher)
    assert (teacher.scene, teacher.settings.seed) == (scene, 7)


def test_teacher_that_remembers_has_seen_the_survey(room: Path) -> None:
    config, dataset = Config.of_preset("default"), open_dataset(room)
    survey = survey_dataset(config, dataset)
    for given in (None, survey):
        teacher = make_teacher(config, dataset, given, temporal=True)
        assert isinstance(teacher, TemporalTeacher)
        voxels = teacher.votes.voxels_of(
            dataset[0].depth, dataset[0].camera, dataset[0].T_world_camera, stride=2
        )
        assert teacher.votes.balance(voxels.ravel()).any()
    assert teacher.survey is survey


def test_recording_that_masks_label_needs_no_usable_depth(tmp_path: Path) -> None:
    write_folder(tmp_path / "room", 2)
    for path in (tmp_path / "room/depth").iterdir():
        truncate(path)
    config = named(Config.of_preset("paper"), f"masks:{tmp_path / 'room/ground_truth'}")
    assert isinstance(make_teacher(config, open_dataset(tmp_path / "room")), MaskTeacher)


@pytest.mark.parametrize("command", ["segment", "score-teacher", "propose"])
def test_paper_teacher_has_no_memory(
    command: str, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ("--temporal", "--preset", "paper", "--out", tmp_path / "out")
    line = refusal(capsys, command, room, *options)
    assert line == "curiosight: temporal: expected the pipeline 'default', got 'paper'"
    assert not files(tmp_path / "out")


def test_segment_writes_what_the_paper_teacher_says(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    succeed(capsys, "segment", room, "--preset", "paper", "--out", tmp_path / "out")
    for frame in open_dataset(room):
        written = cv2.imread(str(tmp_path / f"out/labels/{frame.id}.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(written, PaperTeacher("floor").segment(frame).labels)


def test_evaluate_hears_the_teacher_that_is_named(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    shutil.copytree(room, tmp_path / "room")
    shutil.move(tmp_path / "room/ground_truth", tmp_path / "right")
    (tmp_path / "wrong").mkdir()
    for path in (tmp_path / "right").iterdir():
        inverted = 255 - cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        assert cv2.imwrite(str(tmp_path / "wrong" / path.name), inverted)
    areas = {}
    for masks in ("right", "wrong"):
        options = ("--teacher", f"masks:{tmp_path / masks}", "--out", tmp_path / f"{masks}-out")
        printed = succeed(capsys, "evaluate", model, tmp_path / "room", *options, "--json").out
        metrics = json.loads(printed)
        assert metrics["truth"] == "teacher"
        areas[masks] = metrics["pooled"]["all"]["roc_auc"]
    assert areas["right"] > 0.9
    assert areas["wrong"] == pytest.approx(1 - areas["right"])


def test_evaluate_of_colour_alone_hears_masks(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    shutil.copytree(room / "rgb", tmp_path / "pictures")
    options = ("--teacher", f"masks:{room / 'ground_truth'}", "--out", tmp_path / "out", "--json")
    printed = succeed(capsys, "evaluate", model, tmp_path / "pictures", *options).out
    assert json.loads(printed)["pooled"]["all"]["roc_auc"] > 0.9
