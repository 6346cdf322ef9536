"""A learner that is taken from view to view of a prepared source, whoever chooses the views."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import partial

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.evaluation import HeldOut
from curiosight.experiments.components import make_learner
from curiosight.experiments.contest.prepared import Phase, Prepared, Shown
from curiosight.experiments.dividing import divide_views
from curiosight.explorer.ground import LOOK_SECONDS, Ways
from curiosight.explorer.outcome import Outcome, mean_uncertainty
from curiosight.explorer.regions import Regions
from curiosight.frame import Viewpoint
from curiosight.learner.experts import COMMON, Change
from curiosight.worlds.travel import travel_seconds

Floats = npt.NDArray[np.float64]


def views_in_regions(prepared: Prepared, config: Config) -> tuple[tuple[Viewpoint, ...], Regions]:
    """Return the views of a source, and the regions that the settings divide them into."""
    regions = divide_views(
        config,
        prepared.poses,
        prepared.ids,
        metres=np.asarray(prepared.metres),
        up=prepared.up,
        own=prepared.region_table,
        sights=prepared.sights(),
    )
    views = (
        Viewpoint(index, int(region), prepared.poses[index])
        for index, region in enumerate(regions.of_view)
    )
    return tuple(views), regions


class Tour:
    """Look at view after view and learn: what is shown, what it costs, how wrong the model is.

    Before each look call `enter_phase`, for the source may change there.

    seconds: of the ways between views, where a map tells them and poses do not.
    n_looks, seconds, metres: so far. here: None before the first look.
    errors: of each measurement after how many looks, and 1 - F1 of each test frame that has one.
    """

    def __init__(
        self,
        prepared: Prepared,
        config: Config,
        rng: np.random.Generator,
        seconds: Ways | None = None,
    ) -> None:
        self._prepared = prepared
        self._seconds = seconds
        self.learner = make_learner(config, None, rng)
        self.n_looks = 0
        self.seconds = self.metres = 0.0
        self.here: Viewpoint | None = None
        self.errors: list[tuple[int, Floats]] = []
        self._n_seen = np.zeros(len(prepared.ids), np.int64)
        self._change: Change | None = None
        self._phase: Phase | None = None

    def enter_phase(self) -> bool:
        """Make ready for the next look; return whether the source is another from it on."""
        for phase in self._prepared.phases:
            if phase.first_look == self.n_looks and phase is not self._phase:
                self._phase = phase
                self._held_out = HeldOut(self.learner, phase.tests)
                self._change = None
                return True
        return False

    def ways(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
        """Return the (n,) seconds of the ways from one view to others."""
        if self._seconds is not None:
            return self._seconds(start, goals)
        return travel_seconds(*self._prepared.ways(start, goals))

    def look(self, viewpoint: Viewpoint) -> Outcome:
        """Go to a view, look, and learn from its next visit."""
        start = self.here or viewpoint
        way, _ = (one[0] for one in self._prepared.ways(start, [viewpoint]))
        cost, self.here = float(self.ways(start, [viewpoint])[0]), viewpoint
        self.n_looks += 1
        self.seconds += cost + LOOK_SECONDS
        self.metres += float(way)
        shown = self._show(viewpoint, self._n_seen)
        scores, error, change = self.learner.observe_again(shown.visit)
        self._change = together(self._change, change)
        visit, uncertainty = shown.visit, mean_uncertainty(scores)
        again = partial(self.learner.error_of, visit.rows, visit.counts, visit.lesson.sight)
        return Outcome(error, cost, uncertainty, shown.seen, change.has_drifted, again)

    def measure(self) -> float:
        """Return the overall error of the model as it is; it is noted in `errors`."""
        errors = self._held_out.errors(self._change)
        self._change = Change({})
        self.errors.append((self.n_looks, errors))
        return float(errors.mean())

    def trial(self, views: Sequence[Viewpoint]) -> float:
        """Return how far the overall error would fall if these views were looked at next.

        It is tried on a copy of the model, with the visits and the chance that would come.
        """
        learner = copy.deepcopy(self.learner)
        held_out = self._held_out.copied(learner)
        error = held_out.errors(self._change).mean()
        change, n_seen = Change({}), self._n_seen.copy()
        for viewpoint in views:
            _, _, changed = learner.observe_again(self._show(viewpoint, n_seen).visit)
            change = together(change, changed)
        return float(error - held_out.errors(change).mean())

    def _show(self, viewpoint: Viewpoint, n_seen: npt.NDArray[np.int64]) -> Shown:
        """Return the next visit of a view, and count it; they come in turn."""
        assert self._phase is not None
        visit = n_seen[viewpoint.index] % self._prepared.n_visits
        n_seen[viewpoint.index] += 1
        return self._phase.shown[viewpoint.index * self._prepared.n_visits + int(visit)]


def together(before: Change | None, change: Change) -> Change:
    """Sum up what learning changed; before: None = everything may be another."""
    if before is None or before.is_rearranged or change.is_rearranged:
        return Change({COMMON: ()}, is_rearranged=True)
    keys = {*before.trees, *change.trees}
    both = {
        key: tuple(sorted({*before.trees.get(key, ()), *change.trees.get(key, ())})) for key in keys
    }
    return Change(both)
