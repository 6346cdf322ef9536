"""Stay in a region for a while, then choose the next by what draws there (sec. II-B)."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from curiosight.errors.arguments import check_whole
from curiosight.explorer.decision import Decision
from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.motivations import Motivation, Progress
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.progress import Negative, ProgressMeter, choice_probabilities
from curiosight.explorer.strategy import MAX_STAY, N_AHEAD, by_region, draw_stay
from curiosight.explorer.tally import Tally
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Inside = Literal["random", "nearest"]


@dataclass(frozen=True, slots=True)
class Choice:
    """A region, by its place among all; the score of each region; why."""

    place: int
    scores: Floats
    text: str


class Chooses(Protocol):
    """Choose the next region."""

    def __call__(self, interests: Sequence[float | None], tally: Tally) -> Choice:
        """Choose by the interest in each region, None = not known, and by the ways from here."""
        ...


class Drawn:
    """Draw a region: 75 % by interest, 25 % uniform, see `choice_probabilities`."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        random_share: float = 0.25,
        exponent: float = 1.0,
        negative: Negative = "clip",
    ) -> None:
        self._rng = rng
        self._random_share = random_share
        self._exponent = exponent
        self._negative = negative
        self._chances([None])  # refuses bad options now rather than after the warm-up

    def __call__(self, interests: Sequence[float | None], tally: Tally) -> Choice:
        chances = self._chances(interests)
        place = int(self._rng.choice(len(chances), p=chances))
        return Choice(place, chances, f"drawn with a chance of {chances[place]:.2f}")

    def _chances(self, interests: Sequence[float | None]) -> Floats:
        return choice_probabilities(
            interests,
            random_share=self._random_share,
            exponent=self._exponent,
            negative=self._negative,
        )


class Stays:
    """Look at every region once, then stay in one after the other.

    The first visits are in random order, `n_warm_up` views each; then stays of `n_stay` views
    in regions that `choose_region` chooses by what `motivation` says. The views of a stay differ
    from each other as far as the region has that many. Views in no region are left out.

    inside: which views of a region: "random", as in the paper; "nearest" = the nearest one
        that was not seen, each after the other.
    progress: measures the progress of each region for `progress_of`; it may be the motivation.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        motivation: Motivation,
        choose_region: Chooses,
        *,
        ways: Ways | None = None,
        n_stay: int = 10,
        n_warm_up: int = 2,
        inside: Inside = "random",
        progress: Motivation | None = None,
    ) -> None:
        check_whole("n_stay", n_stay, 1, MAX_STAY)
        check_whole("n_warm_up", n_warm_up, 0, MAX_STAY)
        self._pools = by_region(views)
        self._tally = Tally(Ground(views, ways))
        self._rng = rng
        self._motivation = motivation
        self._choose_region = choose_region
        self._n_stay = n_stay
        self._inside = inside
        self._progress = progress or Progress(ProgressMeter())
        self._decision: Decision | None = None
        self._n_warm_up = n_warm_up
        self._first: deque[Viewpoint] = deque()
        self._plan: deque[Viewpoint] = deque()
        for region in rng.permutation(list(self._pools)):
            self._first.extend(draw_stay(self._pools[region], n_warm_up, rng))

    def choose(self) -> Viewpoint:
        # Where others have looked that often it need not be visited first.
        while self._first and self._n_looks_beside(self._first[0]) >= self._n_warm_up:
            self._first.popleft()
        if self._first:
            return self._go_to(self._first.popleft())
        if not self._plan:
            self._plan.extend(self._next_stay())
        return self._go_to(self._plan.popleft())

    def _go_to(self, viewpoint: Viewpoint) -> Viewpoint:
        return self._tally.go_to(self._tally.ground.number_of(viewpoint))

    def _n_looks_beside(self, viewpoint: Viewpoint) -> int:
        ground = self._tally.ground
        return int(self._tally.n_looks[ground.region_of[ground.number_of(viewpoint)]])

    def _next_stay(self) -> list[Viewpoint]:
        """Decide where to go, and which views to look at there."""
        regions = list(self._pools)
        interests = [self._motivation.interest(region) for region in regions]
        choice = self._choose_region(interests, self._tally)
        seconds = self._tally.seconds_to_regions()
        self._decision = Decision.among(
            regions,
            interests,
            seconds,
            choice.scores,
            chosen=regions[choice.place],
            text=choice.text,
        )
        if self._inside == "nearest":
            numbers, _ = self._tally.stay(choice.place, self._n_stay)
            return [self._tally.ground.views[number] for number in numbers]
        return draw_stay(self._pools[regions[choice.place]], self._n_stay, self._rng)

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        self._tally.arrive(viewpoint, outcome.seconds)
        self._motivation.add(viewpoint.region, outcome)
        if self._progress is not self._motivation:
            self._progress.add(viewpoint.region, outcome)

    def upcoming(self) -> Sequence[Viewpoint]:
        return [*self._first, *self._plan][:N_AHEAD]

    def progress_of(self, region: int) -> float | None:
        return self._progress.interest(region)

    def reasons(self) -> Decision | None:
        return self._decision
