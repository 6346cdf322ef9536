"""Look where the error is expected to fall fastest per second of robot time."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
import numpy.typing as npt

from curiosight.errors.arguments import check_whole
from curiosight.explorer.decision import Decision
from curiosight.explorer.ground import LOOK_SECONDS, Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.outlook import Outlook
from curiosight.explorer.paths import Alikeness, plan_path
from curiosight.explorer.strategy import MAX_STAY
from curiosight.explorer.tally import Tally
from curiosight.explorer.worth import Learnability, Worth
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Views farther than so many seconds of way see other surfaces.
REACH_SECONDS = 16.0
# After so many looks in a region another brings half.
HALF = 15.0
# Regions that show things in so many of their views are worth as much as any.
ENOUGH_SHOW = 0.2
# Regions that promise so much of the best are gone to; one that promises less is left after some
# looks.
ENOUGH, LEFT_BELOW, N_TRIED = 0.7, 0.12, 5
# A stay takes so many times as long as the way to the next is longer than one inside.
STAY_PER_WAY = 5.0
# Seconds that make a near view no better than a good one.
PATIENCE = 1.0
# Through more views than this no path is planned, which would take too long.
MOST_PLANNED = 200


class ProgressRate:
    """Go where the error is expected to fall most per second of way and looks.

    What a look in region r is expected to bring is

        progress(r) = shows(r) learnability(r) 2^(-looks(r) / 15),

    shows(r): whether its views show things at all; learnability(r): see there. A stay pays off
    the way: it lasts five times as long as that to where it goes on is longer than one inside, so
    that regions far apart are looked at thoroughly and near ones in turn; and `n_stay` looks at
    most. Then comes the nearest of the regions that promise nearly as much as the best. Inside a
    region the path is planned that takes in the most value per second: what would be new in view,
    things above all (`Worth`), with near views taken in on the way. A region that shows no
    progress is left, and one that has changed is new again.

    views, ways: see `Ground`. The first view is drawn. n_stay: looks of a stay, at most.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        ways: Ways | None = None,
        n_stay: int = 15,
        worth: Worth | None = None,
    ) -> None:
        check_whole("n_stay", n_stay, 1, MAX_STAY)
        self._ground = ground = Ground(views, ways)
        self._tally = Tally(ground)
        self._outlook = Outlook([view.T_world_camera for view in ground.views])
        self._alikeness = Alikeness([view.T_world_camera for view in ground.views])
        self._worth = worth or Worth()
        self._learnability = Learnability(ground.n_regions)
        self._first = int(rng.integers(len(ground)))
        # Looks that still count: fewer where a region has changed.
        self._n_seen = np.zeros(len(ground))
        self._n_looks = np.zeros(ground.n_regions)
        self._fresh, self._shows = self._worth.of(self._outlook, np.arange(len(ground)))
        self._region, self._n_stay, self._n_stayed, self._n_ahead = -1, n_stay, 0, n_stay
        self._n_inside, self._inside_seconds = 0, 0.0
        self._decision: Decision | None = None

    def choose(self) -> Viewpoint:
        if self._tally.here is None:
            self._region = int(self._ground.region_of[self._first])
            return self._tally.go_to(self._first)
        if self._ground.n_regions > 1:
            self._stay_or_leave()
        return self._tally.go_to(self._next_view())

    def _stay_or_leave(self) -> None:
        """Go to the nearest region that promises enough, once the stay has paid off that way."""
        progress, ways = self.progress(), self._tally.seconds_to_regions()
        elsewhere = np.where(np.arange(len(progress)) == self._region, -1.0, progress)
        enough = np.flatnonzero(elsewhere >= ENOUGH * elsewhere.max())
        goal = int(enough[np.argmin(ways[enough])])
        inside = self._inside_seconds / max(1, self._n_inside)
        pays_off = ceil(STAY_PER_WAY * (ways[goal] - inside) / (inside + LOOK_SECONDS))
        n_looks = min(self._n_stay, max(1, pays_off))
        if progress[self._region] < LEFT_BELOW * elsewhere.max():
            n_looks = min(n_looks, N_TRIED)
        self._n_ahead = n_looks - self._n_stayed
        if self._n_ahead <= 0:
            self._leave(goal, enough, progress, ways)

    def _next_view(self) -> int:
        """Return the first view of a path for the looks ahead, or of a large region the best."""
        ground, members = self._ground, self._ground.members[self._region]
        values = self._fresh[members] * self._worth.again ** self._n_seen[members]
        to = ground.seconds_from(self._tally.here)[members]
        if len(members) > MOST_PLANNED:
            return int(members[np.argmax(values / (to + PATIENCE))])
        path = plan_path(
            values,
            to,
            ground.among(self._region),
            lambda number: self._alikeness.between(members, int(members[number])),
            n_looks=self._n_ahead,
            patience=PATIENCE,
        )
        return int(members[path[0]])

    def _leave(self, goal: int, enough: Ints, progress: Floats, ways: Floats) -> None:
        """Go to another region, and keep why."""
        nearness = np.zeros(len(ways))
        nearness[enough] = 1 / (ways[enough] + LOOK_SECONDS)
        news = "" if self._n_looks[goal] else ", where nothing is known yet"
        self._decision = Decision.among(
            self._ground.regions,
            progress,
            ways,
            nearness,
            chosen=self._ground.regions[goal],
            text=f"nearest of {len(enough)} that promise at least {ENOUGH:g} of the best{news}",
        )
        self._region, self._n_stayed, self._n_ahead = goal, 0, self._n_stay

    def progress(self) -> Floats:
        """Return (n_regions,) of what a look is expected to bring, beside 1 in a new one."""
        ground = self._ground
        share = np.bincount(ground.region_of, self._shows) / np.bincount(ground.region_of)
        shows = np.minimum(1, share / ENOUGH_SHOW)
        expected: Floats = shows * self._learnability.of_regions() * 2 ** (-self._n_looks / HALF)
        return expected

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        self._tally.arrive(viewpoint, outcome.seconds)
        number = self._ground.number_of(viewpoint)
        region = int(self._ground.region_of[number])
        if region != self._region:  # somebody else chose it: a stay begins there
            self._region, self._n_stayed = region, 0
        self._n_seen[number] += 1
        self._n_looks[region] += 1
        self._n_stayed += 1
        if self._n_stayed > 1:
            self._n_inside += 1
            self._inside_seconds += outcome.seconds
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
        self._fresh[views], self._shows[views] = self._worth.of(self._outlook, views)

    def reasons(self) -> Decision | None:
        return self._decision

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        """Return what a look in a region is expected to bring; None for one without views."""
        numbers = np.flatnonzero(self._ground.regions == region)
        return float(self.progress()[numbers[0]]) if len(numbers) else None
