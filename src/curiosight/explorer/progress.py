"""Measure learning progress per region and turn it into chances to be chosen (eq. 1-3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

Negative = Literal["clip", "abs", "shift"]
Undefined = Literal["skip", "repeat"]
Floats = npt.NDArray[np.float64]

_NEGLIGIBLE = 1e-12  # a flat line's slope is not exactly 0 in floating point


def learning_progress(
    errors: Sequence[float], *, theta: int = 15, smoothing: int = 1, min_errors: int = 2
) -> float | None:
    """Return how fast the errors fall: minus the slope of a line through the last ones (eq. 2-3).

    The print fits no intercept, and its progress can never be positive; we fit one.

    theta: number of errors in the window (the print's sum runs over theta + 1: pass one more).
    smoothing: each error becomes the mean of up to that many that end in it; 1 = raw.
    min_errors: None, for not known yet, while there are fewer.
    """
    if len(errors) < max(min_errors, 2):
        return None
    values = moving_mean(errors[-(theta + smoothing - 1) :], smoothing)[-theta:]
    time = np.arange(len(values)) - (len(values) - 1) / 2
    return float(-(time @ values) / (time @ time))


def choice_probabilities(
    progress: Sequence[float | None],
    *,
    random_share: float = 0.25,
    exponent: float = 1.0,
    negative: Negative = "clip",
) -> Floats:
    """Return each region's chance to be chosen next: 75 % by progress, 25 % uniform (sec. II-B).

    progress: of every region within reach; None = not known yet: as interesting as the best.
        Where no region is of any interest, all have the same chance.
    exponent: of the interest; 1 = proportional, as in the paper.
    negative: what a growing error means. "clip": no interest, as in the paper; "abs": as much
        as a falling one, for worlds that change; "shift": interest counts from the lowest.
    """
    n_regions = len(progress)
    if not n_regions:
        raise ValueError("progress: expected at least one region, got none")
    if not 0 <= random_share <= 1:
        raise ValueError(f"random_share: expected 0 to 1, got {random_share}")
    if not exponent >= 0:
        raise ValueError(f"exponent: expected 0 or more, got {exponent}")
    uniform = np.full(n_regions, 1 / n_regions)
    interest = _interest(progress, negative)
    if not interest.max() > _NEGLIGIBLE:
        return uniform
    weights = (interest / interest.max()) ** exponent
    by_interest = weights / weights.sum()
    probabilities: Floats = random_share * uniform + (1 - random_share) * by_interest
    return probabilities


class ProgressMeter:
    """Remember the errors made in each region and measure its learning progress.

    A look where the error is undefined (None) repeats the region's last error, so that a region
    that stopped teaching loses interest; with `undefined="skip"` it counts as a visit only, and
    the region keeps the interest it had.
    theta, smoothing, min_errors: see `learning_progress`.
    """

    def __init__(
        self,
        *,
        theta: int = 15,
        smoothing: int = 1,
        min_errors: int = 2,
        undefined: Undefined = "repeat",
    ) -> None:
        for name, value, lowest in (
            ("theta", theta, 2),
            ("smoothing", smoothing, 1),
            ("min_errors", min_errors, 2),
        ):
            if value < lowest:
                raise ValueError(f"{name}: expected {lowest} or more, got {value}")
        if undefined not in ("skip", "repeat"):
            raise ValueError(f"undefined: expected skip or repeat, got {undefined!r}")
        self._theta = theta
        self._smoothing = smoothing
        self._min_errors = min_errors
        self._undefined = undefined
        # What more there was is never asked for: a robot looks for weeks.
        self._n_kept = max(theta + smoothing - 1, min_errors)
        self._errors: dict[int, list[float]] = {}
        self._n_visits: dict[int, int] = {}

    def add(self, region: int, error: float | None) -> None:
        """Count a visit to the region, and its error (eq. 1) where one is known."""
        errors = self._errors.setdefault(region, [])
        self._n_visits[region] = self.n_visits(region) + 1
        if error is None and errors and self._undefined == "repeat":
            error = errors[-1]
        if error is not None:
            errors.append(error)
            del errors[: -self._n_kept]

    def n_visits(self, region: int) -> int:
        return self._n_visits.get(region, 0)

    def progress(self, region: int) -> float | None:
        """Return the region's learning progress, in error per observation.

        None = not known yet. 0 where theta visits gave too few errors to tell: a bare wall
        must not stay the most promising place for ever.
        """
        errors = self._errors.get(region, [])
        progress = learning_progress(
            errors, theta=self._theta, smoothing=self._smoothing, min_errors=self._min_errors
        )
        if progress is None and self.n_visits(region) >= self._theta:
            return 0.0
        return progress


def _interest(progress: Sequence[float | None], negative: Negative) -> Floats:
    """Return non-negative weights; what is not known yet weighs as much as the best."""
    known = np.array([value for value in progress if value is not None], dtype=np.float64)
    if negative == "clip":
        known = np.maximum(known, 0)
    elif negative == "abs":
        known = np.abs(known)
    elif negative == "shift":
        known = known - known.min(initial=np.inf)
    else:
        raise ValueError(f"negative: expected clip, abs or shift, got {negative!r}")
    weights = np.full(len(progress), known.max(initial=0))
    weights[[value is not None for value in progress]] = known
    return weights


def moving_mean(values: Sequence[float] | Floats, window: int) -> Floats:
    """Return the mean of up to `window` values that end in each value."""
    sums = np.cumsum(np.concatenate([[0.0], values]))
    ends = np.arange(1, len(values) + 1)
    starts = np.maximum(ends - window, 0)
    means: Floats = (sums[ends] - sums[starts]) / (ends - starts)
    return means
