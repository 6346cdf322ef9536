"""Look where the error is expected to fall fastest per second of robot time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.explorer.decision import Candidate, Decision
from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.outlook import Outlook
from curiosight.explorer.tally import Tally
from curiosight.explorer.worth import Learnability, Worth
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

LOOK_SECONDS = 1.0
# Views farther than so many seconds of way see other surfaces.
REACH_SECONDS = 16.0
# A stay is weighed by up to so many looks, each of which leaves less for the next.
N_PLANNED, LEFT = 12, 0.97
# What later looks in a region bring: c and p of `ProgressRate`.
HALF, POWER = 15.0, 1.5
# Seconds of a way inside a region, and those that make a near view no better than a good one.
WITHIN_SECONDS, PATIENCE = 2.0, 2.0


class ProgressRate:
    """Go where the error is expected to fall most per second of way and looks.

    What a look at view v of region r is expected to bring is

        progress(v) = share(r) learnability(r) (c / (c + looks(r)))^p fresh(v) / whole(r),

    fresh(v): how much of what it would show is new, things above all (`Worth`); whole(r): the
    mean of that over the region's views, had nothing been seen; share(r): of its views, those
    that show things at all; learnability(r): see there; and the first looks bring most. The next
    region is the one with the largest

        max over k of (progress of its k best views) / (way there + k looks),

    the next view in it the one with the largest progress(v) / (way + patience). What is not
    known yet counts as much as what is seen does on average, so that it is tried when it is near;
    a region that shows no progress is left, and one that has changed is new again.

    views, ways: see `Ground`. The first view is drawn.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        ways: Ways | None = None,
        worth: Worth | None = None,
    ) -> None:
        self._ground = ground = Ground(views, ways)
        self._tally = Tally(ground)
        self._outlook = Outlook([view.T_world_camera for view in ground.views])
        self._worth = worth or Worth()
        self._learnability = Learnability(ground.n_regions)
        self._first = int(rng.integers(len(ground)))
        # Looks that still count: fewer where a region has changed.
        self._n_seen = np.zeros(len(ground))
        self._n_looks = np.zeros(ground.n_regions)
        self._fresh, self._whole, self._shows = self._worth.of(
            self._outlook, np.arange(len(ground))
        )
        self._region = -1
        self._decision: Decision | None = None

    def choose(self) -> Viewpoint:
        if self._tally.here is None:
            self._region = int(self._ground.region_of[self._first])
            return self._tally.go_to(self._first)
        progress, seconds = self.progress(), self._ground.seconds_from(self._tally.here)
        self._go_on(progress, self._rates(progress))
        members = self._ground.members[self._region]
        best = np.argmax(progress[members] / (seconds[members] + PATIENCE))
        return self._tally.go_to(int(members[best]))

    def _go_on(self, progress: Floats, rates: Floats) -> None:
        """Stay in the region or go to the best, and keep why."""
        chosen = int(np.argmax(rates))
        if chosen == self._region:
            return
        regions = self._ground.regions.tolist()
        best = [float(progress[members].max()) for members in self._ground.members]
        ways = self._tally.seconds_to_regions().tolist()
        scores = zip(regions, best, ways, rates.tolist(), strict=True)
        left, there = rates[self._region], rates[chosen]
        news = "" if self._n_looks[chosen] else ", and nothing is known of it yet"
        self._decision = Decision(
            tuple(Candidate(*score) for score in scores),
            regions[chosen],
            f"{there:.3f} a second expected there, {left:.3f} here{news}",
        )
        self._region = chosen

    def progress(self) -> Floats:
        """Return (n_views,) of what a look is expected to bring."""
        ground = self._ground
        n_views = np.bincount(ground.region_of)
        whole = np.bincount(ground.region_of, self._whole) / n_views
        share = np.bincount(ground.region_of, self._shows) / n_views
        early = (HALF / (HALF + self._n_looks)) ** POWER
        of_region = share * self._learnability.of_regions() * early / whole
        again = self._worth.again**self._n_seen
        expected: Floats = of_region[ground.region_of] * self._fresh * again
        return expected

    def _rates(self, progress: Floats) -> Floats:
        """Return (n_regions,) progress per second of the best stay in each region."""
        ways = self._tally.seconds_to_regions()
        ways[self._region] = 0.0
        rates = np.empty(len(ways))
        for region, members in enumerate(self._ground.members):
            best = np.sort(progress[members])[::-1][:N_PLANNED]
            later = np.arange(len(best))
            start = HALF + self._n_looks[region]
            brought = np.cumsum(best * LEFT**later * (start / (start + later)) ** POWER)
            seconds = ways[region] + (later + 1) * (LOOK_SECONDS + WITHIN_SECONDS)
            rates[region] = (brought / seconds).max()
        return rates

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        number = self._ground.number_of(viewpoint)
        region = int(self._ground.region_of[number])
        self._n_seen[number] += 1
        self._n_looks[region] += 1
        self._learnability.add(region, outcome.error)
        if outcome.has_changed:
            self._forget(region)
        if outcome.seen is not None and viewpoint.T_world_camera is not None:
            near = self._ground.seconds_from(number) <= REACH_SECONDS
            self._outlook.add(outcome.seen, viewpoint.T_world_camera, near)
            self._weigh(np.flatnonzero(near))

    def _forget(self, region: int) -> None:
        """Take a region for new, and doubt what is known of the others."""
        members, doubt = self._ground.members[region], self._worth.doubt
        self._outlook.forget(np.arange(len(self._ground)), doubt)
        self._outlook.forget(members, 1.0)
        self._learnability.forget(region)
        self._n_looks *= 1 - doubt
        self._n_looks[region] = 0
        self._n_seen *= 1 - doubt
        self._n_seen[members] = 0
        self._weigh(np.arange(len(self._ground)))

    def _weigh(self, views: Ints) -> None:
        """Find out anew what some views are worth."""
        fresh, whole, shows = self._worth.of(self._outlook, views)
        self._fresh[views], self._whole[views], self._shows[views] = fresh, whole, shows

    def reasons(self) -> Decision | None:
        return self._decision

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        """Return what the best look in a region is expected to bring, beside a new one's 1."""
        progress, numbers = self.progress(), np.flatnonzero(self._ground.regions == region)
        return (
            float(progress[self._ground.members[int(numbers[0])]].max()) if len(numbers) else None
        )
