"""One strategy, one seed, one source: the loop on what was prepared."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.evaluation import HeldOut
from curiosight.experiments.components import choose_strategy, make_learner
from curiosight.experiments.contest.prepared import Phase, Prepared, Shown
from curiosight.explorer import Strategy, make_regions
from curiosight.explorer.outcome import Outcome, mean_uncertainty
from curiosight.frame import Viewpoint
from curiosight.learner.experts import COMMON, Change
from curiosight.worlds.travel import travel_seconds

Floats = npt.NDArray[np.float64]

LOOK_SECONDS = 1.0
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
        self.learner = make_learner(config, None, learner_rng)
        regions = make_regions(
            config.explorer.regions or None,
            prepared.poses,
            prepared.ids,
            metres=np.asarray(prepared.metres),
            up=prepared.up,
        )
        self.regions = regions
        self.views = tuple(
            Viewpoint(index, int(region), prepared.poses[index])
            for index, region in enumerate(regions.of_view)
        )
        self.strategy: Strategy = choose_strategy(
            config, self.views, strategy_rng, ways=self._seconds, trial=self._trial
        )
        self._n_looks = np.zeros(len(self.views), np.int64)
        self._change: Change | None = None
        self._phase: Phase | None = None
        self.errors: list[tuple[int, npt.NDArray[np.float64]]] = []

    def _seconds(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
        return travel_seconds(*self._prepared.ways(start, goals))

    def looks(self, n_looks: int, max_seconds: float | None = None) -> Iterator[LookRow]:
        """Yield so many looks, or as many as fit into the seconds."""
        seconds = metres = 0.0
        here: Viewpoint | None = None
        for number in range(1, n_looks + 1):
            self._enter_phase(number - 1)
            viewpoint = self.strategy.choose()
            way, turn = (one[0] for one in self._prepared.ways(here or viewpoint, [viewpoint]))
            cost, here = float(travel_seconds(way, turn)), viewpoint
            seconds, metres = seconds + cost + LOOK_SECONDS, metres + float(way)
            error = self._look(viewpoint, cost)
            is_last = number == n_looks or (max_seconds is not None and seconds >= max_seconds)
            is_measured = is_last or self._is_measured(number)
            yield LookRow(
                number,
                self._prepared.ids[viewpoint.index],
                viewpoint.region,
                error,
                seconds,
                metres,
                self._measure(number) if is_measured else None,
            )
            if is_last:
                return

    def _is_measured(self, number: int) -> bool:
        """Tell whether the error is measured after a look; what changes is as if new."""
        first_looks = [phase.first_look for phase in self._prepared.phases]
        since = number - max(first for first in first_looks if first < number)
        return since <= N_EACH or since % EVERY == 0 or number in first_looks

    def _look(self, viewpoint: Viewpoint, cost: float) -> float | None:
        shown = self._show(viewpoint, self._n_looks)
        scores, error, change = self.learner.observe_again(shown.visit)
        self._change = together(self._change, change)
        visit, uncertainty = shown.visit, mean_uncertainty(scores)
        again = partial(self.learner.error_of, visit.rows, visit.counts, visit.lesson.sight)
        outcome = Outcome(error, cost, uncertainty, shown.seen, change.has_drifted, again)
        self.strategy.update(viewpoint, outcome)
        return error

    def _trial(self, views: Sequence[Viewpoint]) -> float:
        """Return how far the overall error would fall if these views were looked at next.

        It is tried on a copy of the model, with the visits and the chance that would come.
        """
        learner = copy.deepcopy(self.learner)
        held_out = self._held_out.copied(learner)
        error = held_out.errors(self._change).mean()
        change, n_looks = Change({}), self._n_looks.copy()
        for viewpoint in views:
            _, _, changed = learner.observe_again(self._show(viewpoint, n_looks).visit)
            change = together(change, changed)
        return float(error - held_out.errors(change).mean())

    def _show(self, viewpoint: Viewpoint, n_looks: npt.NDArray[np.int64]) -> Shown:
        """Return the next visit of a view, and count it; they come in turn."""
        assert self._phase is not None
        visit = n_looks[viewpoint.index] % self._prepared.n_visits
        n_looks[viewpoint.index] += 1
        return self._phase.shown[viewpoint.index * self._prepared.n_visits + int(visit)]

    def _enter_phase(self, n_looks: int) -> None:
        for phase in self._prepared.phases:
            if phase.first_look == n_looks:
                self._phase = phase
                self._held_out = HeldOut(self.learner, phase.tests)
                self._change = None

    def _measure(self, look: int) -> float:
        errors = self._held_out.errors(self._change)
        self._change = Change({})
        self.errors.append((look, errors))
        return float(errors.mean())

    def summary(self) -> dict[str, Any]:
        """Return what the run is of, JSON-able."""
        return {"regions": self.regions.kind, "names": list(self.regions.names)}


def together(before: Change | None, change: Change) -> Change:
    """Sum up what learning changed; before: None = everything may be another."""
    if before is None or before.is_rearranged or change.is_rearranged:
        return Change({COMMON: ()}, is_rearranged=True)
    keys = {*before.trees, *change.trees}
    both = {
        key: tuple(sorted({*before.trees.get(key, ()), *change.trees.get(key, ())})) for key in keys
    }
    return Change(both)
