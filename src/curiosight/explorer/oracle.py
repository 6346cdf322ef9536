"""The oracle: the stay after which the true error has fallen most per second."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from curiosight.errors.arguments import check_whole
from curiosight.explorer.decision import Decision
from curiosight.explorer.ground import LOOK_SECONDS, Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.strategy import MAX_STAY
from curiosight.explorer.tally import Tally
from curiosight.frame import Viewpoint

# Tells how far the true overall error would fall, were these views looked at next, in turn.
Trial = Callable[[Sequence[Viewpoint]], float]


class Oracle:
    """Try a stay in every region on a copy of the model, then do the best: no robot can.

    A stay is `n_stay` views, the nearest not seen each after the other; it is worth what the
    error on the test frames falls, by the seconds of ways and looks. A reference, greedy: what
    only pays later it does not see.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        trial: Trial,
        ways: Ways | None = None,
        n_stay: int = 10,
    ) -> None:
        check_whole("n_stay", n_stay, 1, MAX_STAY)
        self._tally = Tally(Ground(views, ways))
        # Where it starts is drawn, as for those that it is compared with.
        self._first = int(rng.integers(len(self._tally.ground)))
        self._trial = trial
        self._n_stay = n_stay
        self._plan: list[int] = [self._first]
        self._decision: Decision | None = None

    def choose(self) -> Viewpoint:
        if not self._plan:
            self._plan = self._best_stay()
        return self._tally.go_to(self._plan.pop(0))

    def _best_stay(self) -> list[int]:
        ground, tally = self._tally.ground, self._tally
        stays = [tally.stay(region, self._n_stay) for region in range(ground.n_regions)]
        falls = [self._trial([ground.views[number] for number in stay]) for stay, _ in stays]
        seconds = [way + LOOK_SECONDS * self._n_stay for _, way in stays]
        rates = np.array(falls) / seconds
        best = int(rates.argmax())
        ways = tally.seconds_to_regions()
        self._decision = Decision.among(
            ground.regions,
            falls,
            ways,
            rates,
            chosen=ground.regions[best],
            text="largest fall of the true error per second, tried on a copy",
        )
        return stays[best][0]

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Note how long the way was; else a trial tells all."""
        self._tally.arrive(viewpoint, outcome.seconds)

    def upcoming(self) -> Sequence[Viewpoint]:
        return [self._tally.ground.views[number] for number in self._plan]

    def progress_of(self, region: int) -> float | None:
        return None

    def reasons(self) -> Decision | None:
        return self._decision
