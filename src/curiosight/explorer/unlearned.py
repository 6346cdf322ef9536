"""Strategies that learn nothing: in order, and at random."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Literal

import numpy as np

from curiosight.errors.arguments import check_whole
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.strategy import MAX_STAY, N_AHEAD, at_least_one, by_region, draw_stay
from curiosight.frame import Viewpoint

Over = Literal["views", "regions"]


class Chronological:
    """Look in the order of the recording; after the last view start over."""

    def __init__(self, views: Sequence[Viewpoint]) -> None:
        self._views = at_least_one(views)
        self._next = 0

    def choose(self) -> Viewpoint:
        viewpoint = self._views[self._next]
        self._next = (self._next + 1) % len(self._views)
        return viewpoint

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Do nothing: the order is fixed."""

    def upcoming(self) -> Sequence[Viewpoint]:
        n_views = len(self._views)
        return [self._views[(self._next + step) % n_views] for step in range(N_AHEAD)]

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
        check_whole("n_stay", n_stay, 1, MAX_STAY)
        self._rng = rng
        self._n_stay = n_stay
        if over == "views" and n_stay == 1:
            self._pools = [list(at_least_one(views))]
        else:
            self._pools = list(by_region(views).values())
        weights = np.array([len(pool) if over == "views" else 1.0 for pool in self._pools])
        self._chances = weights / weights.sum()
        self._plan: deque[Viewpoint] = deque()

    def choose(self) -> Viewpoint:
        while len(self._plan) <= N_AHEAD:
            pool = self._pools[self._rng.choice(len(self._pools), p=self._chances)]
            self._plan.extend(draw_stay(pool, self._n_stay, self._rng))
        return self._plan.popleft()

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Do nothing: chance does not learn."""

    def upcoming(self) -> Sequence[Viewpoint]:
        return list(self._plan)[:N_AHEAD]

    def progress_of(self, region: int) -> float | None:
        return None
