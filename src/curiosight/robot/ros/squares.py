"""Regions of the floor: squares, each with how well the views from there are known."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, field
from math import floor, isfinite

import numpy as np
import numpy.typing as npt

from curiosight.explorer.progress import learning_progress

# Looks whose errors say how a square is known, and whether that gets better.
N_RECENT = 15
UNKNOWN = -1


@dataclass(slots=True)
class Square:
    """A square of the floor. key: its number along x and y. left_alone: why it is not gone to."""

    key: tuple[int, int]
    n_looks: int = 0
    recent: deque[float] = field(default_factory=lambda: deque(maxlen=N_RECENT))
    left_alone: str = ""

    @property
    def name(self) -> str:
        return f"x{self.key[0]} y{self.key[1]}"

    @property
    def error(self) -> float | None:
        """Mean error of the last looks; None while none was compared."""
        return sum(self.recent) / len(self.recent) if self.recent else None

    @property
    def fall(self) -> float | None:
        """By how much the error falls over the last looks; None while that is not known."""
        slope = learning_progress(list(self.recent), theta=N_RECENT)
        return None if slope is None else slope * (len(self.recent) - 1)


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Values of squares, (H, W) int8 as an occupancy grid has them, and the place of its corner."""

    values: npt.NDArray[np.int8]
    size: float
    origin: tuple[float, float]


class Squares:
    """Squares of the floor by number, which never changes. Several threads may ask and note.

    size: of a square, metres.
    """

    def __init__(self, size: float) -> None:
        if not (isfinite(size) and size > 0):
            raise ValueError(f"size: expected metres, more than 0, got {size}")
        self.size = size
        self._numbers: dict[tuple[int, int], int] = {}
        self._squares: list[Square] = []
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._squares)

    def __getitem__(self, number: int) -> Square:
        return self._squares[number]

    def at(self, x: float, y: float) -> int:
        """Return the number of the square at a place, metres; a new one where there was none."""
        key = floor(x / self.size), floor(y / self.size)
        with self._lock:
            if key not in self._numbers:
                self._numbers[key] = len(self._squares)
                self._squares.append(Square(key))
            return self._numbers[key]

    def note(self, number: int, error: float | None) -> None:
        """Note the error of a look from a square; None = undefined."""
        with self._lock:
            square = self._squares[number]
            square.n_looks += 1
            if error is not None:
                square.recent.append(error)

    def error(self) -> float | None:
        """Return the mean of all squares' errors; None while there is none."""
        with self._lock:
            known = [square.error for square in self._squares]
        errors = [error for error in known if error is not None]
        return sum(errors) / len(errors) if errors else None

    def centre(self, number: int) -> tuple[float, float]:
        """Return the middle of a square, metres."""
        x, y = self._squares[number].key
        return (x + 0.5) * self.size, (y + 0.5) * self.size

    def grid(self) -> Grid | None:
        """Return by how much the error falls in each square, percent; -1 = not known."""
        with self._lock:
            falls = {square.key: square.fall for square in self._squares}
        if not falls:
            return None
        keys = np.array(list(falls))
        low, high = keys.min(axis=0), keys.max(axis=0)
        width, height = (high - low + 1).tolist()
        values = np.full((height, width), UNKNOWN, np.int8)
        for (x, y), fall in falls.items():
            if fall is not None:
                percent = min(100, max(0, round(100 * fall)))
                values[y - low[1], x - low[0]] = percent
        corner = low[0] * self.size, low[1] * self.size
        return Grid(values, self.size, (float(corner[0]), float(corner[1])))
