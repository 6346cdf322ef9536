"""Go from room to room, the nearest first: the honest rival of every clever strategy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from curiosight.errors.arguments import check_whole
from curiosight.explorer.decision import Decision
from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.strategy import MAX_STAY
from curiosight.explorer.tally import Tally
from curiosight.frame import Viewpoint


class Sweep:
    """Look `n_stay` times in a region, then in the nearest of those least looked at.

    Inside a region the nearest view that was not seen comes first; where all were seen, those
    least often seen. The first view is drawn.

    n_stay: None = all views of a region.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        ways: Ways | None = None,
        n_stay: int | None = 10,
    ) -> None:
        if n_stay is not None:
            check_whole("n_stay", n_stay, 1, MAX_STAY)
        self._ground = Ground(views, ways)
        self._tally = Tally(self._ground)
        self._n_stay = n_stay
        self._first = int(rng.integers(len(self._ground)))
        self._left = 0
        self._region = -1
        self._decision: Decision | None = None

    def choose(self) -> Viewpoint:
        if self._tally.here is None:
            number = self._first
            self._enter(int(self._ground.region_of[number]))
        else:
            if not self._left:
                self._enter(self._next_region())
            number = self._tally.nearest(self._ground.members[self._region])
        self._left -= 1
        return self._tally.go_to(number)

    def _enter(self, region: int) -> None:
        self._region = region
        self._left = self._n_stay or len(self._ground.members[region])

    def _next_region(self) -> int:
        """Return the nearest of the regions least looked at, in stays."""
        ground, tally = self._ground, self._tally
        stays = tally.n_looks / [self._n_stay or len(members) for members in ground.members]
        least = np.flatnonzero(stays == stays.min())
        seconds = tally.seconds_to_regions()[least]
        chosen = int(least[np.argmin(seconds)])
        self._decision = Decision.among(
            ground.regions[least],
            [None] * len(least),
            seconds,
            -seconds,
            chosen=ground.regions[chosen],
            text=f"nearest of {len(least)} least looked at",
        )
        return chosen

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Note how long the way was; else the order does not depend on what is learned."""
        self._tally.arrive(viewpoint, outcome.seconds)

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        return None

    def reasons(self) -> Decision | None:
        return self._decision
