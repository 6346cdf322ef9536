"""Score what the depth at hand adds to what was learned, and how far probabilities hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.evaluation import MapScores, Reliability
from curiosight.evaluation.baselines.depth_noise import depth_noise
from curiosight.frame import Frame
from curiosight.learner.description import Labels
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.maps import Maps
from curiosight.learner.observation import Teaches

LEARNED, FUSED, DEPTH = "learned", "fused", "depth"


class DepthAtHand:
    """Collect fused maps and depth's own beside the learned ones, frame by frame.

    teacher: reads the depth; None where it is no depth, or is what the maps are tested against:
        then only the learned probabilities are scored.
    scores: of the maps that are fused with depth, and of depth alone, noise where it is silent.
    reliability: of the probabilities of learned and of fused maps.
    """

    def __init__(self, teacher: Teaches | None, *, threshold: float, seed: int) -> None:
        self.scores = {FUSED: MapScores(threshold=threshold), DEPTH: MapScores()}
        self.reliability = {LEARNED: Reliability(), FUSED: Reliability()}
        self._teacher = teacher
        self._seed = seed

    def add(self, frame: Frame, learner: SaliencyLearner, maps: Maps, truth: Labels) -> None:
        """Add a frame's maps, as the learner remembers them."""
        self.reliability[LEARNED].add(maps.probability, truth)
        if self._teacher is None:
            return
        segmentation = self._teacher.segment(frame)
        fused = learner.fused(maps, segmentation)
        self.scores[FUSED].add(frame.id, fused.saliency, truth)
        self.reliability[FUSED].add(fused.probability, truth)
        # Of the frame alone, so that the order of frames does not matter.
        chance = np.random.default_rng([self._seed, *frame.id.encode()])
        self.scores[DEPTH].add(frame.id, depth_noise(segmentation.labels, chance), truth)

    def curves(self) -> dict[str, npt.NDArray[np.float64]]:
        """Return the reliability curves by name, with the calibration error, of what was scored."""
        return {
            f"{name}, error {one.expected_error:.3f}": one.curve
            for name, one in self.reliability.items()
            if one.expected_error is not None
        }

    def metrics(self) -> dict[str, Any]:
        """Return all figures, JSON-able; those of depth only where there is any."""
        reliability = {
            name: one.table()
            for name, one in self.reliability.items()
            if one.expected_error is not None
        }
        tables = {name: _summary(one) for name, one in self.scores.items() if one.frames}
        return {"reliability": reliability, **({"depth_at_hand": tables} if tables else {})}


def _summary(scores: MapScores) -> dict[str, Any]:
    """Return the figures of a map over all of the image."""
    table = scores.table()
    overall = {name: table[name] for name in ("overall_error", "frames_scored", "pooled_error")}
    return {**overall, **table["pooled"]["all"]}
