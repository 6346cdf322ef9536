"""Check that a strategy keeps the contract; for ours and for a user's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from curiosight.explorer.decision import Decision, Explains
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.strategy import Strategy
from curiosight.frame import Viewpoint

StrategyFactory = Callable[[Sequence[Viewpoint], np.random.Generator], Strategy]

_N_REGIONS, _N_VIEWS_EACH, _N_STEPS = 3, 7, 120


def check_strategy(factory: StrategyFactory) -> None:
    """Raise ValueError where a strategy breaks the contract of `Strategy`.

    It must choose among its views, keep to what `upcoming` announced, not be changed by being
    asked, do the same again with the same seed, take None for an error, and refuse to be made
    without views. factory: makes a fresh strategy from views and a random generator.
    """
    views = [
        Viewpoint(index=region * 100 + number, region=region)
        for region in range(_N_REGIONS)
        for number in range(_N_VIEWS_EACH)
    ]
    asked = _choices(factory, views, ask=True)
    if asked != _choices(factory, views, ask=True):
        raise ValueError("strategy: expected the same choices from the same seed")
    if asked != _choices(factory, views, ask=False):
        raise ValueError("strategy: expected choices that do not depend on being asked about")
    try:
        factory([], np.random.default_rng(0))
    except ValueError:
        return
    raise ValueError("strategy: expected a ValueError when made without views")


def _choices(factory: StrategyFactory, views: Sequence[Viewpoint], *, ask: bool) -> list[int]:
    """Run a strategy on made-up errors; return the indices it chose.

    ask: also call `upcoming`, `progress_of` and `reasons` at every step, and check what they say.
    """
    rng = np.random.default_rng(0)
    strategy = factory(views, np.random.default_rng(1))
    known = {(view.index, view.region) for view in views}
    choices: list[int] = []
    announced: list[int] = []
    for _ in range(_N_STEPS):
        viewpoint = strategy.choose()
        if (viewpoint.index, viewpoint.region) not in known:
            raise ValueError(f"choose: expected one of the strategy's views, got {viewpoint}")
        if announced and viewpoint.index != announced[0]:
            raise ValueError(f"choose: expected {announced[0]} as announced, got {viewpoint.index}")
        choices.append(viewpoint.index)
        if ask:
            announced = _announced(strategy, announced[1:])
        # Every fifth error is undefined; region 1 improves.
        error = 1 / (1 + len(choices)) if viewpoint.region == 1 else float(rng.random())
        strategy.update(viewpoint, Outcome(None if len(choices) % 5 == 0 else error))
        if ask:
            _check_progress(strategy.progress_of(viewpoint.region))
            if isinstance(strategy, Explains):
                _check_reasons(strategy.reasons())
    return choices


def _announced(strategy: Strategy, earlier: list[int]) -> list[int]:
    """Return the announced indices, having checked that earlier announcements still hold."""
    upcoming = [viewpoint.index for viewpoint in strategy.upcoming()]
    if upcoming[: len(earlier)] != earlier:
        raise ValueError(f"upcoming: expected {earlier} to stay announced, got {upcoming}")
    return upcoming


def _check_progress(progress: float | None) -> None:
    if progress is not None and not np.isfinite(progress):
        raise ValueError(f"progress_of: expected None or a finite number, got {progress}")


def _check_reasons(decision: Decision | None) -> None:
    if decision is None:
        return
    if not isinstance(decision, Decision):
        raise ValueError(f"reasons: expected a Decision or None, got {decision!r}")
    regions = [candidate.region for candidate in decision.candidates]
    if decision.chosen not in regions:
        raise ValueError(f"reasons: expected one of {regions} as chosen, got {decision.chosen}")
    numbers = [
        number
        for one in decision.candidates
        for number in (one.expected_gain or 0.0, one.seconds, one.score)
    ]
    if not np.isfinite(numbers).all():
        raise ValueError(f"reasons: expected finite numbers, got {decision.candidates}")
