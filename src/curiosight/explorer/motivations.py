"""What makes a region worth a stay: progress, error, novelty, uncertainty, what was forgotten."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from curiosight.explorer.outcome import Outcome
from curiosight.explorer.progress import ProgressMeter, learning_progress

# Looks that an error or an uncertainty is the mean of, as in the authors' code.
N_SMOOTH = 30
# What of a region is remembered after each look elsewhere, as there.
REMEMBERED = 0.96
# Frames that a region keeps, to be scored again (the authors keep "up to ~10").
N_KEPT = 10


class Motivation(Protocol):
    """Measure of each region how much it draws."""

    def add(self, region: int, outcome: Outcome) -> None:
        """Take note of a look in a region."""
        ...

    def interest(self, region: int) -> float | None:
        """Return the interest in a region; None = not known yet, so as large as any."""
        ...


class Progress:
    """How fast the errors of a region fall (eq. 2-3), see `ProgressMeter`."""

    def __init__(self, meter: ProgressMeter) -> None:
        self._meter = meter

    def add(self, region: int, outcome: Outcome) -> None:
        self._meter.add(region, outcome.error)

    def interest(self, region: int) -> float | None:
        return self._meter.progress(region)


class BackwardProgress:
    """How fast the errors of the same few frames fall as the model changes.

    Each region keeps up to `N_KEPT` looks, replaced at random (a reservoir), and after every
    look all of them are scored again, so that neither a hard view nor what is learned
    elsewhere is mistaken for a change. Interest: minus the mean slope of the kept frames'
    own errors, over the last `theta` looks anywhere. The model has learned from these frames:
    their errors are too low, their fall is not.

    An outcome without `again` counts as a visit only, as one whose error is undefined.
    """

    def __init__(self, rng: np.random.Generator, *, theta: int = 15) -> None:
        if theta < 2:
            raise ValueError(f"theta: expected 2 or more, got {theta}")
        self._rng, self._theta = rng, theta
        self._kept: dict[int, list[_Kept]] = {}
        self._n_looks: dict[int, int] = {}

    def add(self, region: int, outcome: Outcome) -> None:
        self._n_looks[region] = self._n_looks.get(region, 0) + 1
        kept = self._kept.setdefault(region, [])
        if outcome.again is not None and outcome.error is not None:
            new = _Kept(outcome.again, self._theta)
            if len(kept) < N_KEPT:
                kept.append(new)
            elif (place := int(self._rng.integers(self._n_looks[region]))) < N_KEPT:
                kept[place] = new
        for one in (one for region in self._kept.values() for one in region):
            one.score()

    def interest(self, region: int) -> float | None:
        slopes = [learning_progress(list(one.errors)) for one in self._kept.get(region, ())]
        known = [slope for slope in slopes if slope is not None]
        if known:
            return float(np.mean(known))
        return 0.0 if self._n_looks.get(region, 0) >= self._theta else None


class _Kept:
    """A frame that is scored again, and its last errors."""

    def __init__(self, again: Callable[[], float | None], theta: int) -> None:
        self._again = again
        self.errors: deque[float] = deque(maxlen=theta)

    def score(self) -> None:
        error = self._again()
        if error is not None:
            self.errors.append(error)


class _Smoothed:
    """The mean of a number over the last `N_SMOOTH` looks in a region."""

    def __init__(self) -> None:
        self._values: dict[int, deque[float | None]] = {}

    def note(self, region: int, value: float | None) -> None:
        self._values.setdefault(region, deque(maxlen=N_SMOOTH)).append(value)

    def interest(self, region: int) -> float | None:
        values = self._values.get(region, ())
        known = [value for value in values if value is not None]
        # Where looks never told, as at a bare wall, there is nothing to hope for.
        return float(np.mean(known)) if known else (0.0 if len(values) > 1 else None)


class Error(_Smoothed):
    """The mean error of the last looks in a region."""

    def add(self, region: int, outcome: Outcome) -> None:
        self.note(region, outcome.error)


class Uncertainty(_Smoothed):
    """The mean uncertainty of the last looks in a region."""

    def add(self, region: int, outcome: Outcome) -> None:
        self.note(region, outcome.uncertainty)


class Novelty:
    """1 for the regions least looked at, 0 for all others."""

    def __init__(self, regions: Iterable[int]) -> None:
        self._n_looks = dict.fromkeys((region for region in regions if region >= 0), 0)

    def add(self, region: int, outcome: Outcome) -> None:
        self._n_looks[region] += 1

    def interest(self, region: int) -> float | None:
        return float(self._n_looks[region] == min(self._n_looks.values()))


class Forgetting:
    """1 - f: f is 1 after a look in a region, and falls to `REMEMBERED` of it at each elsewhere."""

    def __init__(self) -> None:
        self._n_looks = 0
        self._last: dict[int, int] = {}

    def add(self, region: int, outcome: Outcome) -> None:
        self._n_looks += 1
        self._last[region] = self._n_looks

    def interest(self, region: int) -> float | None:
        if region not in self._last:
            return None
        return float(1 - REMEMBERED ** (self._n_looks - self._last[region]))


class ProgressAndForgetting:
    """How much the errors of a region fell, and how long it was not looked at, as one number.

    (1 - a) 2/pi atan(theta |LP|) + a (1 - f), as in the authors' code; f as for `Forgetting`.
    LP is per look, so that theta LP is the fall over the window. What grows draws as what falls.

    progress: tells LP, over the last `theta` looks. forgetting_share: a, from 0 to 1.
    """

    def __init__(
        self, progress: Motivation, *, theta: int = 15, forgetting_share: float = 0.5
    ) -> None:
        if not 0 <= forgetting_share <= 1:
            raise ValueError(f"forgetting_share: expected 0 to 1, got {forgetting_share}")
        self._progress, self._theta, self._share = progress, theta, forgetting_share
        self._forgetting = Forgetting()

    def add(self, region: int, outcome: Outcome) -> None:
        self._progress.add(region, outcome)
        self._forgetting.add(region, outcome)

    def interest(self, region: int) -> float | None:
        progress, forgotten = self._progress.interest(region), self._forgetting.interest(region)
        if progress is None or forgotten is None:
            return None
        fall = 2 / np.pi * np.arctan(self._theta * abs(progress))
        return float((1 - self._share) * fall + self._share * forgotten)
