"""Hand what is new of a watch to a sink, so that what maps and learns never waits for it."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from curiosight.frame import Viewpoint
from curiosight.robot.sinks.sink import Moment, Sink
from curiosight.robot.state import Subject
from curiosight.robot.told import Verdict
from curiosight.robot.watch import Mapped, Watch

# Moments a second at most: pictures of every frame would fill a disk.
RATE_HZ = 5.0
# So many looks may wait for a sink that is busy; those that come then are lost.
N_WAITING = 1000


class Recorder:
    """Give a sink the newest map and verdict now and then, and all looks, in a thread of its own.

    subject: tells the state. clock: the feed's. A sink that fails is closed and given no more:
    `problem` says why.
    """

    def __init__(
        self,
        watch: Watch,
        subject: Subject,
        sink: Sink,
        *,
        rate_hz: float = RATE_HZ,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.sink = sink
        self.problem: str | None = None
        self.n_maps = self.n_looks = 0
        self._n_noted = 0
        self._watch, self._subject, self._clock = watch, subject, clock
        self._period_s = 1 / rate_hz
        self._looks: queue.Queue[Mapping[str, Any]] = queue.Queue(N_WAITING)
        self._mapped: Mapped | None = None
        self._verdict: Verdict | None = None
        self._is_over = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self, title: str, views: Sequence[Viewpoint]) -> None:
        """Begin; see `Sink.begin`."""
        # A daemon, so that an interrupted program does not wait for it.
        self._thread = threading.Thread(
            target=self._run, args=(title, views), name="recorder", daemon=True
        )
        self._thread.start()

    def note(self, look: Mapping[str, Any]) -> None:
        """Take note of a look, without waiting: its columns of looks.csv."""
        self._n_noted += 1
        with suppress(queue.Full):
            self._looks.put_nowait(look)

    def stop(self) -> None:
        """Write what is left, and close the sink; may be called twice."""
        self._is_over.set()
        if self._thread is not None:
            self._thread.join()

    def counts(self) -> dict[str, int]:
        """Return how much was written, and how much of all there was is not there."""
        return {
            "maps": self.n_maps,
            "maps_left_out": self._watch.maps.n - self.n_maps,
            "looks": self.n_looks,
            "looks_lost": self._n_noted - self.n_looks,
        }

    def _run(self, title: str, views: Sequence[Viewpoint]) -> None:
        try:
            try:
                self.sink.begin(title, views)
                while not self._is_over.wait(self._period_s):
                    self._write()
                self._write()
            finally:
                self.sink.close()
        except Exception as error:  # a full disk, a viewer that was closed: the watch goes on
            self.problem = str(error) or type(error).__name__

    def _write(self) -> None:
        """Write what is new, if anything is."""
        mapped, verdict = self._watch.mapped, self._watch.verdict
        looks = []
        with suppress(queue.Empty):
            while True:
                looks.append(self._looks.get_nowait())
        new_map = None if mapped is self._mapped else mapped
        new_verdict = None if verdict is self._verdict else verdict
        if new_map is None and new_verdict is None and not looks:
            return
        now_ns = time.time_ns()
        zero_ns = now_ns - round(1e9 * self._clock())
        state = self._subject.state()
        self.sink.write(Moment(now_ns, zero_ns, state, new_map, new_verdict, looks))
        self._mapped, self._verdict = mapped, verdict
        self.n_maps += new_map is not None
        self.n_looks += len(looks)
