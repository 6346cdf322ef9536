"""Choose where to look next: in order, at random, or by learning progress (sec. II-B)."""

from __future__ import annotations

import difflib
from collections import deque
from collections.abc import Sequence
from typing import Literal, Protocol

import numpy as np

from curiosight.explorer.ground import Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.progress import (
    Floats,
    Negative,
    ProgressMeter,
    Undefined,
    choice_probabilities,
)
from curiosight.explorer.progress_rate import ProgressRate
from curiosight.explorer.sweep import Sweep
from curiosight.frame import Viewpoint

Over = Literal["views", "regions"]

STRATEGIES = ("chronological", "random", "sweep", "iac", "progress-rate")

_N_AHEAD = 4  # views decided in advance, so that their frames can be decoded meanwhile


class Strategy(Protocol):
    """Decide where to look, told after each look how wrong the prediction was."""

    def choose(self) -> Viewpoint:
        """Return the next viewpoint."""
        ...

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Take note of what came of looking there."""
        ...

    def upcoming(self) -> Sequence[Viewpoint]:
        """Return the next few viewpoints where they are already decided; changes nothing."""
        ...

    def progress_of(self, region: int) -> float | None:
        """Return the region's learning progress; None = not known, or not measured."""
        ...


class Chronological:
    """Look in the order of the recording; after the last view start over."""

    def __init__(self, views: Sequence[Viewpoint]) -> None:
        self._views = _at_least_one(views)
        self._next = 0

    def choose(self) -> Viewpoint:
        viewpoint = self._views[self._next]
        self._next = (self._next + 1) % len(self._views)
        return viewpoint

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Do nothing: the order is fixed."""

    def upcoming(self) -> Sequence[Viewpoint]:
        n_views = len(self._views)
        return [self._views[(self._next + step) % n_views] for step in range(_N_AHEAD)]

    def progress_of(self, region: int) -> float | None:
        return None


class Random:
    """Look anywhere, whatever was learned.

    over: "views" = each view is as likely; "regions" = each region is as likely, and each
        view inside it.
    n_stay: views to look at in a region before the next draw, which then draws the region of
        a view. Unless `over` is "views" and this is 1, views in no region are left out.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        over: Over = "views",
        n_stay: int = 1,
    ) -> None:
        if over not in ("views", "regions"):
            raise ValueError(f"over: expected views or regions, got {over!r}")
        if n_stay < 1:
            raise ValueError(f"n_stay: expected 1 or more, got {n_stay}")
        self._rng = rng
        self._n_stay = n_stay
        if over == "views" and n_stay == 1:
            self._pools = [list(_at_least_one(views))]
        else:
            self._pools = list(_by_region(views).values())
        weights = np.array([len(pool) if over == "views" else 1.0 for pool in self._pools])
        self._chances = weights / weights.sum()
        self._plan: deque[Viewpoint] = deque()

    def choose(self) -> Viewpoint:
        while len(self._plan) <= _N_AHEAD:
            pool = self._pools[self._rng.choice(len(self._pools), p=self._chances)]
            self._plan.extend(_draw_stay(pool, self._n_stay, self._rng))
        return self._plan.popleft()

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Do nothing: chance does not learn."""

    def upcoming(self) -> Sequence[Viewpoint]:
        return list(self._plan)[:_N_AHEAD]

    def progress_of(self, region: int) -> float | None:
        return None


class Iac:
    """Stay in a region for a while, then go where the error falls fastest (sec. II-B).

    Every region is visited once in random order, `n_warm_up` views each; then stays of
    `n_stay` views, each region drawn by `choice_probabilities`. The views of a stay differ
    from each other as far as the region has that many. Views in no region are left out.

    theta, smoothing, min_errors, undefined: see `ProgressMeter`; random_share, exponent,
    negative: see `choice_probabilities`.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        n_stay: int = 10,
        n_warm_up: int = 2,
        random_share: float = 0.25,
        theta: int = 15,
        smoothing: int = 1,
        min_errors: int = 2,
        undefined: Undefined = "repeat",
        negative: Negative = "clip",
        exponent: float = 1.0,
    ) -> None:
        if n_stay < 1 or n_warm_up < 0:
            raise ValueError(
                f"n_stay, n_warm_up: expected 1 and 0 or more, got {n_stay}, {n_warm_up}"
            )
        self._pools = _by_region(views)
        self._rng = rng
        self._n_stay = n_stay
        self._random_share = random_share
        self._negative = negative
        self._exponent = exponent
        self._meter = ProgressMeter(
            theta=theta, smoothing=smoothing, min_errors=min_errors, undefined=undefined
        )
        self._probabilities()  # refuses bad options now rather than after the warm-up
        self._plan: deque[Viewpoint] = deque()
        for region in rng.permutation(list(self._pools)):
            self._plan.extend(_draw_stay(self._pools[region], n_warm_up, rng))

    def choose(self) -> Viewpoint:
        if not self._plan:
            region = self._rng.choice(list(self._pools), p=self._probabilities())
            self._plan.extend(_draw_stay(self._pools[region], self._n_stay, self._rng))
        return self._plan.popleft()

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        self._meter.add(viewpoint.region, outcome.error)

    def upcoming(self) -> Sequence[Viewpoint]:
        return list(self._plan)[:_N_AHEAD]

    def progress_of(self, region: int) -> float | None:
        return self._meter.progress(region)

    def _probabilities(self) -> Floats:
        return choice_probabilities(
            [self._meter.progress(region) for region in self._pools],
            random_share=self._random_share,
            exponent=self._exponent,
            negative=self._negative,
        )


def make_strategy(
    name: str,
    views: Sequence[Viewpoint],
    rng: np.random.Generator,
    *,
    ways: Ways | None = None,
    random_over: Over = "views",
    random_n_stay: int = 1,
    n_stay: int = 10,
    n_warm_up: int = 2,
    random_share: float = 0.25,
    theta: int = 15,
    smoothing: int = 1,
    min_errors: int = 2,
    undefined: Undefined = "repeat",
    negative: Negative = "clip",
    exponent: float = 1.0,
) -> Strategy:
    """Make the strategy of that name (one of `STRATEGIES`).

    random_over, random_n_stay: see `Random`; all that follow: see `Iac`. Raises ValueError
    for an unknown name, and for views that the strategy cannot choose from.
    """
    if name == "chronological":
        return Chronological(views)
    if name == "random":
        return Random(views, rng, over=random_over, n_stay=random_n_stay)
    if name == "iac":
        return Iac(
            views,
            rng,
            n_stay=n_stay,
            n_warm_up=n_warm_up,
            random_share=random_share,
            theta=theta,
            smoothing=smoothing,
            min_errors=min_errors,
            undefined=undefined,
            negative=negative,
            exponent=exponent,
        )
    if name == "progress-rate":
        return ProgressRate(views, rng, ways=ways)
    base, _, stay = name.partition(":")
    if base == "sweep":
        return Sweep(views, rng, ways=ways, n_stay=_read_stay(stay))
    nearest = difflib.get_close_matches(name.lower(), STRATEGIES, n=1, cutoff=0.4)
    hint = f"; did you mean {nearest[0]}?" if nearest else ""
    raise ValueError(f"strategy: expected {', '.join(STRATEGIES)}, got {name!r}{hint}")


def _read_stay(text: str) -> int | None:
    """Read how long a sweep stays: "" = 10 looks, "all" = as many as a region has views."""
    if text in ("", "all"):
        return 10 if not text else None
    if not text.isdecimal():
        raise ValueError(f"strategy: expected sweep, sweep:N or sweep:all, got {text!r} for N")
    return int(text)


def _draw_stay(
    pool: Sequence[Viewpoint], n_views: int, rng: np.random.Generator
) -> list[Viewpoint]:
    """Draw views without replacement; where the pool is exhausted, start over."""
    n_rounds = -(-n_views // len(pool))
    order = [index for _ in range(n_rounds) for index in rng.permutation(len(pool))]
    return [pool[index] for index in order[:n_views]]


def _by_region(views: Sequence[Viewpoint]) -> dict[int, list[Viewpoint]]:
    """Group views by region, in the order of the regions' numbers."""
    pools: dict[int, list[Viewpoint]] = {}
    for view in sorted(_at_least_one(views), key=lambda view: view.region):
        if view.region >= 0:
            pools.setdefault(view.region, []).append(view)
    if not pools:
        raise ValueError("views: expected views in regions, got none that is in a region")
    return pools


def _at_least_one(views: Sequence[Viewpoint]) -> Sequence[Viewpoint]:
    if not views:
        raise ValueError("views: expected at least one view, got none")
    return views
