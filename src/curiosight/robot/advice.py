"""Where to go next, and why there: a strategy that is told what was looked at, whoever drove."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from curiosight.explorer import Strategy
from curiosight.explorer.decision import Decision, Explains
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Viewpoint
from curiosight.robot.region_record import RecentErrors, RegionRecord, plain
from curiosight.robot.routes import Drive

NOTHING_KNOWN = "nothing has been compared yet: it looks around where it is"
BEGUN = "it has begun here, and looks on before it decides between regions"
UNTOLD = "the strategy does not say why"
PINNED = "pinned by hand"

STATE = ("strategy", "n_looks", "_regions", "_errors", "_target", "_pinned", "_n_pinned")


class Advice:
    """Keep what each region's looks told, and ask a strategy where to go.

    strategy: makes its choice among `views`. All views of the source, one a frame; those in no
    region (-1) are looked at and not counted. n_views: that the strategy chooses from, at most.
    drive: what goes where it is told to; None = somebody else drives, and this is advice.

    One thread tells looks; any may ask.
    """

    def __init__(
        self,
        make_strategy: Callable[[tuple[Viewpoint, ...]], Strategy],
        views: Sequence[Viewpoint],
        names: Sequence[str],
        *,
        n_views: int = 400,
        drive: Drive | None = None,
    ) -> None:
        self.views = _offered(views, n_views)
        self._view_of = {view.index: view for view in views}
        self.strategy = make_strategy(self.views)
        self._regions = {
            region: RegionRecord(
                region, names[region], [view for view in self.views if view.region == region]
            )
            for region in sorted({view.region for view in self.views})
        }
        self.n_looks = 0
        self._errors = RecentErrors()
        self._drive = drive
        self._target: Viewpoint | None = None
        self._pinned: int | None = None
        self._n_pinned = 0
        # What was pinned at the last look.
        self.pinned_then: int | None = None
        # Held by who tells a look, and by who asks: what is told fits together.
        self.telling = threading.RLock()

    @property
    def pinned(self) -> int | None:
        """The region that was pinned; None = the strategy chooses."""
        return self._pinned

    def pin(self, region: int | None) -> None:
        """Stay in a region until it is unpinned (None); raises ValueError for one unknown."""
        if region is not None and region not in self._regions:
            known = ", ".join(map(str, self._regions))
            raise ValueError(f"region: expected one of {known}, got {region}")
        with self.telling:
            self._pinned = region
            if region is not None:
                self._head_for(self._regions[region].views[0])

    def state(self) -> dict[str, Any]:
        """Return all that looks and pins change, as it is, not copied: for `take_up`."""
        return {name: getattr(self, name) for name in STATE}

    def take_up(self, state: Mapping[str, Any]) -> None:
        """Go on from the `state` of advice on the same views, regions and strategy."""
        for name in STATE:
            setattr(self, name, state[name])
        if self._target is not None:
            self._head_for(self._target)

    def look_again(
        self, index: int | None, outcome: Outcome, seconds: float, pinned: int | None
    ) -> None:
        """Take note of a look as before; pinned: what was `pinned_then`."""
        if pinned != self._pinned:
            self.pin(pinned)
        self.look(index, outcome, seconds)

    def look(self, index: int | None, outcome: Outcome, seconds: float) -> None:
        """Take note of a look at a view; seconds: since the start. Then choose where to go."""
        view = None if index is None else self._view_of.get(index)
        if view is None:
            return
        with self.telling:
            self._look(view, outcome, seconds)

    def _look(self, view: Viewpoint, outcome: Outcome, seconds: float) -> None:
        self.n_looks += 1
        self.pinned_then = self._pinned
        region = self._regions.get(view.region)
        if region is not None:
            region.note(outcome.error, seconds)
            if outcome.error is not None:
                self._errors.add(outcome.error, seconds)
        if not self._is_there(view):
            return
        # On the way to where it drives a strategy is not told of looks: they are no part of a stay.
        if region is not None:
            self.strategy.update(_offered_beside(view, region), outcome)
        self._choose()

    def _is_there(self, view: Viewpoint) -> bool:
        """Tell whether to choose anew; advice is given anew after every look."""
        if self._drive is None or self._target is None:
            return True
        return view.index == self._target.index

    def _choose(self) -> None:
        pinned = self._pinned
        if pinned is None:
            self._head_for(self.strategy.choose())
            return
        views = self._regions[pinned].views
        self._n_pinned += 1
        self._head_for(views[self._n_pinned % len(views)])

    def _head_for(self, view: Viewpoint) -> None:
        self._target = view
        if self._drive is not None:
            self._drive.go_to(view.index)

    @property
    def goal(self) -> int | None:
        """The region to go to; None before the first look."""
        if self._pinned is not None:
            return self._pinned
        decision = self._decision()
        if self._drive is None and decision is not None:
            return decision.chosen
        return None if self._target is None else self._target.region

    def _decision(self) -> Decision | None:
        return self.strategy.reasons() if isinstance(self.strategy, Explains) else None

    def target(self) -> Viewpoint | None:
        """Return the view to go to, in the region `goal`."""
        return self._target

    def why(self) -> dict[str, Any] | None:
        """Return why `goal`, JSON-able, as the page tells it; None before there is one."""
        with self.telling:
            return self._why()

    def _why(self) -> dict[str, Any] | None:
        goal = self.goal
        if goal is None:
            return None
        decision = self._decision()
        candidates = () if decision is None else decision.candidates
        if self._pinned is not None:
            text = PINNED
        elif decision is None or decision.chosen != goal:
            text = self._first_reason(goal)
        else:
            text = decision.text or UNTOLD
        return {
            "chosen": goal,
            "text": text,
            "candidates": [
                {
                    "region": one.region,
                    "expected_gain": plain(one.expected_gain),
                    "seconds": plain(one.seconds),
                    "score": plain(one.score),
                }
                for one in candidates
            ],
        }

    def _first_reason(self, goal: int) -> str:
        """Say why where the strategy has not decided between regions, or does not tell."""
        if self.n_looks < 1 or self._regions[goal].n_looks < 1:
            return NOTHING_KNOWN
        return BEGUN

    def regions(self) -> list[dict[str, Any]]:
        """Return what is known of each region, JSON-able."""
        with self.telling:
            return [region.state() for region in self._regions.values()]

    def curves(self) -> dict[str, Any]:
        """Return (seconds, value) curves: the error of all looks, and each region's, JSON-able."""
        with self.telling:
            regions = [region.curves() for region in self._regions.values()]
            return {"error": self._errors.curve(), "regions": regions}


def _offered(views: Sequence[Viewpoint], n_views: int) -> tuple[Viewpoint, ...]:
    """Return the views to choose from: so many of those in regions, of each region one at least."""
    inside = [view for view in views if view.region >= 0]
    if not inside:
        raise ValueError("views: expected at least one in a region, got none")
    chosen = np.unique(np.linspace(0, len(inside) - 1, min(n_views, len(inside))).round())
    first_of = {view.region: view for view in reversed(inside)}
    offered = [*(inside[int(number)] for number in chosen), *first_of.values()]
    by_index = {view.index: view for view in offered}
    return tuple(by_index[index] for index in sorted(by_index))


def _offered_beside(view: Viewpoint, region: RegionRecord) -> Viewpoint:
    """Return the view that the strategy knows for a view: itself, or the next by number."""
    return min(region.views, key=lambda offered: abs(offered.index - view.index))
