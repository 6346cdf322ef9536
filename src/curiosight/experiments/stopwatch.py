"""Time the stages of the loop from outside, so that the loop need not know."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np


class Stopwatch:
    """Sum the milliseconds that watched methods take, lap by lap."""

    def __init__(self) -> None:
        self._stages: list[str] = []
        self._lap: dict[str, float] = {}

    def watch(self, owner: object, method: str, stage: str | None = None) -> None:
        """Time one object's method from now on, as `stage` (its own name if None)."""
        stage = stage or method
        if stage not in self._stages:
            self._stages.append(stage)
        original: Callable[..., Any] = getattr(owner, method)

        def timed(*args: Any, **options: Any) -> Any:
            start = time.perf_counter()
            try:
                return original(*args, **options)
            finally:
                spent = 1000 * (time.perf_counter() - start)
                self._lap[stage] = self._lap.get(stage, 0.0) + spent

        setattr(owner, method, timed)

    @property
    def stages(self) -> tuple[str, ...]:
        """The watched stages, in the order in which they were given."""
        return tuple(self._stages)

    def lap(self) -> dict[str, float]:
        """End a lap; return its milliseconds per stage."""
        lap = {stage: self._lap.get(stage, 0.0) for stage in self._stages}
        self._lap = {}
        return lap


def summarise(laps: Sequence[Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Return median and 90th percentile per stage of at least one lap, in milliseconds.

    The first lap is left out where there are others: it may compile kernels.
    """
    counted = laps[1:] or laps
    return {
        stage: {
            "median_ms": round(float(np.median([lap[stage] for lap in counted])), 3),
            "p90_ms": round(float(np.percentile([lap[stage] for lap in counted], 90)), 3),
        }
        for stage in counted[0]
    }
