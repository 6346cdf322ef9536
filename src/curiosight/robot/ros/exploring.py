"""Explore until the error stops falling, then go home: which goal, and what became of it."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

from curiosight.explorer import Strategy
from curiosight.explorer.decision import Explains
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Viewpoint
from curiosight.robot.ros.falling import Falling
from curiosight.robot.ros.goals import Place
from curiosight.robot.ros.squares import Squares

# What a new strategy is told again of, where goals are left alone.
N_REMEMBERED = 400
# Goals in a row at which nothing was compared: more will not help.
MOST_BLIND = 5
# A goal that others cancelled is tried so often.
N_TRIES = 2
MakeStrategy = Callable[[tuple[Viewpoint, ...]], Strategy]


class Phase(StrEnum):
    CHOOSING = "choosing"
    ASKING = "asking"
    GOING = "going"
    LOOKING = "looking"
    OVER = "over"


class Reason(StrEnum):
    """Why it ended."""

    ERROR_STOPPED_FALLING = "the error has stopped falling"
    OUT_OF_TIME = "its time is up"
    NOWHERE_TO_GO = "there is nowhere left to go"
    CANCELED = "it was cancelled"
    NO_NAVIGATION = "there is no navigation"


class GoTo(NamedTuple):
    """A goal for the navigation. number: what its answers are told with."""

    number: int
    place: Place


class Stop(NamedTuple):
    """The goal of that number is to be given up."""

    number: int


@dataclass(frozen=True, slots=True)
class Rules:
    """looks: of a goal. answer_timeout_s: until a goal is taken or refused. goal_timeout_s: of a
    drive. look_timeout_s: to wait for a look there.

    max_s: no goal is set after so long; 0 = no limit. patience, min_fall: see `Falling`.
    """

    looks: int = 3
    answer_timeout_s: float = 10.0
    goal_timeout_s: float = 120.0
    look_timeout_s: float = 15.0
    max_s: float = 0.0
    patience: int = 60
    min_fall: float = 0.01


@dataclass(frozen=True, slots=True)
class Ending:
    """How it ended. is_home: the robot is back. text: in words."""

    reason: Reason
    is_home: bool
    text: str


class Exploring:
    """Decide where to go, hear what came of it, and end.

    views, stands: what to choose from, and where the robot stands for each. home: where to go at
    the end; None = to stay there. Ask `next` for what is to be done, now and then; tell the answers
    of the navigation by `answered` and `arrived`, and each look of the camera by `look`. One thread
    does all. Times are seconds of one clock.
    """

    def __init__(
        self,
        make_strategy: MakeStrategy,
        views: tuple[Viewpoint, ...],
        stands: Mapping[int, Place],
        squares: Squares,
        home: Place | None,
        rules: Rules,
        now: float,
    ) -> None:
        self._make, self._views, self._stands = make_strategy, views, stands
        self._squares, self.home, self.rules = squares, home, rules
        self._began_at = now
        self._falling = Falling(rules.patience, rules.min_fall)
        self._told: deque[tuple[Viewpoint, Outcome]] = deque(maxlen=N_REMEMBERED)
        self.left_alone: dict[int, str] = {}
        self._cancelled = Counter[int]()
        self._strategy: Strategy | None = None
        self._view: Viewpoint | None = None
        self._number = 0
        self._asked_at = self._arrived_at = now
        self._travel_s = 0.0
        self._looks: list[Outcome] = []
        self._n_blind = 0
        self._reason: Reason | None = None
        self._is_homing = False
        self.phase = Phase.CHOOSING
        self.n_reached = self.n_failed = 0
        self.travels: list[float] = []
        self.ending: Ending | None = None
        self._remake()

    @property
    def target(self) -> Viewpoint | None:
        """The view it goes to or looks at; None on the way home."""
        return None if self._is_homing else self._view

    def why(self) -> str:
        """Say why it goes where it goes."""
        if self._is_homing and self._reason is not None:
            return f"home, as {self._reason.value}"
        decision = self._strategy.reasons() if isinstance(self._strategy, Explains) else None
        if decision is not None and self._view and decision.chosen == self._view.region:
            return decision.text
        return "it looks around before it decides between regions"

    def next(self, now: float) -> GoTo | Stop | None:
        """Return what the navigation is to be told now; None = nothing."""
        if self.phase is Phase.CHOOSING:
            return self._choose(now)
        asked_s = now - self._asked_at
        if self.phase is Phase.ASKING and asked_s > self.rules.answer_timeout_s:
            self._failed(f"not answered in {self.rules.answer_timeout_s:g} s")
            return Stop(self._number)
        if self.phase is Phase.GOING and asked_s > self.rules.goal_timeout_s:
            self._failed(f"not reached in {self.rules.goal_timeout_s:g} s")
            return Stop(self._number)
        if self.phase is Phase.LOOKING and now - self._arrived_at > self.rules.look_timeout_s:
            self._looked()
        return None

    def answered(self, number: int, is_accepted: bool) -> None:
        """Hear whether the navigation takes a goal."""
        if number != self._number or self.phase is not Phase.ASKING:
            return
        if is_accepted:
            self.phase = Phase.GOING
        else:
            self._failed("refused by the navigation")

    def arrived(
        self, number: int, now: float, *, failure: str = "", by_others: bool = False
    ) -> None:
        """Hear the end of a drive. failure: what became of it; "" = it is there.

        by_others: somebody else gave the goal up; it is tried once more.
        """
        if number != self._number or self.phase not in (Phase.ASKING, Phase.GOING):
            return
        if failure:
            self._failed(failure, by_others=by_others)
            return
        self._travel_s = now - self._asked_at
        self.travels.append(self._travel_s)
        if self._is_homing:
            self._end(is_home=True)
            return
        self.n_reached += 1
        self.phase, self._arrived_at, self._looks = Phase.LOOKING, now, []

    def interrupted(self) -> None:
        """Hear that the navigation went away: what it was told is to be told again."""
        if self.phase in (Phase.ASKING, Phase.GOING):
            self._number += 1
            self.phase, self._is_homing = Phase.CHOOSING, False

    def look(self, region: int | None, outcome: Outcome, taken_at: float) -> None:
        """Hear of a frame that was compared. region: where it was taken; None = not known."""
        if region is not None and not self._is_homing:
            self._falling.note(region, self._squares.error())
        if self.phase is not Phase.LOOKING or taken_at < self._arrived_at:
            return
        self._looks.append(outcome)
        if len(self._looks) >= self.rules.looks:
            self._looked()

    def change_strategy(self, make: MakeStrategy) -> None:
        """Choose by another strategy from now on; it is told what was seen lately."""
        self._make = make
        self._remake()

    def cancel(self) -> Stop | None:
        """Give up, and stay where the robot is; return what the navigation is to be told."""
        return self._give_up(Reason.CANCELED)

    def lost_navigation(self) -> Stop | None:
        """Hear that there is nobody to drive."""
        return self._give_up(Reason.NO_NAVIGATION)

    def _give_up(self, reason: Reason) -> Stop | None:
        is_under_way = self.phase in (Phase.ASKING, Phase.GOING)
        self._reason = reason
        if self.phase is not Phase.OVER:
            self._end(is_home=False)
        return Stop(self._number) if is_under_way else None

    def _choose(self, now: float) -> GoTo | None:
        self._reason = self._reason or self._reason_to_end(now)
        if self._reason is None and self._strategy is not None:
            self._view = self._strategy.choose()
            return self._go_to(self._stands[self._view.index], now)
        if self.home is None or self._is_homing:
            self._end(is_home=False)
            return None
        self._is_homing = True
        return self._go_to(self.home, now)

    def _reason_to_end(self, now: float) -> Reason | None:
        if self._falling.has_stopped:
            return Reason.ERROR_STOPPED_FALLING
        if self.rules.max_s and now - self._began_at >= self.rules.max_s:
            return Reason.OUT_OF_TIME
        if self._strategy is None or self._n_blind >= MOST_BLIND:
            return Reason.NOWHERE_TO_GO
        return None

    def _go_to(self, place: Place, now: float) -> GoTo:
        self._number += 1
        self.phase, self._asked_at = Phase.ASKING, now
        return GoTo(self._number, place)

    def _failed(self, why: str, *, by_others: bool = False) -> None:
        """Leave all views from there alone, and choose among the others."""
        self.phase = Phase.CHOOSING
        self.n_failed += 1
        view = self._view
        if self._is_homing or view is None:
            self._end(is_home=False, lost=why)
            return
        self._cancelled[view.index] += by_others
        if by_others and self._cancelled[view.index] < N_TRIES:
            return
        stand = self._stands[view.index]
        for index, other in self._stands.items():
            if (other.x, other.y) == (stand.x, stand.y):
                self.left_alone[index] = why
        self._squares[view.region].left_alone = why
        self._remake()

    def _remake(self) -> None:
        """Make the strategy anew of what is not left alone, and tell it what was seen."""
        views = tuple(view for view in self._views if view.index not in self.left_alone)
        self._strategy = self._make(views) if views else None
        for view, outcome in self._told if self._strategy is not None else ():
            if view.index not in self.left_alone:
                self._strategy.choose()  # type: ignore[union-attr]
                self._strategy.update(view, outcome)  # type: ignore[union-attr]

    def _looked(self) -> None:
        """Tell the strategy of the looks at a goal, as one."""
        self.phase = Phase.CHOOSING
        if not self._looks:
            self._n_blind += 1
        if self._view is None or self._strategy is None:
            return
        if self._looks:
            self._n_blind = 0
        errors = [one.error for one in self._looks if one.error is not None]
        last = self._looks[-1] if self._looks else Outcome()
        outcome = replace(
            last,
            error=sum(errors) / len(errors) if errors else None,
            seconds=self._travel_s,
            has_changed=any(one.has_changed for one in self._looks),
            again=None,
        )
        self._told.append((self._view, outcome))
        self._strategy.update(self._view, outcome)

    def _end(self, *, is_home: bool, lost: str = "") -> None:
        self.phase = Phase.OVER
        assert self._reason is not None
        text = f"{self._reason.value}; {self.n_reached} goals reached, {self.n_failed} not"
        if self._reason is Reason.NOWHERE_TO_GO and self._n_blind >= MOST_BLIND:
            text += f"; at the last {self._n_blind} of them no frame could be compared"
        if lost:
            text += f"; the way home: {lost}"
        elif is_home:
            text += "; the robot is home"
        self.ending = Ending(self._reason, is_home, text)
