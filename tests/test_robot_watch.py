"""A watch: maps go on while it learns, switches do what they say, and a failure ends all of it."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count

import cv2
import numpy as np
import pytest

from curiosight.frame import Frame, Viewpoint
from curiosight.learner.features import count_features
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.robot.advice import Advice
from curiosight.robot.feed import Shot
from curiosight.robot.plan import Plan
from curiosight.robot.shown import PICTURES, Shown
from curiosight.robot.state import KEYS, Preparing
from curiosight.robot.told import Told, Verdict
from curiosight.robot.watch import Look, Mapped, Watch
from curiosight.teacher import Segmentation
from room import kinect, poses_around, render
from test_robot_advice import NAMES, Planned

N_VIEWS = 6
CAMERA = kinect(80, 60)
POSES = poses_around(N_VIEWS)
TRUTHS = {}
FRAMES = []
for number, pose in enumerate(POSES):
    view = render(CAMERA, pose)
    FRAMES.append(Frame(str(number), view.rgb, view.depth, CAMERA, pose))
    TRUTHS[str(number)] = view.ground_truth
VIEWS = [Viewpoint(number, number // 2, pose) for number, pose in enumerate(POSES)]


class Knowing:
    """A teacher that knows the truth; from `n_good` frames on it fails."""

    def __init__(self, n_good: int = 1_000_000) -> None:
        self.n_good = n_good

    def segment(self, frame: Frame) -> Segmentation:
        if self.n_good <= 0:
            raise OSError("the teacher has gone")
        self.n_good -= 1
        return Segmentation.of_labels(TRUTHS[frame.id])


class Given:
    """A feed that gives one frame after the other, as soon as it is asked."""

    n_missed = 0

    def __init__(self) -> None:
        self.numbers = count()
        self.is_closed = False

    def newest(self, timeout_s: float) -> Shot:
        time.sleep(0.002)
        number = next(self.numbers) % N_VIEWS
        return Shot(FRAMES[number], number, time.monotonic())

    def close(self) -> None:
        self.is_closed = True


def small_learner() -> SaliencyLearner:
    n_features = count_features("colours", "rgb", contrast=False)
    forest = Forest(n_features=n_features, n_trees=4, n_regrown=1, max_samples=2000)
    return SaliencyLearner(
        None, forest, rows_per="superpixel", superpixels="cells", n_superpixels=100, n_pixels=100
    )


@contextmanager
def watching(
    teacher: Knowing | None,
    *,
    is_learning: bool = True,
    on_look: Callable[[Look], None] | None = None,
) -> Iterator[tuple[Watch, Shown]]:
    advice = Advice(Planned, VIEWS, NAMES)
    watch = Watch(
        small_learner(), Given(), teacher, is_learning=is_learning, advice=advice, on_look=on_look
    )
    shown = Shown(watch, Plan(VIEWS, NAMES), title="the room", save=lambda: "a file")
    watch.start()
    try:
        yield watch, shown
    finally:
        watch.stop()


def wait_for(condition: Callable[[], object]) -> None:
    until = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.005)


def test_it_maps_and_learns_and_tells() -> None:
    looks: list[Look] = []
    with watching(Knowing(), on_look=looks.append) as (watch, shown):
        before = shown.state()
        wait_for(lambda: watch.lessons.n >= 12)
        state = shown.state()
        live = shown.live()
    assert tuple(before) == tuple(state) == KEYS
    assert state["state"] == "running"
    assert state["map_hz"] > 0 < state["learn_hz"]
    assert 0 <= state["map_age_s"] < 10
    assert 0 <= state["model_age_s"] < 10
    assert [region["id"] for region in state["regions"]] == [0, 1, 2]
    assert state["goal"] == state["why"]["chosen"]
    assert state["why"]["text"] == "in turn"
    assert set(state["why"]["candidates"][0]) == {"region", "expected_gain", "seconds", "score"}
    assert watch.is_over
    assert watch.failure is None
    assert [look.number for look in looks] == list(range(len(looks)))
    assert looks[0].error == 1.0  # nothing was known
    assert looks[-1].error is not None
    assert looks[-1].error < 0.6
    assert watch.n_dropped == watch.maps.n - watch.looks.n
    json.dumps([state, live], allow_nan=False)
    assert live["robot"] is not None
    assert live["n_learned"] == live["n_looks"]


def test_what_it_makes_of_frames_is_what_a_learner_makes_of_them() -> None:
    """The teacher in another thread changes nothing: the same looks give the same model."""
    looks: list[Look] = []
    with watching(Knowing(), on_look=looks.append) as (watch, _):
        wait_for(lambda: watch.lessons.n >= 8)
    alone = small_learner()
    alone.teacher = Knowing()
    for look in looks:
        assert alone.observe(look.verdict.shot.frame).error == look.error
    rgb = FRAMES[0].rgb
    assert np.array_equal(alone.saliency(rgb), watch.learner.saliency(rgb))


def test_frozen_model_stays_as_it_is_while_maps_and_looks_go_on() -> None:
    with watching(Knowing()) as (watch, shown):
        wait_for(lambda: watch.lessons.n >= 4)
        assert shown.command("freeze", True) == "the model stays as it is"
        wait_for(lambda: watch.looks.n > watch.lessons.n + 1)
        n_learned, samples = watch.lessons.n, watch.learner.n_samples
        n_maps, n_looks = watch.maps.n, watch.looks.n
        wait_for(lambda: watch.maps.n > n_maps + 5 and watch.looks.n > n_looks + 3)
        assert (watch.lessons.n, watch.learner.n_samples) == (n_learned, samples)
        assert shown.state()["state"] == "frozen"
        shown.command("freeze", False)
        wait_for(lambda: watch.lessons.n > n_learned)


def test_paused_watch_stands_still_and_goes_on() -> None:
    with watching(Knowing()) as (watch, shown):
        wait_for(lambda: watch.lessons.n >= 2)
        assert shown.command("pause", True) == "paused"
        time.sleep(0.3)  # what was under way ends
        before = watch.maps.n, watch.looks.n
        time.sleep(0.2)
        assert (watch.maps.n, watch.looks.n) == before
        assert shown.state()["state"] == "paused"
        assert shown.state()["map_age_s"] > 0.2
        shown.command("pause", False)
        wait_for(lambda: watch.maps.n > before[0] and watch.looks.n > before[1])


def test_without_learning_frames_are_compared_alone() -> None:
    with watching(Knowing(), is_learning=False) as (watch, shown):
        wait_for(lambda: watch.looks.n >= 5)
        state = shown.state()
    assert (watch.lessons.n, watch.learner.n_samples) == (0, 0)
    assert state["learn_hz"] == 0
    assert state["model_age_s"] is None
    assert state["regions"][0]["error"] == 1.0


def test_without_a_teacher_there_are_maps() -> None:
    with watching(None, is_learning=False) as (watch, shown):
        wait_for(lambda: watch.maps.n >= 5)
        assert shown.state()["why"] is None
        assert shown.picture("teacher") is None
    assert watch.looks.n == 0
    with pytest.raises(ValueError, match="teacher: expected one to learn from, got None"):
        Watch(small_learner(), Given(), None)


def test_failure_in_any_thread_ends_all_and_is_told() -> None:
    with watching(Knowing(n_good=3)) as (watch, shown):
        wait_for(lambda: watch.is_over)
        assert shown.state()["state"] == "ended"
    assert isinstance(watch.failure, OSError)
    assert watch.lessons.n <= 3


def test_pictures_are_of_the_newest_frame() -> None:
    with watching(Knowing()) as (watch, shown):
        wait_for(lambda: watch.lessons.n >= 2)
        jpegs = {name: shown.picture(name) for name in PICTURES}
        assert shown.picture("passwords") is None
    for name, jpeg in jpegs.items():
        assert jpeg is not None, name
        image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert image.shape[1] / image.shape[0] == pytest.approx(4 / 3, abs=0.02)
    assert len(set(jpegs.values())) == 4


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("pause", 1, "pause: expected true or false, got 1"),
        ("freeze", None, "freeze: expected true or false, got None"),
        ("pin", "x", "pin: expected the id of a region or null, got 'x'"),
        ("pin", True, "pin: expected the id of a region or null, got True"),
        ("pin", 9, "region: expected one of 0, 1, 2, got 9"),
        ("quit", None, "command: expected pause, freeze, pin or save, got 'quit'"),
    ],
)
def test_commands_that_cannot_be_are_refused(name: str, value: object, message: str) -> None:
    with watching(None, is_learning=False) as (_, shown), pytest.raises(ValueError, match=message):
        shown.command(name, value)


def test_pin_and_save() -> None:
    with watching(None, is_learning=False) as (watch, shown):
        assert shown.command("pin", 1) == "pinned region 1"
        assert shown.state()["goal"] == 1
        assert shown.state()["why"]["text"] == "pinned by hand"
        assert shown.command("pin", None) == "unpinned"
        assert shown.command("save", None) == "saved to a file"
        unsaved = Shown(watch, Plan(VIEWS, NAMES))
        with pytest.raises(ValueError, match="save: expected a watch that learns"):
            unsaved.command("save", None)


def test_teacher_repeats_what_was_said_of_this_frame_only() -> None:
    told, shot = Told(), Shot(FRAMES[0], 0, 0.0)
    verdict = Verdict(shot, Knowing().segment(FRAMES[0]))
    with told.says(verdict):
        assert told.segment(FRAMES[0]) is verdict.segmentation
        with pytest.raises(ValueError, match="frame: expected the one that was labelled before"):
            told.segment(FRAMES[1])
    with pytest.raises(ValueError, match="frame: expected the one that was labelled before"):
        told.segment(FRAMES[0])


def test_plan_shows_regions_walls_and_the_robot() -> None:
    wall = np.array([[0.0, 0], [4, 0], [4, 3]])
    plan = Plan(VIEWS, NAMES, up=(0, 0, 1), outlines=[wall])
    content = plan.content()
    assert content["outlines"] == [wall.tolist()]
    assert [region["name"] for region in content["regions"]] == list(NAMES)
    assert [len(region["points"]) for region in content["regions"]] == [2, 2, 2]
    x, y, heading = plan.robot(3) or (0.0, 0.0, 0.0)
    assert (x, y) == pytest.approx(POSES[3][:2, 3], abs=1e-3)
    ahead = POSES[3][:2, 2]
    assert heading == pytest.approx(np.arctan2(ahead[1], ahead[0]), abs=1e-3)
    assert plan.robot(None) is None
    assert Plan([Viewpoint(0, 0)], NAMES).robot(0) is None


def test_nothing_is_known_while_it_is_prepared() -> None:
    preparing = Preparing("drawing")
    assert preparing.state() == {**dict.fromkeys(KEYS), "state": "preparing"}
    assert preparing.live() == {"note": "drawing"}
    assert preparing.picture("colour") is None
    with pytest.raises(ValueError, match="pause: expected a watch that has begun"):
        preparing.command("pause", True)


def test_maps_are_told_and_frames_settled_before_they_are_taught_with() -> None:
    maps: list[Mapped] = []
    looks: list[Look] = []

    class Bare(Given):
        """Gives colour alone."""

        def newest(self, timeout_s: float) -> Shot:
            shot = super().newest(timeout_s)
            frame = Frame(shot.frame.id, shot.frame.rgb)
            return Shot(frame, shot.index, shot.taken_at)

    def settle(shot: Shot) -> Shot:
        assert shot.frame.depth is None
        return Shot(FRAMES[int(shot.frame.id)], shot.index, shot.taken_at)

    watch = Watch(
        small_learner(), Bare(), Knowing(), on_look=looks.append, on_map=maps.append, settle=settle
    )
    watch.start()
    try:
        wait_for(lambda: len(looks) > 2 or watch.failure)
    finally:
        watch.stop()
    assert watch.failure is None
    assert all(one.shot.frame.depth is None for one in maps)
    assert all(look.verdict.shot.frame is FRAMES[look.verdict.shot.index or 0] for look in looks)
    assert all(look.outcome.error == look.error for look in looks)
    assert looks[0].outcome.seen is not None
