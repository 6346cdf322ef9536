"""All that is measured of one method's maps, so that methods can be compared on the same frames."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.evaluation.bootstrap import Interval, bootstrap_interval
from curiosight.evaluation.map_scores import MapScores
from curiosight.evaluation.object_metrics import score_objects
from curiosight.evaluation.object_scores import ObjectScores
from curiosight.evaluation.object_truth import ObjectTruth
from curiosight.evaluation.score_histograms import (
    Floats,
    average_precision,
    precision_recall,
    roc_auc,
    score_histogram,
)
from curiosight.frame import Depth

# Coarser than the figures themselves, which are exact: an interval needs no fourth decimal.
INTERVAL_LEVELS = 1024


class MethodScores:
    """Collect one method's maps with their truth, frame by frame.

    max_range: metres of depth; what lies nearer and beyond is scored apart too.
    threshold: above which the method calls a pixel salient, for the overall error.
    """

    def __init__(self, *, max_range: float = 4.0, threshold: float = 0.5) -> None:
        self.maps = MapScores(max_range=max_range, threshold=threshold)
        self.objects = ObjectScores()
        self._histograms: list[npt.NDArray[np.int64]] = []

    def add(
        self,
        id: str,
        saliency: npt.NDArray[np.float32],
        truth: ObjectTruth,
        labels: npt.NDArray[np.uint8] | None = None,
        depth: Depth | None = None,
        true_depth: Depth | None = None,
    ) -> None:
        """Add a frame's (H, W) map in [0, 1]; the rest as in `MapScores.add`."""
        self.maps.add(id, saliency, truth.labels, labels, depth, true_depth)
        self.objects.add(id, score_objects(saliency, truth))
        histogram = score_histogram(saliency, truth.labels, n_levels=INTERVAL_LEVELS)
        self._histograms.append(histogram)

    def table(self) -> dict[str, Any]:
        """Return all figures but the intervals as JSON-able numbers."""
        scores, objects = self.maps.table(), self.objects.table()
        per_frame = scores.pop("per_frame")
        for frame, measures in zip(per_frame, objects["per_frame"], strict=True):
            del measures["id"]
            frame["objects"] = measures
        return {**scores, "objects": objects["mean"], "per_frame": per_frame}

    def intervals(self, seed: int) -> dict[str, Interval | None]:
        """Return the 95 % bootstrap intervals over frames of the pooled figures and the measures.

        The same seed draws the same frames for every method that has as many. Frames without a
        known pixel are none; with fewer than two there is no interval.
        """
        known = [histogram for histogram in self._histograms if histogram.any()]
        per_frame = np.array(known or np.empty((0, 2, INTERVAL_LEVELS)), np.float64)
        pooled = {
            name: bootstrap_interval(per_frame, statistic, np.random.default_rng(seed))
            for name, statistic in (("roc_auc", roc_auc), ("average_precision", average_precision))
        }
        return pooled | self.objects.intervals(np.random.default_rng(seed))

    def auc_gain(self, other: MethodScores, seed: int) -> tuple[float, Interval | None]:
        """Return by how much the AUC is above that of another on the same frames.

        With its 95 % interval: a resample has the same frames of both. Raises ValueError where
        either has none.
        """
        pairs = [
            (own, others)
            for own, others in zip(self._histograms, other._histograms, strict=True)
            if own.any()
        ]
        per_frame = np.array(pairs, np.float64)
        gain = _gain(per_frame.mean(axis=0)) if pairs else None
        if gain is None:
            raise ValueError("other: expected frames that show both classes, got none")
        return gain, bootstrap_interval(per_frame, _gain, np.random.default_rng(seed))

    def precision_recall(self) -> Floats:
        """(n, 2): recall and precision over the thresholds, pooled over frames; may be empty."""
        nothing = np.zeros((2, INTERVAL_LEVELS), np.int64)
        return precision_recall(sum(self._histograms, start=nothing))


def _gain(histograms: Floats) -> float | None:
    """Return the difference of two AUCs; None where either has no meaning."""
    own, other = (roc_auc(histogram) for histogram in histograms)
    return None if own is None or other is None else own - other
