"""Regions that live: split where progress differs, joined where not, more with more views."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import linregress

from command import succeed
from curiosight.explorer import living as module
from curiosight.explorer.check import check_strategy
from curiosight.explorer.decision import Explains
from curiosight.explorer.ground import Floats, Ground
from curiosight.explorer.living import EVERY, N_LEAST, Living, difference, living_regions
from curiosight.explorer.outcome import Outcome, Seen
from curiosight.explorer.strategies import make_strategy
from curiosight.explorer.strategy import Strategy
from curiosight.frame import Viewpoint
from recordings import write_folder
from test_regions import stand

N_HALF = 6


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def two_rooms(*, is_turned: bool = False) -> list[Viewpoint]:
    """Return two rooms of two halves: ten metres apart, or one place and two headings."""
    return [
        Viewpoint(
            room * 100 + half * 10 + number,
            room,
            stand(20 * room + 0.1 * number, 0 if is_turned else 3 * half, 180 * half + number),
        )
        for room in range(2)
        for half in range(2)
        for number in range(N_HALF)
    ]


def ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
    places = np.array([goal.T_world_camera[:2, 3] for goal in goals])
    seconds: Floats = 2 * np.linalg.norm(places - start.T_world_camera[:2, 3], axis=1)
    return seconds


def half_of(viewpoint: Viewpoint) -> tuple[int, int]:
    return viewpoint.region, viewpoint.index % 100 // 10


def looks_at(
    ground: Ground, n_rounds: int, slopes: dict[tuple[int, int], float], noise: float = 0.03
) -> list[tuple[int, float]]:
    """Return looks at every half in turn; the errors of each fall by its slope a look."""
    chance = rng(3)
    first = {half_of(view): number for number, view in reversed([*enumerate(ground.views)])}
    return [
        (first[half] + time % N_HALF, 0.8 - slope * time + chance.normal(0, noise))
        for time in range(n_rounds)
        for half, slope in slopes.items()
    ]


ONE_FLAT = {(0, 0): 0.02, (0, 1): 0.0, (1, 0): 0.02, (1, 1): 0.02}


@pytest.mark.parametrize("is_turned", [False, True])
def test_regions_are_split_where_progress_differs(is_turned: bool) -> None:
    views = two_rooms(is_turned=is_turned)
    ground = Ground(views, ways)
    parts = living_regions(ground, looks_at(ground, 20, ONE_FLAT))
    expected = [0] * N_HALF + [1] * N_HALF + [2] * 2 * N_HALF
    same = np.equal.outer(parts, parts)
    np.testing.assert_array_equal(same, np.equal.outer(expected, expected))


def test_regions_stay_whole_where_it_does_not_or_nothing_can_be_told() -> None:
    ground = Ground(two_rooms(), ways)
    whole = [0] * 2 * N_HALF + [1] * 2 * N_HALF
    alike = dict.fromkeys(ONE_FLAT, 0.02)
    for looks in ([], looks_at(ground, N_LEAST - 1, ONE_FLAT), looks_at(ground, 30, alike)):
        assert living_regions(ground, looks).tolist() == whole
    noisy = looks_at(ground, 12, ONE_FLAT, noise=0.3)
    assert living_regions(ground, noisy).tolist() == whole
    single = Ground([Viewpoint(0, 0, None)])
    assert living_regions(single, [(0, 0.5)] * 40).tolist() == [0]


def test_parts_are_joined_again_when_their_progress_is_alike() -> None:
    ground = Ground(two_rooms(), ways)
    looks = looks_at(ground, 30, ONE_FLAT)
    parts = living_regions(ground, looks)
    assert parts.max() == 2
    # A little later less can be told, but enough to leave it so.
    looks += looks_at(ground, 12, dict.fromkeys(ONE_FLAT, 0.0))
    assert living_regions(ground, looks, parts).max() == 2
    assert living_regions(ground, looks).max() == 1
    looks += looks_at(ground, 30, dict.fromkeys(ONE_FLAT, 0.0))
    assert living_regions(ground, looks, parts).max() == 1


def test_difference_is_that_of_two_lines_in_standard_errors() -> None:
    is_first = rng(1).random(50) < 0.4
    errors = rng(2).random(50) - 0.02 * np.arange(50) * is_first
    lines = [linregress(np.flatnonzero(kind), errors[kind]) for kind in (is_first, ~is_first)]
    expected = abs(lines[0].slope - lines[1].slope) / np.hypot(lines[0].stderr, lines[1].stderr)
    assert difference(errors, is_first) == pytest.approx(expected)
    assert difference(errors[:20], is_first[:20]) == 0  # too few of one
    assert difference(np.full(50, 0.5), is_first) == pytest.approx(0)


def test_halves_that_are_looked_at_less_often_do_not_learn_slower() -> None:
    is_first = np.arange(60) % 4 == 0
    assert difference(0.9 - 0.01 * np.arange(60), is_first) == pytest.approx(0, abs=1e-9)


def living(name: str, views: Sequence[Viewpoint], seed: int = 0) -> Living:
    chance = rng(seed)
    return Living(
        lambda: views, lambda divided: make_strategy(name, divided, chance, ways=ways), ways=ways
    )


def run(strategy: Strategy, slopes: dict[tuple[int, int], float], n: int) -> list[Viewpoint]:
    """Look; errors fall by the look in each half, in the same noise for all."""
    chance, n_looks, chosen = rng(9), dict.fromkeys(slopes, 0), []
    for _ in range(n):
        view = strategy.choose()
        half = half_of(view)
        error = max(0.05, 0.9 - slopes[half] * n_looks[half]) + chance.normal(0, 0.02)
        strategy.update(view, Outcome(error, seconds=0.0))
        n_looks[half] += 1
        chosen.append(view)
    return chosen


@pytest.mark.parametrize(
    "name", ["iac", "rl-iac", "sweep:3", "coverage", "random", "chronological", "error"]
)
def test_until_a_region_is_split_all_is_as_without(name: str) -> None:
    alike = dict.fromkeys(ONE_FLAT, 0.01)
    views = two_rooms()
    alone = run(make_strategy(name, views, rng(5), ways=ways), alike, 60)
    strategy = living(name, views, seed=5)
    assert run(strategy, alike, 60) == alone
    assert strategy.parts.max() == 1


@pytest.mark.parametrize("name", ["iac", "sweep:3", "coverage", "rl-iac", "random"])
def test_it_keeps_the_contract_of_strategies(name: str) -> None:
    check_strategy(
        lambda views, chance: Living(
            lambda: views, lambda divided: make_strategy(name, divided, chance)
        )
    )


def test_a_half_that_teaches_nothing_is_left() -> None:
    shares = []
    for seed in range(6):
        views = two_rooms()
        strategy = living("iac", views, seed)
        chosen = run(strategy, ONE_FLAT, 200)
        alone = run(make_strategy("iac", views, rng(seed), ways=ways), ONE_FLAT, 200)
        shares.append(
            [np.mean([half_of(view) == (0, 1) for view in each[100:]]) for each in (chosen, alone)]
        )
        assert {view.region for view in chosen} == {0, 1}  # outside they keep their regions
        assert isinstance(strategy, Explains)
        decision = strategy.reasons()
        assert decision is not None
        assert [one.region for one in decision.candidates] == [0, 1]
        assert strategy.progress_of(0) is not None
        assert strategy.progress_of(7) is None
    with_parts, alone_share = np.mean(shares, axis=0)
    assert with_parts < alone_share


def test_strategies_know_what_others_looked_at() -> None:
    """One that is made anew goes on: what was seen is not new, nor visited first."""
    views = two_rooms()
    for name in ("coverage", "sweep:all"):
        strategy = make_strategy(name, views, rng(), ways=ways)
        for view in views[: N_HALF + 2]:
            strategy.update(view, Outcome(0.5, seconds=1.0))
        seen = {strategy.choose() for _ in range(len(views) - N_HALF - 2)}
        assert {view.index for view in seen} == {view.index for view in views[N_HALF + 2 :]}
    strategy = make_strategy("iac", views, rng(), ways=ways, n_warm_up=2)
    for view in (views[0], views[0]):  # the same twice is two looks
        strategy.update(view, Outcome(0.5))
    assert [strategy.choose().region for _ in range(2)] == [1, 1]
    assert strategy.reasons() is None  # type: ignore[attr-defined]


def test_looks_of_weeks_take_no_more_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "N_IN_FULL", 5)
    monkeypatch.setattr(module, "N_TOLD", 12)
    views = two_rooms()
    strategy = living("iac", views)
    for number in range(40):
        seen = Seen(np.full((1, 3), number, np.float32), np.zeros(1, np.uint8))
        outcome = Outcome(0.5, seen=seen, again=lambda: 0.4)
        strategy.update(views[20 if number == 30 else number % 4], outcome)
    told = [outcome for _, outcome in strategy._told]
    assert len(told) == 12
    assert [outcome.again is not None for outcome in told] == [False] * 7 + [True] * 5
    # Of what was not looked at again it is kept what was seen.
    assert [outcome.seen is not None for outcome in told[:7]] == [n == 30 for n in range(28, 35)]


def test_views_that_a_world_finds_are_taken_in() -> None:
    views = two_rooms()
    known = views[: 2 * N_HALF]
    chance = rng(0)
    strategy = Living(
        lambda: known, lambda divided: make_strategy("coverage", divided, chance, ways=ways)
    )
    chosen = []
    for look in range(len(views)):
        if look == N_HALF:  # the door is seen
            known = views
        chosen.append(strategy.choose())
        strategy.update(chosen[-1], Outcome(0.5, seconds=1.0))
    assert sorted(view.index for view in chosen) == [view.index for view in views]
    assert {view.region for view in chosen[:N_HALF]} == {0}
    assert len(strategy.parts) == len(views)
    assert len(views) > EVERY


def test_explore_with_living_regions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_folder(tmp_path / "room", 8)
    for regions in ("growing", "auto"):
        options = ("--regions", regions, "--steps", 12, "--out", tmp_path / regions)
        said = succeed(capsys, "explore", tmp_path / "room", *options).err
        assert f"({regions})" in said
    steps = [(tmp_path / regions / "steps.csv").read_bytes() for regions in ("growing", "auto")]
    assert steps[0] == steps[1]
