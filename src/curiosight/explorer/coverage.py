"""See every view once, by short ways: what a robot does that knows nothing of learning."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.tally import Tally
from curiosight.frame import Viewpoint


class Coverage:
    """Look at the nearest view never seen, whatever its region; when all were, the least seen.

    The first view is drawn. Views in no region are left out.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        ways: Ways | None = None,
    ) -> None:
        ground = Ground(views, ways)
        self._tally = Tally(ground)
        self._everywhere = np.arange(len(ground))
        self._first = int(rng.integers(len(ground)))

    def choose(self) -> Viewpoint:
        tally = self._tally
        is_first = tally.here is None
        return tally.go_to(self._first if is_first else tally.nearest(self._everywhere))

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Note how long the way was; else the order does not depend on what is learned."""
        self._tally.arrive(viewpoint, outcome.seconds)

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        return None
