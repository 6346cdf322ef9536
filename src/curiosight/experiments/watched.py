"""What a watch has come to, and what each look adds to it: as it is kept, and gone on with."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

from curiosight.experiments.handing_on import RecentLooks
from curiosight.experiments.problems import Lessons, Problems, Trouble
from curiosight.explorer.outcome import Outcome, Readings
from curiosight.learner.drift import Alarm, Event
from curiosight.learner.lesson import Taught
from curiosight.robot.gauges import Ages, Counts
from curiosight.robot.watch import N_EVENTS, Look
from curiosight.teacher.cloud.tracking import UpTracker
from curiosight.teacher.memory.temporal import Remembered


@dataclass(frozen=True, slots=True, eq=False)
class LookRecord:
    """All that a look changed, as a journal holds it.

    seconds: since the first map. index: of the view, see `Shot`. outcome: without what was seen,
    which readings tell. pinned: the region that was, by hand. taught: None = nothing was to be
    learned. verdict: the number of what the teacher said. noted: what the frame changed of the
    teacher's memory. counts: after the look. alarm: see `Look`.
    """

    number: int
    seconds: float
    index: int | None
    outcome: Outcome
    readings: Readings | None
    pinned: int | None
    n_regrown: int
    taught: Taught | None
    trouble: Trouble
    verdict: int
    noted: Remembered | UpTracker | None
    counts: Counts
    alarm: Alarm | None

    @classmethod
    def of(cls, look: Look, pinned: int | None, counts: Counts) -> Self:
        """Return what is kept of a look."""
        verdict, shot = look.verdict, look.verdict.shot
        seen, taught = look.outcome.seen, look.taught
        return cls(
            look.number,
            look.seconds,
            shot.index,
            replace(look.outcome, seen=None),
            None if seen is None else seen.readings,
            pinned,
            look.n_regrown,
            None if taught is None else taught.without_rest(),
            Trouble.of(shot.frame, verdict.segmentation),
            verdict.number,
            verdict.noted,
            replace(counts, taught=verdict.number),  # its teacher may be ahead
            look.alarm,
        )

    def heard(self) -> Outcome:
        """Return what a strategy heard of the look."""
        seen = None if self.readings is None else self.readings.seen()
        return replace(self.outcome, seen=seen)


@dataclass(slots=True)
class Watched:
    """What a watch has come to.

    n_looks: as rows of the table. ids: of frames that were learned from and come again. index: of
    the view that was looked at last; None = none, or it is no view. events: the last `N_EVENTS`.
    """

    n_looks: int = 0
    problems: Problems = field(default_factory=Problems)
    lessons: Lessons = field(default_factory=Lessons)
    ids: dict[str, None] = field(default_factory=dict)
    has_learned: bool = False
    index: int | None = None
    looks: RecentLooks = field(default_factory=RecentLooks)
    counts: Counts = field(default_factory=Counts)
    ages: Ages = field(default_factory=Ages)
    events: tuple[Event, ...] = ()

    def add(self, record: LookRecord, *, comes_again: bool, is_learning: bool) -> None:
        """Count a look. comes_again: the frames are a recording's, not ever new ones."""
        self.n_looks = record.number + 1
        self.counts, self.index = record.counts, record.index
        if record.alarm is not None:
            event = Event(record.number, record.trouble.id, record.alarm)
            self.events = (*self.events, event)[-N_EVENTS:]
        if record.index is not None:
            outcome = record.outcome
            self.looks.add(record.index, outcome.error, has_changed=outcome.has_changed)
        if comes_again:
            self.problems.note(record.trouble)
        if is_learning:
            self.lessons.note(record.trouble.nothing)
        if record.taught is not None:
            self.has_learned |= record.n_regrown > 0
            if comes_again:
                self.ids[record.trouble.id] = None
