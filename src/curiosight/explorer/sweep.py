"""Go from room to room, the nearest first: the honest rival of every clever strategy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
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
        if n_stay is not None and n_stay < 1:
            raise ValueError(f"n_stay: expected 1 or more, got {n_stay}")
        self._ground = Ground(views, ways)
        self._n_stay = n_stay
        self._n_seen = np.zeros(len(self._ground), np.int64)
        self._n_looks = np.zeros(self._ground.n_regions, np.int64)
        self._here: int | None = None
        self._first = int(rng.integers(len(self._ground)))
        self._left = 0
        self._region = -1

    def choose(self) -> Viewpoint:
        ground = self._ground
        if self._here is None:
            number = self._first
            self._enter(int(ground.region_of[number]))
        else:
            if not self._left:
                self._enter(self._next_region())
            number = self._nearest(ground.members[self._region])
        self._here = number
        self._left -= 1
        self._n_seen[number] += 1
        self._n_looks[self._region] += 1
        return ground.views[number]

    def _enter(self, region: int) -> None:
        self._region = region
        self._left = self._n_stay or len(self._ground.members[region])

    def _next_region(self) -> int:
        """Return the nearest of the regions least looked at, in stays."""
        ground = self._ground
        stays = self._n_looks / [self._n_stay or len(members) for members in ground.members]
        least = np.flatnonzero(stays == stays.min())
        seconds = ground.seconds_from(self._here)
        return int(min(least, key=lambda region: seconds[ground.members[region]].min()))

    def _nearest(self, members: np.ndarray) -> int:
        n_seen, seconds = self._n_seen[members], self._ground.seconds_from(self._here)[members]
        return int(members[np.lexsort((seconds, n_seen))[0]])

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Do nothing: the order does not depend on what is learned."""

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        return None
