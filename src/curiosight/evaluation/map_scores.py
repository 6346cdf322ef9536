"""How well saliency maps agree with ground truth, also where depth says nothing (sec. III-A)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth, Label
from curiosight.metrics import Ranking, Scores

Mask = npt.NDArray[np.bool_]

LEVELS = 65535
# Pixels by what the teacher could say of them, then by what the depth sensor could.
PARTS = ("all", "unknown", "unavailable", "near", "beyond_range", "missing")


@dataclass(frozen=True, slots=True)
class FrameScore:
    """The agreement in one frame; None where it has no salient or no other pixel.

    f1: at 0.5. error: 1 - F1 at the learner's own threshold (eq. 1).
    """

    roc_auc: float | None
    average_precision: float | None
    best_f1: float | None
    f1: float | None
    error: float | None


class MapScores:
    """Collect saliency maps with their truth, frame by frame.

    max_range: metres of depth; what lies nearer and beyond is scored apart too.
    threshold: above which a pixel is predicted salient, for the error.
    frames: what was added, in order: the id and the scores of each part, one of `PARTS`.
    """

    def __init__(self, *, max_range: float = 4.0, threshold: float = 0.5) -> None:
        self._max_range = max_range
        self._threshold = threshold
        self._pools = {part: Scores() for part in PARTS}
        self.frames: list[tuple[str, dict[str, FrameScore]]] = []

    def add(
        self,
        id: str,
        saliency: npt.NDArray[np.float32],
        truth: npt.NDArray[np.uint8],
        labels: npt.NDArray[np.uint8] | None = None,
        depth: Depth | None = None,
        true_depth: Depth | None = None,
    ) -> None:
        """Add a frame's (H, W) map in [0, 1] and truth: 255 salient, 0 not, else ignored.

        labels: the teacher's, to score apart what it left unknown or unavailable.
        depth: the sensor's, metres, to score apart what lies within and beyond its range.
        true_depth: metres where there is any surface, to do the same where the sensor is blind,
            and to score apart where it should have seen something and did not.
        """
        is_salient = truth == Label.SALIENT
        # 16 bits are finer than any use of a map, and bound the memory of a long recording.
        saliency = np.rint(saliency * LEVELS).astype(np.float32) / np.float32(LEVELS)
        scores = {}
        for part, mask in self._parts(truth, labels, depth, true_depth).items():
            self._pools[part].add(saliency, is_salient, mask)
            scores[part] = _score_frame(saliency, is_salient, mask, self._threshold)
        self.frames.append((id, scores))

    def _parts(
        self,
        truth: npt.NDArray[np.uint8],
        labels: npt.NDArray[np.uint8] | None,
        depth: Depth | None,
        true_depth: Depth | None,
    ) -> dict[str, Mask]:
        """Return the pixels of each part that can be told apart."""
        known = (truth == Label.SALIENT) | (truth == Label.NOT_SALIENT)
        parts = {"all": known}
        if labels is not None:
            parts["unknown"] = known & (labels == Label.UNKNOWN)
            parts["unavailable"] = known & (labels == Label.UNAVAILABLE)
        if depth is not None:
            distance = depth if true_depth is None else true_depth
            is_seen = np.isfinite(depth)
            parts["near"] = known & is_seen & (distance <= self._max_range)
            parts["beyond_range"] = known & (distance > self._max_range)
            parts["missing"] = known & ~is_seen & (distance <= self._max_range)
        return parts

    def ranking(self, part: str = "all") -> Ranking:
        """Return the metrics pooled over all frames' pixels of a part, one of `PARTS`."""
        return self._pools[part].ranking()

    def table(self) -> dict[str, Any]:
        """Return everything as JSON-able numbers; None where a number has no meaning.

        overall_error: the mean over the `frames_scored` of `n_frames` that show anything salient:
        the others have no F1, as in the authors' code. What is marked in those counts in
        pooled_error, 1 - F1 of all frames' pixels together at the learner's threshold.
        """
        means = {part: self._means(part) for part in PARTS}
        pooled = {part: _numbers(self.ranking(part)) for part in PARTS}
        f1 = pooled["all"]["f1"]
        if self._threshold != 0.5:
            f1 = self._pools["all"].ranking(threshold=self._threshold).f1
        return {
            "n_frames": len(self.frames),
            "overall_error": means["all"]["overall_error"],
            "frames_scored": means["all"]["frames_scored"],
            "pooled_error": None if f1 is None else 1 - f1,
            "pooled": pooled,
            "mean_per_frame": means,
            "per_frame": [
                {"id": id} | {part: asdict(score) for part, score in scores.items()}
                for id, scores in self.frames
            ],
        }

    def _means(self, part: str) -> dict[str, float | int | None]:
        """Return the means over the frames where a figure has a meaning."""
        scores = [scores[part] for _, scores in self.frames if part in scores]
        names = ("roc_auc", "average_precision", "best_f1", "f1")
        means: dict[str, float | int | None] = {
            name: _mean([getattr(score, name) for score in scores]) for name in names
        }
        errors = [score.error for score in scores if score.error is not None]
        return means | {"overall_error": _mean([*errors]), "frames_scored": len(errors)}


def _score_frame(
    saliency: npt.NDArray[np.float32], is_salient: Mask, mask: Mask, threshold: float
) -> FrameScore:
    scores = Scores()
    scores.add(saliency, is_salient, mask)
    ranking = scores.ranking()
    f1 = ranking.f1 if threshold == 0.5 else scores.ranking(threshold=threshold).f1
    return FrameScore(
        ranking.roc_auc,
        ranking.average_precision,
        ranking.best_f1,
        ranking.f1,
        None if f1 is None else 1 - f1,
    )


def _numbers(ranking: Ranking) -> dict[str, Any]:
    """Return a ranking's numbers without its curve; AUC needs both classes."""
    return {
        "roc_auc": ranking.roc_auc,
        "average_precision": ranking.average_precision,
        "best_f1": ranking.best_f1,
        "best_threshold": ranking.best_threshold,
        "f1": ranking.f1,
        "n_salient_px": int(ranking.n_positive),
        "n_not_salient_px": int(ranking.n_negative),
    }


def _mean(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
