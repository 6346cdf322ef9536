"""Advice: where to go and why, of a strategy that others drive for, or that drives."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import partial

import numpy as np
import pytest

from curiosight.explorer import Strategy, make_strategy
from curiosight.explorer.decision import Decision
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Viewpoint
from curiosight.robot.advice import BEGUN, NOTHING_KNOWN, PINNED, Advice
from curiosight.robot.routes import Drive
from room import poses_around

NAMES = ("left", "middle", "right")
VIEWS = [Viewpoint(k, k // 4, pose) for k, pose in enumerate(poses_around(12))]


class Planned:
    """A strategy that goes through views in turn, and says that it does."""

    def __init__(self, views: Sequence[Viewpoint]) -> None:
        self.views = views
        self.n_chosen = 0
        self.told: list[int] = []
        self.decision: Decision | None = None

    def choose(self) -> Viewpoint:
        view = self.views[self.n_chosen * 5 % len(self.views)]
        self.n_chosen += 1
        region = view.region
        self.decision = Decision.among(
            [region], [None], [1.0], [float("nan")], chosen=region, text="in turn"
        )
        return view

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        self.told.append(viewpoint.index)

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        return None

    def reasons(self) -> Decision | None:
        return self.decision


def named(name: str, views: tuple[Viewpoint, ...]) -> Strategy:
    return make_strategy(name, views, np.random.default_rng(0))


def test_advice_is_given_after_every_look_of_somebody_elses_drive() -> None:
    advice = Advice(Planned, VIEWS, NAMES)
    assert (advice.goal, advice.why()) == (None, None)
    for index in (3, 4, 11):
        advice.look(index, Outcome(0.5), seconds=float(index))
    assert isinstance(advice.strategy, Planned)
    assert advice.strategy.told == [3, 4, 11]
    assert advice.goal == 2
    assert advice.why() == {
        "chosen": 2,
        "text": "in turn",
        "candidates": [{"region": 2, "expected_gain": None, "seconds": 1.0, "score": None}],
    }


def test_driving_goes_on_to_the_goal_before_the_strategy_hears_of_it() -> None:
    drive = Drive(len(VIEWS))
    advice = Advice(Planned, VIEWS, NAMES, drive=drive)
    assert isinstance(advice.strategy, Planned)
    seen = []
    for _ in range(14):
        index = next(drive)
        seen.append(index)
        advice.look(index, Outcome(0.5), seconds=0.0)
    # From view 0 to 0, 5, 10, 3: the first look is its own, the others are those it went to.
    assert seen == [0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 9, 8]
    assert advice.strategy.told == [0, 0, 5, 10]
    assert (drive.goal, advice.goal) == (3, 0)
    assert advice.n_looks == 14


def test_regions_tell_their_last_errors_and_whether_they_fall() -> None:
    advice = Advice(Planned, VIEWS, NAMES)
    for number in range(20):
        advice.look(0, Outcome(1 - 0.02 * number), seconds=float(number))
    advice.look(5, Outcome(None), seconds=20.0)
    left, middle, right = advice.regions()
    assert left == {
        "id": 0,
        "name": "left",
        "n_looks": 20,
        "error": pytest.approx(1 - 0.02 * 12),  # of the last 15, in the middle
        "progress": pytest.approx(0.02),
    }
    assert middle == {"id": 1, "name": "middle", "n_looks": 1, "error": None, "progress": None}
    assert right["n_looks"] == 0
    curves = advice.curves()
    assert curves["error"][0] == (0.0, 1.0)
    assert [len(region["error"]) for region in curves["regions"]] == [20, 0, 0]
    assert curves["regions"][0]["progress"][-1] == (19.0, 0.02)


def test_pinned_region_is_the_goal_until_it_is_unpinned() -> None:
    drive = Drive(len(VIEWS))
    advice = Advice(Planned, VIEWS, NAMES, drive=drive)
    advice.look(0, Outcome(0.5), seconds=0.0)
    advice.pin(2)
    why = advice.why()
    assert why is not None
    assert (advice.goal, why["chosen"], why["text"], drive.goal) == (2, 2, PINNED, 8)
    goals = set()
    for _ in range(8):
        assert drive.goal is not None
        advice.look(drive.goal, Outcome(0.5), seconds=0.0)
        goals.add(drive.goal)
    assert goals == {8, 9, 10, 11}
    advice.pin(None)
    advice.look(drive.goal, Outcome(0.5), seconds=0.0)
    assert advice.pinned is None
    with pytest.raises(ValueError, match="region: expected one of 0, 1, 2, got 7"):
        advice.pin(7)


def test_advice_that_is_taken_up_goes_on_as_the_other() -> None:
    """By its state, and then by looks that are told again, with what was pinned meanwhile."""
    drives = Drive(len(VIEWS)), Drive(len(VIEWS))
    one = Advice(partial(named, "iac"), VIEWS, NAMES, drive=drives[0])
    other = Advice(partial(named, "iac"), VIEWS, NAMES, drive=drives[1])
    again: list[tuple[int, Outcome, float, int | None]] = []
    for number in range(90):
        if number in (40, 60, 70):
            one.pin({40: 1, 60: 2, 70: None}[number])
        index = next(drives[0])
        outcome = Outcome(1 / (1 + number % 7))
        one.look(index, outcome, float(number))
        if number == 30:
            other.take_up(copy.deepcopy(one.state()))
        if number > 30:
            again.append((index, outcome, float(number), one.pinned_then))
    assert drives[1].goal is not None
    for index, outcome, seconds, pinned in again:
        other.look_again(index, outcome, seconds, pinned)
    assert other.regions() == one.regions()
    assert other.curves() == one.curves()
    target, there = one.target(), other.target()
    assert target is not None
    assert there is not None
    assert target.index == there.index
    assert drives[1].goal == drives[0].goal
    assert {pinned for *_, pinned in again} == {None, 1, 2}
    for advice in (one, other):
        advice.pin(None)
    assert [one.strategy.choose().index for _ in range(20)] == [
        other.strategy.choose().index for _ in range(20)
    ]


@pytest.mark.parametrize("name", ["iac", "progress-rate", "random", "chronological", "sweep"])
def test_text_is_never_empty(name: str) -> None:
    advice = Advice(partial(named, name), VIEWS, NAMES)
    texts = set()
    for number in range(60):
        advice.look(number % 12, Outcome(0.5 / (1 + number)), seconds=float(number))
        why = advice.why()
        assert why is not None
        assert why["text"]
        assert why["chosen"] == advice.goal
        texts.add(why["text"])
    if name == "random":  # does not tell
        assert texts <= {BEGUN, NOTHING_KNOWN}


def test_strategy_chooses_from_few_of_many_views_and_hears_of_the_nearest() -> None:
    advice = Advice(Planned, VIEWS, NAMES, n_views=4)
    assert [view.index for view in advice.views] == [0, 4, 7, 8, 11]  # each region has one
    advice.look(2, Outcome(0.5), seconds=0.0)
    advice.look(9, Outcome(0.5), seconds=0.0)
    assert isinstance(advice.strategy, Planned)
    assert advice.strategy.told == [0, 8]


def test_views_in_no_region_are_looked_at_and_no_more() -> None:
    views = [Viewpoint(0, -1), *(Viewpoint(k, 0) for k in (1, 2))]
    advice = Advice(Planned, views, NAMES)
    advice.look(0, Outcome(0.5), seconds=0.0)
    advice.look(None, Outcome(0.5), seconds=0.0)
    assert advice.regions()[0]["n_looks"] == 0
    with pytest.raises(ValueError, match="views: expected at least one in a region, got none"):
        Advice(Planned, [Viewpoint(0, -1)], NAMES)
