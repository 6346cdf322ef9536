"""Strategies on numbers: which views they choose, and when."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest

from curiosight.explorer.check import check_strategy
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.strategies import (
    STRATEGIES,
    Chronological,
    Iac,
    Random,
    Strategy,
    make_strategy,
)
from curiosight.frame import Viewpoint


def make_views(*sizes: int) -> list[Viewpoint]:
    """Make regions of these sizes; viewpoint 203 is number 3 of region 2."""
    return [
        Viewpoint(index=region * 100 + number, region=region)
        for region, size in enumerate(sizes)
        for number in range(size)
    ]


def run(strategy: Strategy, n_steps: int, error: float | None = 0.5) -> list[Viewpoint]:
    chosen = []
    for _ in range(n_steps):
        chosen.append(strategy.choose())
        strategy.update(chosen[-1], Outcome(error))
    return chosen


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize(
    "factory",
    [
        lambda views, rng: Chronological(views),
        Random,
        lambda views, rng: Random(views, rng, over="regions", n_stay=3),
        lambda views, rng: Random(views, rng, n_stay=10),
        Iac,
        lambda views, rng: Iac(views, rng, n_stay=1, n_warm_up=0, undefined="repeat"),
    ],
    ids=["chronological", "random", "random-regions", "random-stay", "iac", "iac-single"],
)
def test_strategies_keep_the_contract(factory) -> None:
    check_strategy(factory)


class Liar(Chronological):
    """Announces the views in the wrong order."""

    def upcoming(self) -> Sequence[Viewpoint]:
        return list(super().upcoming())[::-1]


class Unseeded(Chronological):
    """Starts somewhere else each time it is made."""

    n_made = 0

    def __init__(self, views: Sequence[Viewpoint]) -> None:
        super().__init__(views)
        Unseeded.n_made += 1
        self._next = Unseeded.n_made


class Nosy(Chronological):
    """Is moved on by being asked for its plans."""

    def upcoming(self) -> Sequence[Viewpoint]:
        self._next = (self._next + 1) % len(self._views)
        return ()


class Careless(Chronological):
    """Takes no views for views."""

    def __init__(self, views: Sequence[Viewpoint]) -> None:
        super().__init__(views or [Viewpoint(0, 0)])


@pytest.mark.parametrize(
    ("broken", "complaint"),
    [
        (Liar, "as announced"),
        (Unseeded, "same choices"),
        (Nosy, "being asked"),
        (Careless, "without views"),
    ],
)
def test_contract_check_finds_what_is_broken(broken: type[Chronological], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        check_strategy(lambda views, rng: broken(views))


def test_chronological_keeps_the_order_and_wraps_around() -> None:
    views = make_views(2, 1)
    assert [view.index for view in run(Chronological(views), 5)] == [0, 1, 100, 0, 1]


def test_random_over_views_is_uniform_over_views() -> None:
    chosen = run(Random(make_views(30, 10), rng()), 4000)
    assert Counter(view.region for view in chosen)[0] == pytest.approx(3000, abs=120)


def test_random_over_regions_is_uniform_over_regions() -> None:
    chosen = run(Random(make_views(30, 10), rng(), over="regions"), 4000)
    assert Counter(view.region for view in chosen)[0] == pytest.approx(2000, abs=150)


def test_random_stays_in_a_region() -> None:
    chosen = run(Random(make_views(30, 10), rng(), n_stay=5), 50)
    stays = [chosen[start : start + 5] for start in range(0, 50, 5)]
    assert all(len({view.region for view in stay}) == 1 for stay in stays)
    assert all(len({view.index for view in stay}) == 5 for stay in stays)


def test_views_in_no_region_are_left_to_strategies_that_ignore_regions() -> None:
    views = [*make_views(3, 3), Viewpoint(999, -1)]
    assert 999 in {view.index for view in run(Random(views, rng()), 100)}
    for strategy in (Random(views, rng(), over="regions"), Iac(views, rng())):
        assert 999 not in {view.index for view in run(strategy, 100)}


def test_iac_warms_up_in_every_region_once() -> None:
    chosen = run(Iac(make_views(5, 5, 5, 5), rng(), n_warm_up=2), 8)
    pairs = [(a.region, b.region) for a, b in zip(chosen[::2], chosen[1::2], strict=True)]
    assert sorted(pairs) == [(region, region) for region in range(4)]
    orders = {
        tuple(view.region for view in run(Iac(make_views(5, 5, 5, 5), rng(seed)), 8))
        for seed in range(10)
    }
    assert len(orders) > 1


def test_iac_stays_without_repeating_a_view() -> None:
    chosen = run(Iac(make_views(20, 20), rng(), n_warm_up=2, n_stay=10), 4 + 50)[4:]
    for start in range(0, 50, 10):
        stay = chosen[start : start + 10]
        assert len({view.region for view in stay}) == 1
        assert len({view.index for view in stay}) == 10


def test_iac_starts_over_in_a_region_smaller_than_a_stay() -> None:
    chosen = run(Iac(make_views(4), rng(), n_warm_up=0, n_stay=10), 10)
    assert sorted(Counter(view.index for view in chosen).values()) == [2, 2, 3, 3]


def test_iac_goes_where_the_error_falls() -> None:
    strategy = Iac(make_views(20, 20, 20, 20), rng(), random_share=0.25)
    visits: Counter[int] = Counter()
    error = 1.0
    for step in range(2000):
        viewpoint = strategy.choose()
        if viewpoint.region == 2:
            error *= 0.999
        strategy.update(viewpoint, Outcome(error if viewpoint.region == 2 else 0.5))
        visits[viewpoint.region] += step >= 8
    assert visits[2] / sum(visits.values()) == pytest.approx(0.75 + 0.25 / 4, abs=0.1)
    assert strategy.progress_of(2) > 0
    assert strategy.progress_of(0) == pytest.approx(0, abs=1e-12)


def test_iac_leaves_a_bare_wall_alone() -> None:
    """A region whose error is never defined must not hold on to the explorer."""
    strategy = Iac(make_views(20, 20), rng(), random_share=0.1)
    error = 1.0
    chosen = []
    for _ in range(1000):
        chosen.append(strategy.choose())
        error *= 0.999
        strategy.update(chosen[-1], Outcome(None if chosen[-1].region == 0 else error))
    share = sum(view.region == 0 for view in chosen[100:]) / 900
    assert share == pytest.approx(0.05, abs=0.05)


def test_errors_decide_nothing_about_what_was_announced() -> None:
    views = make_views(20, 20)
    strategy = Iac(views, rng())
    for error in np.random.default_rng(1).random(60):
        viewpoint = strategy.choose()
        announced = list(strategy.upcoming())
        strategy.update(viewpoint, Outcome(float(error)))
        assert list(strategy.upcoming()) == announced


@pytest.mark.parametrize("name", STRATEGIES)
def test_strategies_are_made_by_name(name: str) -> None:
    strategy = make_strategy(name, make_views(3, 3), rng())
    assert run(strategy, 3)[0].index in {0, 1, 2, 100, 101, 102}
    with pytest.raises(ValueError, match="views: expected"):
        make_strategy(name, [], rng())


def test_unknown_strategy_names_the_nearest() -> None:
    with pytest.raises(ValueError, match=r"chronological, random, .*iac.*mean random\?"):
        make_strategy("randm", make_views(2), rng())
    with pytest.raises(ValueError, match=r"got 'xyzzy'$"):
        make_strategy("xyzzy", make_views(2), rng())


def test_bad_options_are_refused_before_the_first_step() -> None:
    views = make_views(2)
    for options in ({"negative": "drop"}, {"random_share": 2.0}, {"n_stay": 0}, {"theta": 1}):
        with pytest.raises(ValueError, match=f"{next(iter(options))}.*: expected"):
            Iac(views, rng(), **options)
    for options in ({"over": "rooms"}, {"n_stay": 0}):
        with pytest.raises(ValueError, match=f"^{next(iter(options))}: expected"):
            Random(views, rng(), **options)
    with pytest.raises(ValueError, match="none that is in a region"):
        Iac([Viewpoint(0, -1)], rng())
