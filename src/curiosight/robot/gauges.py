"""How often, how old, how it went: measured while it runs, in memory that does not grow."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

WINDOW_S = 5.0
# Ages are counted by whole milliseconds up to this.
MOST_MS = 10_000


@dataclass(frozen=True, slots=True)
class Counts:
    """What a watch has counted: seconds since the first map, maps, looks, those learned from.

    missed: frames that were overtaken before they were asked for. taught: that were labelled.
    """

    seconds: float = 0.0
    maps: int = 0
    looks: int = 0
    lessons: int = 0
    missed: int = 0
    taught: int = 0


class Rate:
    """How many a second, over the last five; None before the first."""

    def __init__(self, clock: Callable[[], float], window_s: float = WINDOW_S) -> None:
        self._clock, self._window_s = clock, window_s
        self._lock = threading.Lock()
        self._times: deque[float] = deque()
        self._started: float | None = None
        self.n = 0

    def start(self) -> None:
        """Count from now on; the first `note` does so, too."""
        with self._lock:
            self._started = self._clock()

    def note(self) -> None:
        """Count one."""
        now = self._clock()
        with self._lock:
            if self._started is None:
                self._started = now
            self._times.append(now)
            self.n += 1
            self._forget(now)

    def per_second(self) -> float | None:
        now = self._clock()
        with self._lock:
            if self._started is None:
                return None
            self._forget(now)
            passed_s = min(self._window_s, now - self._started)
            return len(self._times) / passed_s if passed_s > 0 else 0.0

    def _forget(self, now: float) -> None:
        while self._times and self._times[0] <= now - self._window_s:
            self._times.popleft()


class Ages:
    """Count ages by the millisecond, so that percentiles of any number of them can be told."""

    def __init__(self) -> None:
        self._counts = np.zeros(MOST_MS + 1, np.int64)

    def note(self, seconds: float) -> None:
        self._counts[min(MOST_MS, max(0, round(1000 * seconds)))] += 1

    def percentile_ms(self, percent: float) -> int | None:
        """Return the age, milliseconds, that so many percent do not exceed; None of none."""
        if not 0 < percent <= 100:
            raise ValueError(f"percent: expected more than 0, up to 100, got {percent}")
        upto = np.cumsum(self._counts)
        if not upto[-1]:
            return None
        return int(np.searchsorted(upto, percent / 100 * upto[-1]))


class Curve:
    """A curve of any length in so many points: as it grows each becomes the mean of two."""

    def __init__(self, most: int = 400) -> None:
        if most < 2 or most % 2:
            raise ValueError(f"most: expected an even number from 2, got {most}")
        self._most = most
        self._points: list[tuple[float, float]] = []
        self._per_point = 1
        # Of the point that is not whole yet: how many, and their sums.
        self._n, self._sum_x, self._sum_y = 0, 0.0, 0.0

    def add(self, x: float, y: float) -> None:
        self._n, self._sum_x, self._sum_y = self._n + 1, self._sum_x + x, self._sum_y + y
        if self._n < self._per_point:
            return
        self._points.append((self._sum_x / self._n, self._sum_y / self._n))
        self._n, self._sum_x, self._sum_y = 0, 0.0, 0.0
        if len(self._points) == self._most:
            pairs = zip(self._points[::2], self._points[1::2], strict=True)
            self._points = [((x + u) / 2, (y + v) / 2) for (x, y), (u, v) in pairs]
            self._per_point *= 2

    def points(self) -> list[tuple[float, float]]:
        """Return (x, y) of each point, oldest first."""
        return list(self._points)


class Governor:
    """How long learning rests after each frame, so that maps are in time.

    Each map that is late makes it longer, each in time shorter. late_s: from which age on a map is
    late. most_s: of a rest: on a machine that is too slow for the maps alone learning goes on, too.
    """

    def __init__(self, *, late_s: float = 0.05, most_s: float = 1.0) -> None:
        self._late_s, self._most_s = late_s, most_s
        self.rest_s = 0.0

    def note(self, age_s: float) -> None:
        """Take note of how old a map's frame was when the map was made."""
        if age_s > self._late_s:
            self.rest_s = min(self._most_s, 1.3 * self.rest_s + 0.01)
        else:
            self.rest_s = 0.9 * self.rest_s if self.rest_s > 1e-3 else 0.0
