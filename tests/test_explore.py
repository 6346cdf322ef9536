"""The loop: in which order it asks whom, and that it learns a whole room."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from curiosight.config import PRESETS, Config
from curiosight.datasets import open_dataset
from curiosight.evaluation import HeldOut, MapScores, describe_tests
from curiosight.experiments.components import make_learner, make_teacher
from curiosight.experiments.learning import OffLine
from curiosight.experiments.problems import Problems
from curiosight.experiments.truth import find_truth
from curiosight.explore import Step, explore
from curiosight.explorer import STRATEGIES, Chronological, Iac, make_strategy
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Label, Viewpoint
from curiosight.learner.description import fit_labels
from curiosight.learner.learner import SaliencyLearner
from curiosight.teacher import Teacher, survey_recording
from room_world import RoomRecording, room_world

VIEWS = [Viewpoint(index=10 + number, region=number % 3) for number in range(5)]


class Diary:
    """A world, a learner and a strategy in one, of numbers only, that note who is asked."""

    views = VIEWS

    def __init__(self) -> None:
        self.calls: list[tuple[object, ...]] = []

    def choose(self) -> Viewpoint:
        n_chosen = sum(call[0] == "choose" for call in self.calls)
        self.calls.append(("choose",))
        return VIEWS[n_chosen % len(VIEWS)]

    def move_to(self, viewpoint: Viewpoint) -> float:
        self.calls.append(("move_to", viewpoint.index))
        self.here = viewpoint.index
        return 2.5

    def capture(self) -> str:
        self.calls.append(("capture",))
        return f"frame {self.here}"

    def observe(self, frame: str) -> SimpleNamespace:
        self.calls.append(("observe", frame))
        return SimpleNamespace(
            error=(int(frame.split()[1]) - 10) / 10,
            frame=SimpleNamespace(T_world_camera=None, depth=None, camera=None),
            segmentation=SimpleNamespace(labels=None),
            scores=np.empty(0, np.float32),
            change=SimpleNamespace(has_drifted=False),
        )

    def rescoring(self, observation: SimpleNamespace) -> Callable[[], float | None]:
        return lambda: observation.error

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        assert outcome.again is not None
        self.calls.append(("update", viewpoint.index, outcome.again()))

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        self.calls.append(("progress", region))
        return None if region == 0 else region / 100


def test_every_step_chooses_looks_learns_and_takes_note_in_this_order() -> None:
    diary = Diary()
    steps = list(explore(diary, diary, diary, 3))  # type: ignore[arg-type]
    assert diary.calls == [
        call
        for index, region, error in ((10, 0, 0.0), (11, 1, 0.1), (12, 2, 0.2))
        for call in (
            ("choose",),
            ("move_to", index),
            ("capture",),
            ("observe", f"frame {index}"),
            ("update", index, error),
            ("progress", region),
        )
    ]
    assert [step.index for step in steps] == [0, 1, 2]
    assert [step.viewpoint for step in steps] == VIEWS[:3]
    assert [step.cost for step in steps] == [2.5, 2.5, 2.5]
    assert [step.learning_progress for step in steps] == [None, 0.01, 0.02]


def test_nothing_happens_before_a_step_is_asked_for() -> None:
    diary = Diary()
    steps = explore(diary, diary, diary, 100)  # type: ignore[arg-type]
    assert diary.calls == []
    next(steps)
    assert len(diary.calls) == 6


@pytest.mark.parametrize("n_steps", [0, 1, 7])
def test_it_takes_as_many_steps_as_it_is_told(n_steps: int) -> None:
    diary = Diary()
    assert len(list(explore(diary, diary, diary, n_steps))) == n_steps  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def room() -> RoomRecording:
    return RoomRecording(24)


@pytest.fixture(scope="module")
def unseen() -> RoomRecording:
    """The same room from views in between."""
    return RoomRecording(6, offset_deg=1.3)


@pytest.fixture(scope="module")
def teacher(room: RoomRecording) -> Teacher:
    return Teacher(survey_recording(room.frames[::6]))


def run(
    room: RoomRecording,
    learner: SaliencyLearner,
    n_steps: int,
    *,
    strategy: str = "iac",
    seed: int = 0,
) -> list[Step]:
    with room_world(room) as world:
        rng = np.random.default_rng(seed + 100)
        return list(explore(world, learner, make_strategy(strategy, world.views, rng), n_steps))


def error_of(learner: SaliencyLearner, recording: RoomRecording) -> float:
    error = HeldOut(learner, describe_tests(learner, recording.labelled())).overall_error()
    assert error is not None
    return error


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_room_is_learned_in_25_steps(room, unseen, teacher, preset, seed) -> None:
    """Of 10 seeds of both presets the worst has an error of 0.053 and an AUC of 0.993."""
    learner = make_learner(Config.of_preset(preset), teacher, np.random.default_rng(seed))
    assert error_of(learner, unseen) == 1
    run(room, learner, 25, seed=seed)
    scores = MapScores()
    for frame, truth in zip(unseen.frames, unseen.truths.values(), strict=True):
        scores.add(frame.id, learner.saliency(frame.rgb), truth)
    assert error_of(learner, unseen) < 0.10
    assert scores.ranking().roc_auc > 0.98


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_every_strategy_learns_the_room(room, unseen, teacher, strategy: str) -> None:
    learner = make_learner(Config.of_preset("default"), teacher, np.random.default_rng(0))
    run(room, learner, 25, strategy=strategy)
    assert error_of(learner, unseen) < 0.10


def test_learning_off_line_is_about_as_good(room, unseen, teacher) -> None:
    """Of 10 seeds the two differ by 0.005 at most."""
    config = Config.of_preset("default")
    on_line = make_learner(config, teacher, np.random.default_rng(0))
    run(room, on_line, 60)
    off_line = OffLine(config, room, teacher=teacher)
    n_seen = sum(1 for _ in off_line)
    assert n_seen == off_line.n_looks
    assert error_of(off_line.fit(), unseen) < error_of(on_line, unseen) + 0.02


def test_errors_fall_and_progress_is_measured_where_it_looked_twice(room, teacher) -> None:
    learner = make_learner(Config.of_preset("default"), teacher, np.random.default_rng(0))
    steps = run(room, learner, 40)
    errors = [step.observation.error for step in steps]
    assert errors[0] == 1
    assert np.mean(errors[-10:]) < 0.2
    n_looks: dict[int, int] = {}
    for step in steps:
        region = step.viewpoint.region
        n_looks[region] = n_looks.get(region, 0) + 1
        assert (step.learning_progress is None) == (n_looks[region] < 2)
    assert steps[-1].observation.frame.id == f"view-{steps[-1].viewpoint.index}"


def test_the_same_seed_explores_the_same_way(room, teacher) -> None:
    runs = []
    for seed in (3, 3, 4):
        learner = make_learner(Config.of_preset("default"), teacher, np.random.default_rng(seed))
        steps = run(room, learner, 15, seed=seed)
        runs.append([(step.viewpoint.index, step.observation.error) for step in steps])
    assert runs[0] == runs[1] != runs[2]


def test_bad_frames_and_bare_walls_do_not_stop_it(room, teacher) -> None:
    """Half of the room is unreadable: it goes on, and learns from the other half."""
    spoiled = RoomRecording(8)
    for index in range(4):
        frame = spoiled.frames[index]
        spoiled.frames[index] = type(frame)(
            frame.id, np.zeros_like(frame.rgb), frame.depth, frame.camera, problem="truncated"
        )
    learner = make_learner(Config.of_preset("default"), teacher, np.random.default_rng(0))
    with room_world(spoiled) as world:
        steps = list(explore(world, learner, Iac(world.views, np.random.default_rng(0)), 30))
    is_bad = [step.viewpoint.index < 4 for step in steps]
    assert any(is_bad)
    for step, bad in zip(steps, is_bad, strict=True):
        assert (step.observation.error is None) == bad
    assert learner.forest.n_samples == 700 * is_bad.count(False)


def test_real_table_scenes_are_learned() -> None:
    """Every second scene is learned, the others tested; of 5 seeds the worst errs by 0.193."""
    folder = os.environ.get("CURIOSIGHT_TEST_DATA")
    if folder is None:
        pytest.skip("CURIOSIGHT_TEST_DATA is not set")
    dataset = open_dataset(Path(folder) / "data/osd_learn")
    config = Config.of_preset("default")
    learner = make_learner(config, make_teacher(config, dataset), np.random.default_rng(0))
    tested = find_truth(dataset, range(0, 45, 2), None).labelled_frames(Problems())
    held_out = HeldOut(learner, describe_tests(learner, tested))
    views = [Viewpoint(index, 0) for index in range(1, 45, 2)]
    with room_world(dataset) as world:
        for _ in explore(world, learner, Chronological(views), len(views)):
            pass
    assert held_out.overall_error() < 0.25


def test_looks_are_scored_again_by_the_model_as_it_is(room, teacher) -> None:
    """Their error now is that of a map made now, and asking for it teaches nothing."""
    learner = make_learner(Config.of_preset("default"), teacher, np.random.default_rng(0))
    observation = learner.observe(room[0])
    again = learner.rescoring(observation)
    assert again() < observation.error == 1  # it has learned from that very view
    for index in range(3, 24, 2):
        learner.observe(room[index])
    known = learner.calibration.counts.copy(), learner.n_samples
    description = observation.description
    labels = fit_labels(observation.segmentation.labels, description)
    predicted = learner.predict(description, room.poses[0])[description.row_of_pixel] > 0.5
    is_salient, is_other = labels == Label.SALIENT, labels == Label.NOT_SALIENT
    marked = (predicted & (is_salient | is_other)).sum()
    f1 = 2 * (predicted & is_salient).sum() / (marked + is_salient.sum())
    assert again() == again() == pytest.approx(1 - f1)
    assert (learner.calibration.counts == known[0]).all()
    assert learner.n_samples == known[1]


def test_backward_progress_needs_no_more_than_the_loop(room, teacher) -> None:
    learner = make_learner(Config.of_preset("default"), teacher, np.random.default_rng(0))
    with room_world(room) as world:
        strategy = Iac(world.views, np.random.default_rng(0), progress="backward", n_stay=3)
        steps = list(explore(world, learner, strategy, 16))
    assert {step.viewpoint.region for step in steps[:8]} == {0, 1, 2, 3}
    progress = [strategy.progress_of(region) for region in range(4)]
    assert all(value is not None and abs(value) < 0.5 for value in progress)
    assert max(progress) > 0
