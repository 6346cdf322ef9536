"""The overall error, kept up to date tree by tree, against plain recomputation."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.config import PRESETS, Config
from curiosight.evaluation import HeldOut, describe_tests
from curiosight.evaluation.held_out import GRID
from curiosight.experiments.components import make_learner
from curiosight.frame import Frame, Label
from curiosight.learner.description import Labels, fit_labels
from curiosight.learner.experts import COMMON, Change
from curiosight.learner.learner import SaliencyLearner
from curiosight.metrics import f1_error
from curiosight.teacher import Teacher, survey_recording
from room_world import RoomRecording


@pytest.fixture(scope="module")
def room() -> RoomRecording:
    return RoomRecording(8)


def make_room_learner(room: RoomRecording, preset: str, seed: int = 0) -> SaliencyLearner:
    teacher = Teacher(survey_recording(room.frames[::4]))
    return make_learner(Config.of_preset(preset), teacher, np.random.default_rng(seed))


def plain_error(learner: SaliencyLearner, room: RoomRecording, *, grid: int = 1) -> float:
    """Average 1 - F1 over the frames' maps, each made anew, on every `grid`-th pixel."""
    errors = []
    for frame, truth in room.labelled():
        description = learner.describe(frame.rgb)
        saliency = learner.predict(description, frame.T_world_camera)[description.row_of_pixel]
        labels = fit_labels(truth, description)
        errors.append(f1_error(labels[::grid, ::grid], saliency[::grid, ::grid]))
    return float(np.mean(errors))


def hold_out(learner: SaliencyLearner, frames: list[tuple[Frame, Labels]]) -> HeldOut:
    return HeldOut(learner, describe_tests(learner, frames))


@pytest.mark.parametrize("preset", PRESETS)
def test_asking_only_regrown_trees_gives_what_asking_all_gives(room, preset: str) -> None:
    learner = make_room_learner(room, preset)
    held_out = hold_out(learner, room.labelled())
    grid = {"superpixel": 1, "pixel": GRID}[learner.describer.rows_per]
    assert held_out.overall_error() == 1
    for frame in room.frames:
        change = learner.observe(frame).change
        error = held_out.overall_error(change)
        assert error == pytest.approx(plain_error(learner, room, grid=grid), abs=1e-12)
        assert error == hold_out(learner, room.labelled()).overall_error()


def test_a_grid_of_pixels_stands_for_all_of_them(room) -> None:
    learner = make_room_learner(room, "paper")
    for frame in room.frames[:4]:
        learner.observe(frame)
    error = hold_out(learner, room.labelled()).overall_error()
    assert error == pytest.approx(plain_error(learner, room), abs=0.02)


def test_only_the_regrown_trees_are_asked(room) -> None:
    learner = make_room_learner(room, "default")
    held_out = hold_out(learner, room.labelled())
    asked: list[int] = []
    votes = learner.forest.votes
    learner.forest.votes = lambda rows, trees=None: (  # type: ignore[method-assign]
        asked.append(30 if trees is None else len(trees)) or votes(rows, trees)
    )
    changes = []
    for frame in room.frames[:3]:
        changes.append(learner.observe(frame).change)
        held_out.overall_error(changes[-1])
    held_out.overall_error(Change({}))
    held_out.overall_error()
    assert asked == [30, *(change.n_regrown for change in changes[1:]), 30]


def test_frames_without_anything_salient_are_left_out(room) -> None:
    learner = make_room_learner(room, "default")
    learner.observe(room.frames[0])
    frame, truth = room.labelled()[0]
    bare = np.where(truth == Label.SALIENT, Label.UNKNOWN, truth).astype(np.uint8)
    unlabelled = np.full_like(truth, Label.UNKNOWN)
    alone = hold_out(learner, [(frame, truth)])
    among = hold_out(learner, [(frame, bare), (frame, truth), (frame, unlabelled)])
    assert among.n_frames == alone.n_frames == 1
    assert among.overall_error() == alone.overall_error()


@pytest.mark.parametrize("n_bare", [0, 2])
def test_without_any_frame_there_is_no_error(room, n_bare: int) -> None:
    learner = make_room_learner(room, "default")
    learner.observe(room.frames[0])
    frame = room.frames[0]
    held_out = hold_out(learner, [(frame, np.zeros(frame.rgb.shape[:2], np.uint8))] * n_bare)
    assert held_out.n_frames == 0
    assert held_out.overall_error() is None
    assert held_out.overall_error(Change({COMMON: (0, 1)})) is None


def test_pixels_that_are_neither_do_not_count(room) -> None:
    learner = make_room_learner(room, "default")
    for frame in room.frames[:3]:
        learner.observe(frame)
    frame, truth = room.labelled()[0]
    description = learner.describe(frame.rgb)
    labels = fit_labels(truth, description)
    is_found = learner.predict(description, frame.T_world_camera)[description.row_of_pixel] > 0.5
    is_wrong = is_found != (labels == Label.SALIENT)
    assert hold_out(learner, [(frame, labels)]).overall_error() > 0
    labels[is_wrong] = Label.UNKNOWN
    assert hold_out(learner, [(frame, labels)]).overall_error() == 0
