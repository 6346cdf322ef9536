"""Strategies that decide between regions: what draws them, what the ways cost, why they went."""

from __future__ import annotations

import itertools
import time
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
import pytest

from curiosight.explorer.check import check_strategy
from curiosight.explorer.decision import Decision, Explains
from curiosight.explorer.ground import Floats, Ground
from curiosight.explorer.motivations import (
    N_KEPT,
    N_SMOOTH,
    BackwardProgress,
    Error,
    Forgetting,
    Motivation,
    Novelty,
    Progress,
    ProgressAndForgetting,
    Uncertainty,
)
from curiosight.explorer.oracle import Oracle
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.progress import ProgressMeter
from curiosight.explorer.rl_iac import Planned, solve
from curiosight.explorer.sampled_q import SampledQ
from curiosight.explorer.strategies import ORACLE, STRATEGIES, Strategy, make_strategy
from curiosight.explorer.tally import Tally
from curiosight.frame import Viewpoint
from test_strategies import make_views

DECIDING = (
    "sweep", "iac", "rl-iac", "rl-iac:sampled", "error", "novelty", "uncertainty",
    "progress-forgetting",
)  # fmt: skip


def ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
    """Return seconds in a house where views are 1 s apart and rooms 100 s."""
    return np.array([float(abs(goal.index - start.index)) for goal in goals])


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def run(strategy: Strategy, errors: Sequence[float], n_steps: int) -> list[Viewpoint]:
    """Look; each region has one error, and is as uncertain as it is wrong."""
    chosen = []
    for _ in range(n_steps):
        chosen.append(strategy.choose())
        error = errors[chosen[-1].region]
        strategy.update(chosen[-1], Outcome(error, uncertainty=error))
    return chosen


@pytest.mark.parametrize("way", [None, ways], ids=["no-ways", "ways"])
@pytest.mark.parametrize("name", [*STRATEGIES, "sweep:3", "sweep:all"])
def test_all_that_have_a_name_keep_the_contract(name: str, way: object) -> None:
    check_strategy(lambda views, rng: make_strategy(name, views, rng, ways=way))  # type: ignore[arg-type]


def test_sampled_keeps_the_contract() -> None:
    check_strategy(lambda views, rng: make_strategy("rl-iac:sampled", views, rng, ways=ways))


def test_coverage_sees_every_view_once_by_short_ways() -> None:
    strategy = make_strategy("coverage", make_views(5, 5), rng(3), ways=ways)
    chosen = [view.index for view in run(strategy, [0.5, 0.5], 20)]
    assert sorted(chosen[:10]) == sorted(chosen[10:]) == [0, 1, 2, 3, 4, 100, 101, 102, 103, 104]
    # One region after the other, and inside no way is longer than there and back.
    assert sum(abs(a - b) > 10 for a, b in pairwise(chosen[:10])) == 1


@pytest.mark.parametrize("name", ["error", "uncertainty"])
def test_error_and_uncertainty_draw_in_proportion(name: str) -> None:
    strategy = make_strategy(name, make_views(20, 20, 20), rng(), n_stay=1)
    visits = Counter(view.region for view in run(strategy, [0.1, 0.3, 0.6], 3000)[100:])
    for region, error in enumerate([0.1, 0.3, 0.6]):
        assert visits[region] / 2900 == pytest.approx(0.75 * error + 0.25 / 3, abs=0.03)


def test_novelty_evens_out_the_looks() -> None:
    strategy = make_strategy("novelty", make_views(9, 9, 9), rng(), random_share=0.0, n_stay=1)
    visits = Counter(view.region for view in run(strategy, [0.5] * 3, 90))
    assert set(visits.values()) == {30}


def test_forgetting_grows_with_the_looks_elsewhere() -> None:
    motivation = Forgetting()
    assert motivation.interest(4) is None
    motivation.add(4, Outcome(0.5))
    assert motivation.interest(4) == 0
    for _ in range(10):
        motivation.add(5, Outcome(0.5))
    assert motivation.interest(4) == pytest.approx(1 - 0.96**10)


def test_progress_and_forgetting_draw_half_and_half() -> None:
    motivation = ProgressAndForgetting(Progress(ProgressMeter(theta=5)), theta=5)
    motivation.add(4, Outcome(0.9))
    assert motivation.interest(4) is None  # one error has no slope
    for error in (0.7, 0.5, 0.3, 0.1):
        motivation.add(4, Outcome(error))
    falling = 2 / np.pi * np.arctan(5 * 0.2)
    assert motivation.interest(4) == pytest.approx(0.5 * falling)
    for error in (0.1, 0.3, 0.5, 0.7):  # a growing error draws as much
        motivation.add(7, Outcome(error))
    assert motivation.interest(7) == pytest.approx(0.5 * falling)
    assert motivation.interest(4) == pytest.approx(0.5 * falling + 0.5 * (1 - 0.96**4))
    assert motivation.interest(5) is None


def test_progress_and_forgetting_comes_back_where_nothing_falls_any_more() -> None:
    strategy = make_strategy("progress-forgetting", make_views(9, 9, 9), rng(), random_share=0)
    regions = []
    for _ in range(90):
        view = strategy.choose()
        strategy.update(view, Outcome(0.5))
        regions.append(view.region)
    stays = regions[6::10]  # after two looks in each
    assert all(a != b for a, b in itertools.pairwise(stays))
    assert set(stays) == {0, 1, 2}
    with pytest.raises(ValueError, match="forgetting_share: expected 0 to 1, got 2"):
        ProgressAndForgetting(Progress(ProgressMeter()), forgetting_share=2)


@pytest.mark.parametrize(
    ("motivation", "outcome"),
    [(Error(), lambda value: Outcome(value)), (Uncertainty(), lambda v: Outcome(0.1, 0.0, v))],
)
def test_smoothed_motivations_forget_old_looks(motivation: Motivation, outcome) -> None:
    assert motivation.interest(2) is None
    for value in [1.0] * 50 + [0.5] * (N_SMOOTH - 10) + [0.2] * 10:
        motivation.add(2, outcome(value))
    assert motivation.interest(2) == pytest.approx((20 * 0.5 + 10 * 0.2) / N_SMOOTH)
    assert motivation.interest(3) is None
    for _ in range(3):
        motivation.add(3, outcome(None))
    assert motivation.interest(3) == 0


def test_novelty_counts_regions_never_looked_at() -> None:
    motivation = Novelty([0, 7, -1])
    motivation.add(0, Outcome(0.5))
    assert (motivation.interest(0), motivation.interest(7)) == (0, 1)


def test_backward_progress_is_of_the_same_frames_whatever_was_looked_at() -> None:
    """Region 0 gets better though all looks are in region 1, whose views differ in difficulty."""
    now = {"easier": 0.9}
    motivation = BackwardProgress(rng(), theta=5)
    motivation.add(0, Outcome(0.9, again=lambda: now["easier"]))
    assert motivation.interest(0) is None
    for look in range(8):
        now["easier"] -= 0.1
        motivation.add(1, Outcome(0.5, again=lambda hard=look % 2: 0.4 + 0.2 * hard))
    assert motivation.interest(0) == pytest.approx(0.1)
    assert motivation.interest(1) == pytest.approx(0, abs=1e-12)


def test_backward_progress_keeps_few_frames_and_asks_no_others() -> None:
    asked: list[int] = []
    motivation = BackwardProgress(rng(), theta=5)
    for look in range(50):
        asked.clear()
        motivation.add(0, Outcome(0.5, again=lambda look=look: asked.append(look) or 0.5))
    assert len(asked) == len(set(asked)) == N_KEPT
    assert min(asked) < 25 < max(asked)
    for _ in range(5):
        motivation.add(3, Outcome(None, again=lambda: None))
    assert motivation.interest(3) == 0  # a bare wall


def test_iac_goes_by_backward_progress() -> None:
    strategy = make_strategy("iac", make_views(20, 20), rng(), progress="backward", n_stay=1)
    visits: Counter[int] = Counter()
    # What is heard at once says nothing: noise without end in region 1.
    again = (lambda: 1 / (1 + visits.total() / 50)), (lambda: 0.5)
    for look in range(400):
        view = strategy.choose()
        visits[view.region] += 1
        error = 0.5 if view.region == 0 else float(look % 7) / 7
        strategy.update(view, Outcome(error, again=again[view.region]))
    assert visits[0] / 400 == pytest.approx(0.875, abs=0.05)
    assert strategy.progress_of(0) > 0
    with pytest.raises(ValueError, match="progress: expected forward or backward, got 'both'"):
        make_strategy("iac", make_views(2), rng(), progress="both")  # type: ignore[arg-type]


def plain_values(gains: Floats, fades: Floats, ways: Floats) -> Floats:
    """Solve by value iteration, without a thought for time."""
    values = np.zeros(len(gains))
    for _ in range(20_000):
        values = (ways * (gains + fades * values)).max(axis=1)
    return values


@pytest.mark.parametrize("seed", range(5))
def test_values_are_those_of_plain_value_iteration(seed: int) -> None:
    draws = rng(seed)
    gains, fades = draws.random(7), draws.uniform(0.5, 0.995, 7)
    away = draws.uniform(0.3, 1, (7, 7))
    np.fill_diagonal(away, 1)
    np.testing.assert_allclose(solve(gains, fades, away), plain_values(gains, fades, away), 1e-9)
    assert solve(np.zeros(3), np.full(3, 0.9), np.ones((3, 3))).tolist() == [0, 0, 0]


def decide(planned: Planned | SampledQ, interests: Sequence[float | None], n_views: int = 4):
    """Decide from view 0 of region 0, of regions that are 100 s apart."""
    tally = Tally(Ground(make_views(*[n_views] * len(interests)), ways))
    tally.go_to(0)
    return planned(interests, tally)


def test_planned_goes_a_long_way_only_for_much() -> None:
    planned = Planned(rng(), random_share=0.0, discount=0.99)
    assert decide(planned, [0.1, 0.2]).place == 0
    assert decide(planned, [0.1, 0.5]).place == 1
    assert decide(Planned(rng(), random_share=0.0, discount=0.999), [0.1, 0.2]).place == 1
    # Of two as good the nearer; what is not known is as good as the best.
    assert decide(planned, [0.0, 0.2, 0.2]).place == 1
    assert decide(planned, [0.0, None, 0.2]).place == 1
    choice = decide(planned, [0.1, 0.5])
    assert choice.scores.argmax() == 1
    assert choice.scores[0] < choice.scores[1]


def test_planned_is_random_where_nothing_draws() -> None:
    planned = Planned(rng(), random_share=0.0)
    assert {decide(planned, [0.0, 0.0, -0.1]).place for _ in range(50)} == {0, 1, 2}


def test_sampled_q_goes_to_a_neighbour_of_worth() -> None:
    sampled = SampledQ(rng(), jump_share=0.0, random_share=0.0, n_seconds=900.0)
    choices = [decide(sampled, [0.0, 0.1, 1.0, 0.1, 0.0, 0.0]) for _ in range(10)]
    assert {choice.place for choice in choices} == {2}
    jumps = SampledQ(rng(), jump_share=1.0)
    assert {decide(jumps, [0.0, 1.0, 0.0]).place for _ in range(60)} == {0, 1, 2}
    assert decide(SampledQ(rng()), [0.5]).place == 0


def test_ground_knows_the_ways_between_regions() -> None:
    ground = Ground(make_views(3, 1, 3), ways)
    assert ground.between[0].tolist() == [0, 99, 199]  # from 0, 1, 2 to 100 and 200
    assert ground.inside.tolist() == [1, 0, 1]
    assert not Ground(make_views(3, 2)).between.any()


def test_a_decision_among_100_regions_takes_5_ms() -> None:
    views = [Viewpoint(100 * region + n, region) for region, n in product(range(100), range(2))]
    draws = rng(1)
    tally = Tally(Ground(views, lambda a, to: 0.1 * np.abs([b.index - a.index for b in to])))
    planned = Planned(rng(), random_share=0.0)
    assert tally.ground.between.shape == (100, 100)
    seconds = []
    for number in range(0, 200, 10):
        tally.go_to(number)
        tally.seconds_to_regions()  # a way once measured is known
        interests = list(draws.random(100))
        start = time.process_time()
        planned(interests, tally)
        seconds.append(time.process_time() - start)
    assert np.median(seconds) <= 0.005


def test_oracle_goes_where_the_error_falls_most_per_second() -> None:
    tried: list[list[int]] = []

    def trial(views: Sequence[Viewpoint]) -> float:
        tried.append([view.index for view in views])
        return [0.01, 0.5, 0.6][views[0].region]

    strategy = Oracle(make_views(6, 6, 6), rng(), trial=trial, ways=ways, n_stay=3)
    first = strategy.choose()
    assert strategy.reasons() is None
    stay = [strategy.choose().index for _ in range(3)]
    assert [len(views) for views in tried] == [3, 3, 3]
    assert stay in tried
    decision = strategy.reasons()
    assert decision is not None
    near = sorted(tried, key=lambda views: abs(views[0] - first.index))
    assert first.index not in near[0]
    by_rate = max(decision.candidates, key=lambda one: one.score)
    assert (by_rate.region, stay[0] // 100) == (decision.chosen, decision.chosen)
    assert {one.expected_gain for one in decision.candidates} == {0.01, 0.5, 0.6}


def test_oracle_needs_a_trial() -> None:
    with pytest.raises(ValueError, match="oracle, which only comparisons"):
        make_strategy(ORACLE, make_views(2), rng())
    made = make_strategy(ORACLE, make_views(2, 2), rng(), trial=lambda views: 0.1)
    assert isinstance(made, Oracle)


@pytest.mark.parametrize("name", DECIDING)
def test_decisions_leave_their_reasons(name: str) -> None:
    strategy = make_strategy(name, make_views(9, 9, 9, 9), rng(), ways=ways, n_stay=4)
    assert isinstance(strategy, Explains)
    assert strategy.reasons() is None
    decisions: list[Decision] = []
    for _ in range(60):
        view, before = strategy.choose(), decisions[-1] if decisions else None
        decision = strategy.reasons()
        if decision is not None and decision is not before:
            assert decision.chosen == view.region
            assert decision.chosen in {candidate.region for candidate in decision.candidates}
            assert decision.text
            decisions.append(decision)
        strategy.update(view, Outcome(0.5, uncertainty=0.2))
    assert len(decisions) > 2
    far = [one.seconds for one in decisions[-1].candidates if one.region != decisions[-1].chosen]
    assert max(far, default=100) > 80


def test_unknown_options_of_a_name_are_refused() -> None:
    for name, message in (
        ("rl-iac:exact", "rl-iac or rl-iac:sampled, got 'rl-iac:exact'"),
        ("sweep:0", "sweep:N or sweep:all, got '0' for N"),
        ("coverag", "did you mean coverage?"),
        ("oracl", "did you mean oracle?"),
    ):
        with pytest.raises(ValueError, match=message.replace("?", r"\?")):
            make_strategy(name, make_views(2), rng())
