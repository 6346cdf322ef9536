"""When a place is no longer what was learned of it, and by what that is known."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from itertools import islice
from typing import Any, Literal

from curiosight.learner.rise import Rise
from curiosight.learner.scenery import Signs

Cause = Literal["light", "tint", "gone", "new", "errors"]
CAUSES: tuple[Cause, ...] = ("light", "tint", "gone", "new", "errors")
# The mean evidence of an alarm. Where numbers are independent, of whatever distribution, one alarm
# in 35 000 frames is false: ranks alone count, so that drawing them tells (`tests/test_drift.py`).
ALARM = 3_000.0
# What each says, by how it was and how it is.
_SAID: dict[Cause, str] = {
    "light": "light changed: parts of a view are brighter or darker than before by {now:.0%}, "
    "usually by {was:.0%}",
    "tint": "light changed: views are redder or bluer than before by {now:.0%}, usually by "
    "{was:.0%}",
    "gone": "objects moved: {now:.0%} of what stood in view is gone, usually {was:.0%}",
    "new": "new things: {now:.0%} of what is salient stands where nothing stood, usually {was:.0%}",
    "errors": "new things: errors are {now:.2f}, usually {was:.2f}",
}


@dataclass(frozen=True, slots=True)
class Alarm:
    """A place is no longer what was learned of it.

    place: its number, -1 where there is one only. cause: the sign that says so most. was, now: its
    mean before and since it rose. n_looks: at the place since then.
    """

    place: int
    cause: Cause
    was: float
    now: float
    n_looks: int

    @property
    def reason(self) -> str:
        """Say it to a person."""
        return _SAID[self.cause].format(was=self.was, now=self.now)

    def summary(self) -> dict[str, Any]:
        """Return it, JSON-able."""
        rounded = {"was": round(self.was, 6), "now": round(self.now, 6), "reason": self.reason}
        return asdict(self) | rounded


@dataclass(frozen=True, slots=True)
class Event:
    """An alarm, and when it came. look: its number, from 0. id: of its frame."""

    look: int
    id: str
    alarm: Alarm

    @property
    def sentence(self) -> str:
        """Say it to a person; places are counted from 0."""
        where = "" if self.alarm.place < 0 else f", place {self.alarm.place}"
        return f"look {self.look}{where}: {self.alarm.reason} ({self.id})"

    def summary(self) -> dict[str, Any]:
        """Return it, JSON-able."""
        return {"look": self.look, "id": self.id, **self.alarm.summary()}


@dataclass(slots=True)
class Drift:
    """Tests, for one place, whether signs of change have risen.

    Each sign has a `Rise` of its own. It is the mean of their evidence that must exceed `ALARM`: it
    too grows by one a frame on average while nothing changes.
    """

    rises: dict[Cause, Rise] = field(default_factory=lambda: {cause: Rise() for cause in CAUSES})

    def add(self, place: int, signs: Signs, error: float | None) -> Alarm | None:
        """Take in what a look at the place tells, and tell whether it has changed; then forget."""
        told = (signs.light, signs.tint, signs.gone, signs.new, error)
        for rise, number in zip(self.rises.values(), told, strict=True):
            if number is not None:
                rise.add(number)
        evidence = {cause: rise.evidence for cause, rise in self.rises.items()}
        if sum(evidence.values()) < ALARM * len(CAUSES):
            return None
        cause = max(CAUSES, key=lambda one: evidence[one])
        alarm = _alarm(place, cause, self.rises[cause])
        self.rises = {one: Rise() for one in CAUSES}
        return alarm


def _alarm(place: int, cause: Cause, rise: Rise) -> Alarm:
    n_before = len(rise.known) - rise.n_since
    was = list(islice(rise.known, n_before))
    now = list(islice(rise.known, n_before, None))
    return Alarm(place, cause, sum(was) / max(1, len(was)), sum(now) / len(now), rise.n_since)
