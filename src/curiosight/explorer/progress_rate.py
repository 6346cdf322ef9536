"""Look where the error is expected to fall fastest per second of robot time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.outlook import Outlook
from curiosight.explorer.worth import Learnability, Worth
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

LOOK_SECONDS = 1.0
# Views farther than so many seconds of way see other surfaces.
REACH_SECONDS = 16.0
# A stay is weighed by up to so many looks, each of which leaves less for the next.
N_PLANNED, LEFT = 12, 0.97
# Of a region's first looks each brings most: it falls with this power of their number.
HALF, POWER = 10.0, 2.0
# Of a way inside a region, seconds; and by what a look takes longer it counts, see `choose`.
WITHIN_SECONDS, PATIENCE = 2.0, 3.0


class ProgressRate:
    """Go where the error is expected to fall most per second of way and looks.

    What a look at view v of region r is expected to bring is

        progress(v) = share(r) * learnability(r) * fresh(v) / whole(r),

    fresh(v): of what it would show that which is new, things above all (`Worth`), whole(r) the
    mean of the region's views if nothing had been seen; share(r): of its views, those that show
    things at all; learnability(r): how well the region was predicted, beside all (`Learnability`).
    The next region is the one with the largest

        max over k of (progress of its k best views) / (way there + k looks),

    the next view in it the one with the largest progress(v) / (way + patience). What is not
    known yet is worth as much as what is seen is on average, so that it is tried when it is near;
    a region that shows no progress is left, and one whose error has risen is new again.

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
        self._outlook = Outlook([view.T_world_camera for view in ground.views])
        self._worth = worth or Worth()
        self._learnability = Learnability(ground.n_regions)
        self._n_looks = np.zeros(len(ground), np.int64)
        self._n_of_region = np.zeros(ground.n_regions)
        self._first = int(rng.integers(len(ground)))
        self._here: int | None = None
        self._fresh = np.ones(len(ground))
        self._whole = np.ones(len(ground))
        self._shows = np.ones(len(ground))
        self._weigh(np.arange(len(ground)))

    def choose(self) -> Viewpoint:
        number = self._first if self._here is None else self._next()
        self._here = number
        return self._ground.views[number]

    def _next(self) -> int:
        seconds = self._ground.seconds_from(self._here)
        progress = self.progress()
        rates = self._rates(progress, seconds)
        members = self._ground.members[int(np.argmax(rates))]
        return int(members[np.argmax(progress[members] / (seconds[members] + PATIENCE))])

    def progress(self) -> Floats:
        """Return (n_views,) of what a look is expected to bring."""
        ground = self._ground
        n_views = np.bincount(ground.region_of)
        whole = np.bincount(ground.region_of, self._whole) / n_views
        share = np.bincount(ground.region_of, self._shows) / n_views
        early = (HALF / (HALF + self._n_of_region)) ** POWER
        of_region = share * self._learnability.of_regions() * early / whole
        again = self._worth.again**self._n_looks
        expected: Floats = of_region[ground.region_of] * self._fresh * again
        return expected

    def _rates(self, progress: Floats, seconds: Floats) -> Floats:
        """Return (n_regions,) progress per second of the best stay in each region."""
        ground = self._ground
        rates = np.empty(ground.n_regions)
        here = -1 if self._here is None else ground.region_of[self._here]
        for region, members in enumerate(ground.members):
            best = np.sort(progress[members])[::-1][:N_PLANNED]
            n_looks = np.arange(1, len(best) + 1)
            start = self._n_of_region[region]
            later = ((HALF + start) / (HALF + start + n_looks - 1)) ** POWER
            brought = np.cumsum(best * LEFT ** (n_looks - 1) * later)
            way = 0.0 if region == here else seconds[members].min()
            rates[region] = (brought / (way + n_looks * (LOOK_SECONDS + WITHIN_SECONDS))).max()
        return rates

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        number = self._ground.number_of(viewpoint)
        self._n_looks[number] += 1
        region = int(self._ground.region_of[number])
        self._n_of_region[region] += 1
        self._learnability.add(region, outcome.error)
        if outcome.has_changed:
            self._forget(region)
        if outcome.seen is None or viewpoint.T_world_camera is None:
            return
        near = self._ground.seconds_from(number) <= REACH_SECONDS
        self._outlook.add(outcome.seen, viewpoint.T_world_camera, near)
        self._weigh(np.flatnonzero(near))

    def _forget(self, region: int) -> None:
        """Take a region for new, and doubt what is known of the others."""
        members = self._ground.members[region]
        self._outlook.forget(np.arange(len(self._ground)), self._worth.doubt)
        self._outlook.forget(members, 1.0)
        self._learnability.forget(region)
        self._n_looks[members] = 0
        self._n_of_region *= 1 - self._worth.doubt
        self._n_of_region[region] = 0
        self._weigh(np.arange(len(self._ground)))

    def _weigh(self, views: Ints) -> None:
        fresh, whole, shows = self._worth.of(self._outlook, views)
        self._fresh[views], self._whole[views], self._shows[views] = fresh, whole, shows

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        """Return what the best look in a region is expected to bring, beside a new one's 1."""
        progress, numbers = self.progress(), np.flatnonzero(self._ground.regions == region)
        return (
            float(progress[self._ground.members[int(numbers[0])]].max()) if len(numbers) else None
        )
