"""Collect the teacher's scores over frames, and keep the worst of them to look at."""

from __future__ import annotations

import heapq
from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from curiosight.evaluation.instances import (
    IGNORED,
    InstanceScore,
    Numbers,
    instance_table,
    score_instances,
)
from curiosight.evaluation.teacher_counts import (
    Labels,
    Mask,
    TeacherCounts,
    missed_by_reason,
    teacher_counts,
    whole_objects,
)
from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation


@dataclass(frozen=True, slots=True, eq=False)
class ScoredFrame:
    """What the teacher said of a frame, and how good it was.

    truth: (H, W) uint8: 255 salient, 0 not salient, 125 ignored or left out.
    is_whole: (H, W) bool, see `whole_objects`.
    instances: None without a truth that tells objects apart.
    """

    frame: Frame
    segmentation: Segmentation
    truth: Labels
    is_whole: Mask
    counts: TeacherCounts
    instances: InstanceScore | None

    @property
    def is_missed(self) -> Mask:
        """(H, W) bool: belongs to an object that should have been found, and is not salient."""
        missed: Mask = self.is_whole & (self.segmentation.labels != Label.SALIENT)
        return missed

    @property
    def is_invented(self) -> Mask:
        """(H, W) bool: labelled salient, and is not."""
        is_salient = self.segmentation.labels == Label.SALIENT
        invented: Mask = is_salient & (self.truth == Label.NOT_SALIENT)
        return invented

    def row(self) -> dict[str, Any]:
        """Return the figures by name, JSON-able; None where one has no meaning."""
        found = self.instances
        return {
            "id": self.frame.id,
            **self.counts.shares(),
            "n_wrong_px": self.counts.n_wrong,
            "objects": None if found is None else found.n_true,
            "objects_predicted": None if found is None else found.n_predicted,
            "overlap_f": None if found is None else found.overlap.f,
            "boundary_f": None if found is None else found.boundary.f,
            "detected": None if found is None else found.detected,
        }


def score_frame(
    frame: Frame,
    segmentation: Segmentation,
    truth: Labels,
    instances: Numbers | None = None,
    *,
    counted: Mask | None = None,
    border_px: int = 10,
) -> ScoredFrame:
    """Compare what the teacher says of a frame with ground truth: 255 salient, 0 not, else ignored.

    instances: (H, W) a number a true object, 0 = none, -1 = ignored; None = not told apart.
    counted: (H, W) the pixels that count; None = all. border_px: see `whole_objects`.
    """
    is_whole = whole_objects(truth, border_px=border_px)
    if counted is not None:
        # After objects were told whole or cut: an object half counted is not cut.
        truth = np.where(counted, truth, Label.UNKNOWN).astype(np.uint8)
        is_whole &= counted
        instances = None if instances is None else np.where(counted, instances, IGNORED)
    score = None if instances is None else score_instances(segmentation.instances(), instances)
    counts = teacher_counts(segmentation.labels, truth, is_whole=is_whole)
    return ScoredFrame(frame, segmentation, truth, is_whole, counts, score)


class TeacherScores:
    """Add up the scores of frames.

    rows: a frame's figures each, in order.
    n_worst: frames to keep in `worst`.
    """

    def __init__(self, *, n_worst: int = 12) -> None:
        if n_worst < 0:
            raise ValueError(f"worst: expected 0 or more, got {n_worst}")
        self.total = TeacherCounts()
        self.rows: list[dict[str, Any]] = []
        self._n_worst = n_worst
        self._worst: list[tuple[int, int, ScoredFrame]] = []
        self._missed: Counter[str] = Counter()
        self._instances: list[InstanceScore] = []

    def add(self, scored: ScoredFrame) -> None:
        """Add a frame."""
        self.total += scored.counts
        self._missed += missed_by_reason(scored.segmentation, scored.is_missed)
        if scored.instances is not None:
            self._instances.append(scored.instances)
        # Of equally bad frames the earlier ones are kept; frames themselves have no order.
        heapq.heappush(self._worst, (scored.counts.n_wrong, -len(self.rows), scored))
        if len(self._worst) > self._n_worst:
            heapq.heappop(self._worst)
        self.rows.append(scored.row())

    @property
    def worst(self) -> list[ScoredFrame]:
        """The frames with most wrong pixels, the worst first."""
        worst_first = sorted(self._worst, key=lambda entry: entry[:2], reverse=True)
        return [scored for n_wrong, _, scored in worst_first if n_wrong]

    def table(self) -> dict[str, Any]:
        """Return everything as JSON-able numbers; None where a number has no meaning.

        missed_by_reason: shares of the missed pixels, the largest first. instances: None where
        the truth never tells objects apart.
        """
        n_missed = self._missed.total()
        return {
            "frames": len(self.rows),
            "pixels": self.total.shares() | asdict(self.total),
            "instances": instance_table(self._instances),
            "missed_by_reason": {
                reason: count / n_missed for reason, count in self._missed.most_common()
            },
            "per_frame": self.rows,
        }
