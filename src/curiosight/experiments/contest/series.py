"""What figures of a contest draw: the error over looks, metres or seconds; where looks went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.experiments.contest.table import Curve

Floats = npt.NDArray[np.float64]

N_POINTS = 400


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """Mean and standard deviation over seeds of an error, (n,) each, over x."""

    x: Floats
    mean: Floats
    deviation: Floats


def band_of(curves: Sequence[Curve], unit: str) -> Band:
    """Return the error of a strategy over frames, metres or seconds, as far as all seeds come."""
    costs: list[Floats] = [getattr(curve, unit) for curve in curves]
    x = np.linspace(max(c[0] for c in costs), min(c[-1] for c in costs), N_POINTS)
    if unit == "frames":
        x = np.arange(1.0, 1 + min(map(len, costs)))
    pairs = zip(curves, costs, strict=True)
    errors = np.array([np.interp(x, cost, curve.errors) for curve, cost in pairs])
    return Band(x, errors.mean(axis=0), errors.std(axis=0, ddof=1 if len(curves) > 1 else 0))
