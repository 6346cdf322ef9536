"""Watch a live source: map its newest frame at once, and learn from what time is left."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from curiosight.explorer.outcome import Outcome, Seen
from curiosight.learner.description import Saliency, fit_labels, sight_of
from curiosight.learner.drift import Alarm, Event
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.lesson import Taught
from curiosight.learner.observation import Teaches
from curiosight.robot.advice import Advice
from curiosight.robot.feed import Feed, Shot
from curiosight.robot.gauges import Ages, Counts, Governor, Rate
from curiosight.robot.newest import Newest
from curiosight.robot.told import Told, Verdict
from curiosight.teacher import TemporalTeacher

# Threads look so often whether they are to end.
TICK_S = 0.1
# So many of the last alarms are remembered.
N_EVENTS = 20
# What teaches and learns gives way to what maps: steps of niceness, where the system knows them.
NICER = 5


@dataclass(frozen=True, slots=True, eq=False)
class Mapped:
    """The newest map: of which frame, and when it was made."""

    shot: Shot
    saliency: Saliency
    made_at: float


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """A frame that was compared with what its teacher says. number: from 0; error: eq. (1).

    seconds: since the first map. n_regrown: trees; 0 where nothing was learned. outcome: what a
    strategy hears of it. taught: see `Observation`; None where nothing was to be learned. alarm:
    its place is no longer what was learned of it.
    """

    number: int
    seconds: float
    verdict: Verdict
    error: float | None
    n_regrown: int
    outcome: Outcome = field(default_factory=Outcome)
    taught: Taught | None = None
    alarm: Alarm | None = None


class Watch:
    """Three threads: maps of the newest frame; what its teacher says; comparing and learning.

    learner: maps, while it learns; its forest is swapped in whole (see `SaliencyLearner`).
    teacher: labels frames; None = there is no depth, and nothing is compared or learned.
    advice: is told each look; None = nobody wants to know where to go.
    on_look: is called in the learning thread after each look; on_map in the mapping thread.
    settle: adds to a frame, in the teacher's thread, what was not known yet when it was mapped;
        None = nothing is to be added.

    `start` it, ask `failure` now and then, and `stop` it. Whatever went wrong in a thread ends
    all, and is `failure`.
    """

    def __init__(
        self,
        learner: SaliencyLearner,
        feed: Feed,
        teacher: Teaches | None,
        *,
        is_learning: bool = True,
        advice: Advice | None = None,
        on_look: Callable[[Look], None] | None = None,
        on_map: Callable[[Mapped], None] | None = None,
        settle: Callable[[Shot], Shot] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if is_learning and teacher is None:
            raise ValueError("teacher: expected one to learn from, got None")
        self.learner, self.advice = learner, advice
        self.teacher = teacher
        self.is_learning = is_learning
        self._told = Told()
        learner.teacher = self._told
        self._feed, self._clock, self._on_look = feed, clock, on_look
        self._on_map, self._settle = on_map, settle
        self._governor = Governor()
        self._to_teach, self._to_learn = Newest[Shot](), Newest[Verdict]()
        self.mapped: Mapped | None = None
        self.verdict: Verdict | None = None
        self.maps, self.looks, self.lessons = Rate(clock), Rate(clock), Rate(clock)
        self.ages = Ages()
        self.first_at: float | None = None
        self._learned_at: float | None = clock() if learner.is_trained else None
        self.is_paused = self.is_frozen = False
        self.failure: BaseException | None = None
        # The last alarms; replaced as a whole, for others read it.
        self.events: tuple[Event, ...] = ()
        self._is_over = threading.Event()
        # Held while the model changes, by learning or by who reads all of it; and so is the other
        # while the teacher's memory may.
        self.learning, self.teaching = threading.Lock(), threading.Lock()
        self.n_taught = 0
        self._before = Counts()
        jobs = [("maps", self._map_next)]
        if teacher is not None:
            jobs += [("teacher", self._teach_next), ("learner", self._learn_next)]
        self._threads = [
            threading.Thread(target=self._repeat, args=job, name=job[0], daemon=True)
            for job in jobs
        ]

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End all threads, each after what it has under way; may be called twice."""
        self._is_over.set()
        for thread in self._threads:
            if thread.ident is not None:
                thread.join()
        self._feed.close()

    @property
    def is_over(self) -> bool:
        return self._is_over.is_set()

    def wait(self, timeout_s: float) -> bool:
        """Wait; tell whether it is over, because something failed or it was stopped."""
        return self._is_over.wait(timeout_s)

    def seconds(self) -> float | None:
        """Return the seconds since the first map, with those before `go_on`; None before it."""
        if self.first_at is None:
            return None
        return self._before.seconds + self._clock() - self.first_at

    def counts(self) -> Counts:
        """Return what was counted so far."""
        return Counts(
            self.seconds() or self._before.seconds,
            self.maps.n,
            self.looks.n,
            self.lessons.n,
            self._before.missed + self._feed.n_missed,
            self.n_taught,
        )

    def go_on(self, before: Counts, ages: Ages, events: tuple[Event, ...] = ()) -> None:
        """Count on from what another watch had come to; before `start`."""
        self._before, self.ages, self.n_taught = before, ages, before.taught
        self.events = events
        for rate, n in zip(
            (self.maps, self.looks, self.lessons),
            (before.maps, before.looks, before.lessons),
            strict=True,
        ):
            rate.n = n

    @property
    def map_age_s(self) -> float | None:
        """How long ago the frame was taken of which the newest map is."""
        return None if self.mapped is None else self._clock() - self.mapped.shot.taken_at

    @property
    def model_age_s(self) -> float | None:
        """How long ago the model was loaded or last changed; None while it knows nothing."""
        return None if self._learned_at is None else self._clock() - self._learned_at

    @property
    def n_dropped(self) -> int:
        """How many frames came that were not compared with their teacher, nor learned from."""
        return max(0, self.maps.n + self._before.missed + self._feed.n_missed - self.looks.n)

    def _repeat(self, name: str, job: Callable[[], None]) -> None:
        if name != "maps":
            _give_way()
        try:
            while not self._is_over.is_set():
                job()
        except BaseException as error:  # told to whoever asks for `failure`
            self.failure = self.failure or error
            self._is_over.set()

    def _map_next(self) -> None:
        if self.is_paused:
            self._is_over.wait(TICK_S)
            return
        shot = self._feed.newest(TICK_S)
        if shot is None:
            return
        saliency = self.learner.saliency(shot.frame.rgb, shot.frame.T_world_camera)
        now = self._clock()
        if self.first_at is None:
            self.first_at = now
            for rate in (self.maps, self.looks, self.lessons):
                rate.start()
        self.mapped = Mapped(shot, saliency, now)
        self.maps.note()
        self.ages.note(now - shot.taken_at)
        self._governor.note(now - shot.taken_at)
        if self._on_map is not None:
            self._on_map(self.mapped)
        if self.teacher is not None:
            self._to_teach.put(shot)

    def _teach_next(self) -> None:
        # One ahead of the learner at most: what a teacher says is not made to be thrown away.
        if not self._to_learn.is_empty or self.is_paused:
            self._is_over.wait(0.005)
            return
        shot = self._to_teach.take(TICK_S)
        if shot is None or self.teacher is None:
            return
        if self._settle is not None:
            shot = self._settle(shot)
        with self.teaching:
            segmentation, teacher = self.teacher.segment(shot.frame), self.teacher
            self.n_taught += 1
            noted = teacher.noted if isinstance(teacher, TemporalTeacher) else None
            verdict = Verdict(shot, segmentation, self.n_taught, noted)
        self.verdict = verdict
        self._to_learn.put(verdict)
        self._is_over.wait(self._governor.rest_s)

    def _learn_next(self) -> None:
        if self.is_paused:
            self._is_over.wait(TICK_S)
            return
        verdict = self._to_learn.take(TICK_S)
        if verdict is None:
            return
        frame = verdict.shot.frame
        if self.is_learning and not self.is_frozen:
            with self.learning, self._told.says(verdict):
                observation = self.learner.observe(frame)
            change, taught = observation.change, observation.taught
            n_regrown, alarm = change.n_regrown, change.alarm
            outcome = Outcome.of(observation, 0.0)
            self.lessons.note()
            if n_regrown:
                self._learned_at = self._clock()
        else:
            n_regrown, taught, alarm, outcome = 0, None, None, self._compare(verdict)
        seconds, n = self.seconds() or 0.0, self.looks.n
        look = Look(n, seconds, verdict, outcome.error, n_regrown, outcome, taught, alarm)
        if alarm is not None:
            self.events = (*self.events, Event(look.number, frame.id, alarm))[-N_EVENTS:]
        self.looks.note()
        if self.advice is not None:
            self.advice.look(verdict.shot.index, outcome, look.seconds)
        if self._on_look is not None:
            self._on_look(look)
        self._is_over.wait(self._governor.rest_s)

    def _compare(self, verdict: Verdict) -> Outcome:
        """Return what a look tells by the model as it is."""
        frame, labels = verdict.shot.frame, verdict.segmentation.labels
        description = self.learner.describe(frame.rgb)
        counts = description.count(fit_labels(labels, description))
        sight = sight_of(description, frame.T_world_camera)
        error = self.learner.error_of(description.rows, counts, sight)
        return Outcome(error, seen=Seen.of(frame, labels))

    def model_do(self, job: Callable[[SaliencyLearner], Any]) -> Any:
        """Do something with the model while nothing changes it."""
        with self.learning:
            return job(self.learner)


def _give_way() -> None:
    """Let this thread, and those that it starts, stand back behind what maps."""
    with suppress(OSError, AttributeError):
        thread = threading.get_native_id()
        nice = os.getpriority(os.PRIO_PROCESS, thread)
        os.setpriority(os.PRIO_PROCESS, thread, min(19, nice + NICER))
