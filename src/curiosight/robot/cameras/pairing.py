"""Bring together what two streams of a camera saw at one moment."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

Item = TypeVar("Item")
N_KEPT = 4


class Pairing(Generic[Item]):
    """Pair colour with the depth nearest in time, each used once; old ones are let go.

    apart: how far apart two items are. tolerance: what is farther apart is no pair.
    """

    def __init__(self, apart: Callable[[Item, Item], float], tolerance: float) -> None:
        self._apart, self.tolerance = apart, tolerance
        self._waiting: tuple[deque[Item], deque[Item]] = (
            deque(maxlen=N_KEPT),
            deque(maxlen=N_KEPT),
        )

    def add(self, stream: int, item: Item) -> tuple[Item, Item] | None:
        """Take what stream 0 (colour) or 1 (depth) gave; return the pair that it completes."""
        others = self._waiting[1 - stream]
        if others:
            nearest = min(others, key=lambda other: self._apart(item, other))
            if self._apart(item, nearest) <= self.tolerance:
                for waiting in self._waiting:
                    waiting.clear()
                return (item, nearest) if stream == 0 else (nearest, item)
        self._waiting[stream].append(item)
        return None
