"""In which order recorded frames are replayed: round and round, or towards a goal."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import Self


def rounds(n_frames: int, first: int = 0) -> Iterator[int]:
    """Yield the numbers of frames in their order, again and again; first: where it begins."""
    if n_frames < 1:
        raise ValueError(f"n_frames: expected 1 or more, got {n_frames}")
    return (number % n_frames for number in count(first))


class Drive:
    """Drive along recorded frames to a goal, forwards or backwards, and wait there for the next.

    As long as there has been no goal it goes forwards, and turns at the ends. Iterate over it: it
    never ends. `go_to` may be called by another thread.
    """

    def __init__(self, n_frames: int) -> None:
        if n_frames < 1:
            raise ValueError(f"n_frames: expected 1 or more, got {n_frames}")
        self._n_frames = n_frames
        self._here = -1
        self._ahead = 1
        self._goal: int | None = None

    @property
    def goal(self) -> int | None:
        return self._goal

    def stand_at(self, number: int) -> None:
        """Begin from a frame; before it is iterated over."""
        self._here = range(self._n_frames)[number]

    def go_to(self, number: int) -> None:
        """Take a frame for the goal."""
        if not 0 <= number < self._n_frames:
            raise ValueError(f"number: expected 0 to {self._n_frames - 1}, got {number}")
        self._goal = number

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> int:
        """Return the next frame on the way; at the goal that frame again."""
        goal = self._goal
        if goal is not None and self._here >= 0:
            self._here += (goal > self._here) - (goal < self._here)
            return self._here
        if not 0 <= self._here + self._ahead < self._n_frames:
            self._ahead = -self._ahead
        self._here = min(max(self._here + self._ahead, 0), self._n_frames - 1)
        return self._here
