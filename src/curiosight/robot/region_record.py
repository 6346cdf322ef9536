"""What is known of a region by its looks: how many, the last errors, and curves of all of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import isfinite
from typing import Any

from curiosight.explorer.progress import learning_progress
from curiosight.frame import Viewpoint
from curiosight.robot.gauges import Curve

# Looks whose errors say how a region is known, and whether that gets better.
N_RECENT = 15


class RecentErrors:
    """The last errors, and the curve of their mean."""

    def __init__(self) -> None:
        self._recent: deque[float] = deque(maxlen=N_RECENT)
        self._curve = Curve()

    def add(self, error: float, seconds: float) -> None:
        self._recent.append(error)
        self._curve.add(seconds, sum(self._recent) / len(self._recent))

    @property
    def mean(self) -> float | None:
        return sum(self._recent) / len(self._recent) if self._recent else None

    def progress(self) -> float | None:
        """Return by how much the errors fall a look; None = not known yet."""
        return learning_progress(list(self._recent), theta=N_RECENT)

    def curve(self) -> list[tuple[float, float]]:
        """Return (seconds, mean error), as JSON has it."""
        return _rounded(self._curve)


class RegionRecord:
    """A region and its looks. views: those of it that can be chosen."""

    def __init__(self, number: int, name: str, views: Sequence[Viewpoint]) -> None:
        self.number, self.name, self.views = number, name, tuple(views)
        self.n_looks = 0
        self._errors, self._progress = RecentErrors(), Curve()

    def note(self, error: float | None, seconds: float) -> None:
        """Count a look, with its error where one is known."""
        self.n_looks += 1
        if error is None:
            return
        self._errors.add(error, seconds)
        progress = self._errors.progress()
        if progress is not None:
            self._progress.add(seconds, progress)

    def state(self) -> dict[str, Any]:
        """Return what is known of it, as `/state.json` tells it."""
        return {
            "id": self.number,
            "name": self.name,
            "n_looks": self.n_looks,
            "error": plain(self._errors.mean),
            "progress": plain(self._errors.progress()),
        }

    def curves(self) -> dict[str, Any]:
        """Return its curves, as `/live.json` tells them."""
        return {
            "id": self.number,
            "error": self._errors.curve(),
            "progress": _rounded(self._progress),
        }


def plain(number: float | None) -> float | None:
    """Return a number as JSON has it: what is not finite is not known."""
    return None if number is None or not isfinite(number) else round(float(number), 6) + 0.0


def _rounded(curve: Curve) -> list[tuple[float, float]]:
    return [(round(x, 2), round(y, 4)) for x, y in curve.points()]
