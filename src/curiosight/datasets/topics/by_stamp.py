"""The last messages of a topic by their stamps."""

from __future__ import annotations

import threading
from bisect import bisect_left
from typing import Generic, TypeVar

Item = TypeVar("Item")
N_KEPT = 40
# Stamps that jump back farther than this are of another clock, or a recording begins again.
RESTART_NS = 2_000_000_000


class ByStamp(Generic[Item]):
    """Keep the last items by stamp; several threads may ask and add."""

    def __init__(self, n_kept: int = N_KEPT) -> None:
        if n_kept < 1:
            raise ValueError(f"n_kept: expected 1 or more, got {n_kept}")
        self._n_kept = n_kept
        self._stamps: list[int] = []
        self._items: list[Item] = []
        self._changed = threading.Condition()

    def add(self, stamp_ns: int, item: Item) -> None:
        with self._changed:
            if self._stamps and stamp_ns < self._stamps[-1] - RESTART_NS:
                self._stamps.clear()
                self._items.clear()
            place = bisect_left(self._stamps, stamp_ns)
            self._stamps.insert(place, stamp_ns)
            self._items.insert(place, item)
            del self._stamps[: -self._n_kept], self._items[: -self._n_kept]
            self._changed.notify_all()

    def nearest(self, stamp_ns: int) -> tuple[int, Item] | None:
        """Return the stamp and item that are nearest in time; None of none."""
        with self._changed:
            return self._nearest(stamp_ns)

    def await_nearest(
        self, stamp_ns: int, max_gap_ns: int, wait_s: float
    ) -> tuple[int, Item] | None:
        """Return the nearest within `max_gap_ns`, and wait for it as long as it may yet come.

        None where there is none: a later one has come, or nothing in time.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._is_settled(stamp_ns), wait_s)
            found = self._nearest(stamp_ns)
        is_near = found is not None and abs(found[0] - stamp_ns) <= max_gap_ns
        return found if is_near else None

    @property
    def newest(self) -> int | None:
        """The latest stamp."""
        with self._changed:
            return self._stamps[-1] if self._stamps else None

    def _is_settled(self, stamp_ns: int) -> bool:
        if not self._stamps:
            return False
        # Another clock will not catch up.
        return self._stamps[-1] >= stamp_ns or self._stamps[-1] < stamp_ns - RESTART_NS

    def _nearest(self, stamp_ns: int) -> tuple[int, Item] | None:
        if not self._stamps:
            return None
        after = bisect_left(self._stamps, stamp_ns)
        places = range(max(0, after - 1), min(len(self._stamps), after + 1))
        best = min(places, key=lambda place: abs(self._stamps[place] - stamp_ns))
        return self._stamps[best], self._items[best]
