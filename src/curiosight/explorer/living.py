"""Regions that live: more as there are more views, split where progress differs, else joined."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.explorer.decision import Candidate, Decision, Explains
from curiosight.explorer.from_above import seen_from_above
from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.strategy import Strategy
from curiosight.frame import Viewpoint
from curiosight.frame.linkage import AverageLinkage

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Makes = Callable[[Sequence[Viewpoint]], Strategy]

# A region is split if its halves' progress differs by more standard errors than the first, and
# joined again if by fewer than the second; by its last looks, and so many in each half.
SPLIT, JOIN = 4.0, 1.0
N_LAST, N_LEAST = 60, 15
# It is thought over after so many looks.
EVERY = 10
# So many looks are told again to a strategy that is made anew, the last of them in full.
N_TOLD, N_IN_FULL = 3000, 300


def living_regions(
    ground: Ground, looks: Sequence[tuple[int, float]], before: Ints | None = None
) -> Ints:
    """Return (n_views,) the part of its region that each view is in, numbered from 0.

    Each region, and then each part, is cut in two, by the ways or by headings, where the error
    falls faster on one side. looks: number of the view and error of each, in order. before: the
    parts so far, as of which a cut is drawn already.
    """
    parts = np.full(len(ground), -1)
    for region in range(ground.n_regions):
        for members in _parts_of(ground, region, looks, before):
            parts[members] = parts.max() + 1
    return parts


def _parts_of(
    ground: Ground, region: int, looks: Sequence[tuple[int, float]], before: Ints | None
) -> Iterator[Ints]:
    """Yield the views of each part of a region."""
    views = ground.members[region]
    seconds = ground.among(region)
    headings = seen_from_above([ground.views[view].T_world_camera for view in views]).headings
    pending = [np.arange(len(views))]
    while pending:
        inside = pending.pop()
        place_of = {int(view): place for place, view in enumerate(views[inside])}
        seen = [(place_of[view], error) for view, error in looks if view in place_of][-N_LAST:]
        places, errors = np.array([*zip(*seen, strict=True)]) if seen else np.empty((2, 0))
        best, cut = 0.0, None
        for is_first in _cuts(seconds[np.ix_(inside, inside)], headings[inside]):
            sides = views[inside[is_first]], views[inside[~is_first]]
            excess = difference(errors, is_first[places.astype(int)])
            is_drawn = before is not None and not set(before[sides[0]]) & set(before[sides[1]])
            if excess > max(best, JOIN if is_drawn else SPLIT):
                best, cut = excess, is_first
        if cut is None:
            yield views[inside]
        else:
            pending += [inside[~cut], inside[cut]]


def _cuts(seconds: Floats, headings: Floats) -> Iterator[npt.NDArray[np.bool_]]:
    """Yield (n,) which views are on one side: by the ways, and by headings, radians."""
    if len(seconds) < 2:
        return
    yield AverageLinkage((seconds + seconds.T) / 2).at_most(2) == 0
    for turn in (0.0, np.pi / 2):
        yield np.cos(headings - turn) > 0  # NaN is on the other side


def difference(errors: Floats, is_first: npt.NDArray[np.bool_]) -> float:
    """Return by how many standard errors the progress of two kinds of looks differs.

    errors, is_first: (n,) of the looks, in order. Progress is the slope of a line through the
    errors of a kind (eq. 2-3), by looks of any kind: both learn from both. 0 where there are
    too few of one.
    """
    if min(is_first.sum(), (~is_first).sum()) < N_LEAST:
        return 0.0
    lines = [_slope(np.flatnonzero(kind), errors[kind]) for kind in (is_first, ~is_first)]
    slopes, variances = zip(*lines, strict=True)
    return float(abs(slopes[0] - slopes[1]) / np.sqrt(sum(variances)))


def _slope(time: Ints, errors: Floats) -> tuple[float, float]:
    """Return the slope of a line through errors, and its variance."""
    since = time - time.mean()
    slope = float(since @ errors / (since @ since))
    left = errors - errors.mean() - slope * since
    # No error is known better than to a hundredth, however straight the line.
    noise = max(float(left @ left) / (len(errors) - 2), 0.01**2)
    return slope, noise / float(since @ since)


class Living:
    """Run a strategy on regions that change: it is made anew, and told of the looks so far.

    To the outside views keep the regions they have. Until a region is split, and while no views
    are added, it does what the strategy does alone.

    views: tells the views there are; where a world finds more as it sees more, these are added,
        each in the region that the world gives it.
    make: makes the strategy for views in the regions that they are given.
    """

    def __init__(
        self, views: Callable[[], Sequence[Viewpoint]], make: Makes, *, ways: Ways | None = None
    ) -> None:
        self._views, self._make, self._ways = views, make, ways
        self._told: deque[tuple[Viewpoint, Outcome]] = deque(maxlen=N_TOLD)
        # The strategy's decision, and what is told of it.
        self._explained: tuple[Decision, Decision] | None = None
        self._begin(None)

    @property
    def parts(self) -> Ints:
        """(n_views,) the part that each view is in, in the order of their indices."""
        return self._parts

    def choose(self) -> Viewpoint:
        # What was announced is kept to.
        if not self._strategy.upcoming():
            if len(self._views()) != self._n_views:
                self._begin(None)
            elif self._n_since >= EVERY:
                self._begin(self._parts)
        chosen = self._strategy.choose()
        return self._ground.views[self._ground.number_of(chosen)]

    def _begin(self, before: Ints | None) -> None:
        """Divide the views; make the strategy anew if that is another division."""
        views = self._views()
        if before is None:
            self._n_views, self._ground = len(views), Ground(views, self._ways)
        ground, self._n_since = self._ground, 0
        looks = [
            (ground.number_of(viewpoint), outcome.error)
            for viewpoint, outcome in self._told
            if outcome.error is not None and viewpoint in ground
        ]
        parts = living_regions(ground, looks, before)
        if before is not None and np.array_equal(parts, before):
            return
        self._parts = parts
        self._inner = [
            replace(view, region=int(part)) for view, part in zip(ground.views, parts, strict=True)
        ]
        self._strategy = self._make(self._inner)
        for viewpoint, outcome in self._told:
            self._tell(viewpoint, outcome)

    def _tell(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        if viewpoint in self._ground:
            self._strategy.update(self._inner[self._ground.number_of(viewpoint)], outcome)

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        self._told.append((viewpoint, outcome))
        if len(self._told) > N_IN_FULL:
            self._shorten(len(self._told) - N_IN_FULL - 1)
        self._n_since += 1
        self._tell(viewpoint, outcome)

    def _shorten(self, number: int) -> None:
        """Keep of a look what counts later, so that weeks of looks take up no more memory."""
        viewpoint, outcome = self._told[number]
        later = (view.index for view, _ in islice(self._told, number + 1, None))
        seen = None if viewpoint.index in later else outcome.seen
        self._told[number] = viewpoint, replace(outcome, seen=seen, again=None)

    def upcoming(self) -> Sequence[Viewpoint]:
        ground = self._ground
        return [ground.views[ground.number_of(view)] for view in self._strategy.upcoming()]

    def progress_of(self, region: int) -> float | None:
        """Return the progress of the part of a region that makes the most; None = of none."""
        known = [
            progress
            for part in self._parts_in(region)
            if (progress := self._strategy.progress_of(part)) is not None
        ]
        return max(known, default=None)

    def _parts_in(self, region: int) -> list[int]:
        is_inside = self._ground.regions[self._ground.region_of] == region
        return sorted(set(self._parts[is_inside].tolist()))

    def reasons(self) -> Decision | None:
        """Return the last decision, between regions: of each its part with the highest score."""
        decision = self._strategy.reasons() if isinstance(self._strategy, Explains) else None
        if decision is not None and (self._explained is None or self._explained[0] is not decision):
            self._explained = decision, self._between_regions(decision)
        return None if self._explained is None else self._explained[1]

    def _between_regions(self, decision: Decision) -> Decision:
        ground = self._ground
        region_of_part = dict(
            zip(self._parts.tolist(), ground.regions[ground.region_of].tolist(), strict=True)
        )
        best: dict[int, Candidate] = {}
        for one in sorted(decision.candidates, key=lambda one: one.score):
            region = region_of_part[one.region]
            best[region] = replace(one, region=region)
        candidates = tuple(best[region] for region in sorted(best))
        return Decision(candidates, region_of_part[decision.chosen], decision.text)
