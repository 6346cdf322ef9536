"""The measures of salient-object detection over the frames of a recording."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from curiosight.evaluation.bootstrap import Interval, bootstrap_interval
from curiosight.evaluation.object_metrics import ObjectScore

# What each measure is made of: a field of the scores, and how its mean becomes one number.
MEASURES: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "mae": ("mae", float),
    "f_max": ("f_curve", np.max),
    "f_mean": ("f_curve", np.mean),
    "f_adaptive": ("f_adaptive", float),
    "s_measure": ("s_measure", float),
    "e_max": ("e_curve", np.max),
    "e_mean": ("e_curve", np.mean),
    "e_adaptive": ("e_adaptive", float),
    "weighted_f": ("weighted_f", float),
}


class ObjectScores:
    """Collect the scores of maps, frame by frame.

    A measure's figure is the mean over the frames where it has a meaning; `f_max` and `e_max`
    are the highest points of the mean curves, so one threshold serves all frames, as usual.
    """

    def __init__(self) -> None:
        self.frames: list[tuple[str, ObjectScore]] = []

    def add(self, id: str, score: ObjectScore) -> None:
        """Add a frame's score."""
        self.frames.append((id, score))

    def table(self) -> dict[str, Any]:
        """Return everything as JSON-able numbers; None where a number has no meaning."""
        return {
            "n_frames": len(self.frames),
            "mean": {name: _figure(name, self._known(name)) for name in MEASURES},
            "per_frame": [
                {"id": id} | {name: _figure(name, _known(name, [score])) for name in MEASURES}
                for id, score in self.frames
            ],
        }

    def intervals(
        self, rng: np.random.Generator, *, n_resamples: int = 1000, confidence: float = 0.95
    ) -> dict[str, Interval | None]:
        """Return each measure's bootstrap interval over frames; None with fewer than two."""
        return {
            name: bootstrap_interval(
                np.array(self._known(name), np.float64),
                summarise,
                rng,
                n_resamples=n_resamples,
                confidence=confidence,
            )
            for name, (_, summarise) in MEASURES.items()
        }

    def _known(self, name: str) -> list[Any]:
        return _known(name, [score for _, score in self.frames])


def _known(name: str, scores: list[ObjectScore]) -> list[Any]:
    """Return what a measure is made of, one of each score that has it."""
    field, _ = MEASURES[name]
    return [part for score in scores if (part := getattr(score, field)) is not None]


def _figure(name: str, parts: list[Any]) -> float | None:
    _, summarise = MEASURES[name]
    return float(summarise(np.mean(parts, axis=0))) if parts else None
