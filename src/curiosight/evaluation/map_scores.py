"""How well saliency maps agree with ground truth, also where depth says nothing (sec. III-A)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth, Label
from curiosight.metrics import Ranking, Scores, f1_error

Mask = npt.NDArray[np.bool_]

# Pixels by what the teacher could say of them.
PARTS = ("all", "unknown", "unavailable", "beyond_range")


@dataclass(frozen=True, slots=True, eq=False)
class FrameScore:
    """The agreement in one frame; None where it has no salient or no other pixel."""

    id: str
    roc_auc: float | None
    average_precision: float | None
    best_f1: float | None
    f1: float | None
    error: float | None


class MapScores:
    """Collect saliency maps with their truth, frame by frame.

    max_range: metres of depth; what lies beyond is scored apart too.
    """

    def __init__(self, *, max_range: float = 4.0) -> None:
        self._max_range = max_range
        self._pools = {part: Scores() for part in PARTS}
        self.frames: list[FrameScore] = []

    def add(
        self,
        id: str,
        saliency: npt.NDArray[np.float32],
        truth: npt.NDArray[np.uint8],
        labels: npt.NDArray[np.uint8] | None = None,
        depth: Depth | None = None,
    ) -> None:
        """Add a frame's (H, W) map in [0, 1] and truth: 255 salient, 0 not, else ignored.

        labels: the teacher's, to score apart what it left unknown or unavailable.
        depth: metres, to score apart what lies beyond its range.
        """
        known = (truth == Label.SALIENT) | (truth == Label.NOT_SALIENT)
        is_salient = truth == Label.SALIENT
        masks: dict[str, Mask] = {"all": known}
        if labels is not None:
            masks["unknown"] = known & (labels == Label.UNKNOWN)
            masks["unavailable"] = known & (labels == Label.UNAVAILABLE)
        if depth is not None:
            masks["beyond_range"] = known & (depth > self._max_range)
        for part, mask in masks.items():
            self._pools[part].add(saliency, is_salient, mask)
        own = Scores()
        own.add(saliency, is_salient, known)
        ranking = own.ranking()
        self.frames.append(
            FrameScore(
                id,
                ranking.roc_auc,
                ranking.average_precision,
                ranking.best_f1,
                ranking.f1,
                f1_error(truth, saliency),
            )
        )

    def ranking(self, part: str = "all") -> Ranking:
        """Return the metrics pooled over all frames' pixels of a part, one of `PARTS`."""
        return self._pools[part].ranking()

    def table(self) -> dict[str, Any]:
        """Return everything as JSON-able numbers; None where a number has no meaning."""
        pooled = {part: _numbers(self.ranking(part)) for part in PARTS}
        names = ("roc_auc", "average_precision", "best_f1", "f1")
        means = {name: _mean([getattr(score, name) for score in self.frames]) for name in names}
        return {
            "n_frames": len(self.frames),
            "overall_error": _mean([score.error for score in self.frames]),
            "pooled": pooled,
            "mean_per_frame": means,
            "per_frame": [asdict(score) for score in self.frames],
        }


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
