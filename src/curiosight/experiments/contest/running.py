"""One strategy, one seed, one source: the loop on what was prepared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.experiments.components import choose_strategy
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.tour import Floats, Tour, views_in_regions
from curiosight.experiments.dividing import graph_ways
from curiosight.explorer import Strategy
from curiosight.learner import SaliencyLearner

# The error is measured after each of the first looks, then after every so many; from a change
# of the source on anew.
N_EACH, EVERY = 20, 5


@dataclass(frozen=True, slots=True)
class LookRow:
    """One look: where, after how long, and how wrong the model is then.

    look: number, from 1. seconds, metres: from the start. overall_error: None = not measured.
    """

    look: int
    id: str
    region: int
    error: float | None
    seconds: float
    metres: float
    overall_error: float | None


class Run:
    """A run of one strategy; iterate over it, then read `errors`."""

    def __init__(self, prepared: Prepared, config: Config, seed: int) -> None:
        self._prepared = prepared
        learner_rng, strategy_rng = np.random.default_rng(seed).spawn(2)
        self.views, self.regions = views_in_regions(prepared, config)
        seconds = graph_ways(self.regions, prepared.poses)
        self.tour = Tour(prepared, config, learner_rng, seconds)
        self.strategy: Strategy = choose_strategy(
            config, self.views, strategy_rng, ways=self.tour.ways, trial=self.tour.trial
        )

    @property
    def learner(self) -> SaliencyLearner:
        return self.tour.learner

    @property
    def errors(self) -> list[tuple[int, Floats]]:
        """After how many looks it was measured, and 1 - F1 of each test frame then."""
        return self.tour.errors

    def looks(self, n_looks: int, max_seconds: float | None = None) -> Iterator[LookRow]:
        """Yield so many looks, or as many as fit into the seconds."""
        tour = self.tour
        for number in range(1, n_looks + 1):
            tour.enter_phase()
            viewpoint = self.strategy.choose()
            outcome = tour.look(viewpoint)
            self.strategy.update(viewpoint, outcome)
            seconds = tour.seconds
            is_last = number == n_looks or (max_seconds is not None and seconds >= max_seconds)
            is_measured = is_last or self._is_measured(number)
            yield LookRow(
                number,
                self._prepared.ids[viewpoint.index],
                viewpoint.region,
                outcome.error,
                seconds,
                tour.metres,
                tour.measure() if is_measured else None,
            )
            if is_last:
                return

    def _is_measured(self, number: int) -> bool:
        """Tell whether the error is measured after a look; what changes is as if new."""
        first_looks = [phase.first_look for phase in self._prepared.phases]
        since = number - max(first for first in first_looks if first < number)
        return since <= N_EACH or since % EVERY == 0 or number in first_looks

    def summary(self) -> dict[str, Any]:
        """Return what the run is of, JSON-able."""
        return {"regions": self.regions.kind, "names": list(self.regions.names)}
