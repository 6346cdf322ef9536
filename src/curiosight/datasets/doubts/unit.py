"""Can depth be in the unit it was read with? Judged by what sensors see and how they count.

Every candidate factor is weighed by three kinds of evidence, each a log-likelihood in nats: how
near and far depth lies, the smallest difference between stored values (1 mm nearly always), and
the steps of disparity, which tell a Kinect from depth that was scaled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FACTORS = (0.2, 5.0, 0.1, 10.0, 0.001, 1000.0)
# What a wrong unit must be likelier by, as a log: all of a recording's frames are one guess.
MIN_EVIDENCE = 4.5

# Metres: nearest readings, median, farthest; what lies outside costs weight·octaves².
NEAREST, MEDIAN, FARTHEST = (0.2, 2.2), (0.35, 4.5), (0.5, 9.0)
TOO_NEAR, TOO_FAR, NOTHING_NEAR = 4.0, 1.5, 3.0
# Sensors for close work count in tenths of a millimetre and see from 7 cm.
CLOSE_QUANTUM, CLOSE = 1e-4, 0.5
QUANTA = ((1e-3, 0.0), (1e-4, -1.0), (2e-4, -1.5), (2.5e-4, -1.0))
UNUSUAL_QUANTUM, COARSE_QUANTUM, COARSE_FROM = -5.5, -6.0, 0.004
# 1/m: a Kinect's step of disparity, and what stereo of 640 columns can have.
KINECT_STEP, KINECT_BAND = 0.00289, 0.06
STEREO_STEPS, STEREO_COST, STEP_WEIGHT, WORST_STEP = (0.0007, 0.0045), -2.5, 25.0, -12.0


@dataclass(frozen=True, slots=True)
class DepthFacts:
    """What single frames tell: metres as read; quantum in metres and step in 1/m or None."""

    nearest: float
    median: float
    farthest: float
    quantum: float | None
    step: float | None
    width: int


def measured_range(depths: npt.NDArray[np.float32]) -> tuple[float, float, float]:
    """Return the 2nd, 50th and 98th percentile of readings pooled over frames."""
    low, middle, high = np.percentile(depths, [2, 50, 98])
    return float(low), float(middle), float(high)


def likelihood(facts: DepthFacts, factor: float) -> float:
    """Return the log-likelihood that true depth is `factor` times the one read."""
    return (
        _range_likelihood(facts, factor)
        + _quantum_likelihood(facts.quantum, factor)
        + _step_likelihood(facts, factor)
    )


def likelier_factor(facts: DepthFacts) -> float | None:
    """Return by what depth must be multiplied where that is far likelier; None else."""
    as_is = likelihood(facts, 1.0)
    best = max(FACTORS, key=lambda factor: likelihood(facts, factor))
    return best if likelihood(facts, best) - as_is > MIN_EVIDENCE else None


def _range_likelihood(facts: DepthFacts, factor: float) -> float:
    quantum = facts.quantum
    is_close = quantum is not None and abs(quantum * factor / CLOSE_QUANTUM - 1) < 0.01
    total = 0.0
    for metres, (low, high), too_far in (
        (facts.nearest, NEAREST, NOTHING_NEAR),
        (facts.median, MEDIAN, TOO_FAR),
        (facts.farthest, FARTHEST, TOO_FAR),
    ):
        low = CLOSE * low if is_close else low
        total -= TOO_NEAR * _octaves(low, metres * factor) ** 2
        total -= too_far * _octaves(metres * factor, high) ** 2
    return total


def _quantum_likelihood(quantum: float | None, factor: float) -> float:
    if quantum is None:
        return 0.0
    for usual, log_likelihood in QUANTA:
        if abs(quantum * factor / usual - 1) < 0.01:
            return log_likelihood
    return COARSE_QUANTUM if quantum * factor >= COARSE_FROM else UNUSUAL_QUANTUM


def _step_likelihood(facts: DepthFacts, factor: float) -> float:
    if facts.step is None:
        return 0.0
    step = facts.step / factor
    if abs(step / KINECT_STEP - 1) < KINECT_BAND:
        return 0.0
    low, high = STEREO_STEPS
    # More columns mean finer disparity.
    low *= min(1.0, 640 / facts.width)
    octaves = _octaves(low, step) + _octaves(step, high)
    return max(STEREO_COST - STEP_WEIGHT * octaves**2, WORST_STEP)


def _octaves(smaller: float, larger: float) -> float:
    """Return by how many octaves `larger` falls short of `smaller`; 0 where it does not."""
    return max(0.0, math.log2(smaller / larger))
