"""Score the teacher against ground truth, frame by frame (sec. II-A.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, KnowsDistances, KnowsInstances, Prefetch
from curiosight.datasets.dataset import InstanceTruth
from curiosight.errors import DataError
from curiosight.evaluation import TeacherScores, score_frame
from curiosight.evaluation.teacher_counts import Mask
from curiosight.experiments.components import make_teacher, place
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.teacher import Segmentation

COLUMNS = (
    "id",
    "precision",
    "recall",
    "recall_of_all",
    "coverage",
    "n_wrong_px",
    "objects",
    "objects_predicted",
    "overlap_f",
    "boundary_f",
    "detected",
)


@dataclass(frozen=True, slots=True)
class ScoringSettings:
    """What the teacher is scored on.

    every: of the frames with ground truth, each `every`-th counts.
    border_px: recall leaves out true objects that touch this frame of the image.
    max_distance: metres along z; what lies farther, or has no known distance, does not count.
        None = everything counts.
    n_worst: frames to keep for a look: those with most wrong pixels.
    """

    every: int = 1
    border_px: int = 10
    max_distance: float | None = None
    n_worst: int = 12

    def __post_init__(self) -> None:
        if self.every < 1:
            raise ValueError(f"every: expected 1 or more, got {self.every}")
        if self.border_px < 0:
            raise ValueError(f"border-px: expected 0 or more, got {self.border_px}")
        if self.max_distance is not None and not self.max_distance > 0:
            raise ValueError(f"max-distance: expected metres above 0, got {self.max_distance}")


class Scoring:
    """Score the teacher on a recording with ground truth.

    temporal: with poses, earlier views correct each frame, see `TemporalTeacher`; then the
        frames between those that count are looked at too.
    n_tried: frames so far that count, those that could not be scored too.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        settings: ScoringSettings,
        *,
        temporal: bool = False,
    ) -> None:
        with_truth = [index for index in range(len(dataset)) if dataset.has_ground_truth(index)]
        if not with_truth:
            found = "has no ground truth to score the teacher against"
            raise DataError(place(dataset), found, "give --ground-truth")
        self.scores = TeacherScores(n_worst=settings.n_worst)
        self.problems = Problems()
        self.n_tried = 0
        self._counted = with_truth[:: settings.every]
        self._seen = range(self._counted[-1] + 1) if temporal else self._counted
        self._teacher = make_teacher(config, dataset, temporal=temporal)
        self._config = config
        self._dataset = dataset
        self._out = out
        self._settings = settings
        self._is_temporal = temporal

    def __len__(self) -> int:
        """Count the frames that are looked at."""
        return len(self._seen)

    def __iter__(self) -> Iterator[Frame]:
        """Yield each frame once it is looked at, and its row in frames.csv if it counts."""
        counted = frozenset(self._counted)
        table = TableFile(self._out.file("frames.csv"), COLUMNS)
        try:
            with Prefetch(self._dataset, memory_mb=self._config.run.memory_mb) as frames:
                for index, frame in zip(self._seen, frames.in_order(self._seen), strict=True):
                    segmentation = self._teacher.segment(frame)
                    if index in counted and self._add(index, frame, segmentation):
                        table.add(self.scores.rows[-1])
                    yield frame
        finally:
            table.close()

    def _add(self, index: int, frame: Frame, segmentation: Segmentation) -> bool:
        """Score a frame; tell whether it could be, and note what is wrong with it."""
        self.n_tried += 1
        try:
            truth = self._dataset.ground_truth(index)
            instances = self._instance_truth(index)
        except DataError as error:
            frame = replace(frame, problem=frame.problem or f"ground truth: {error.found}")
        self.problems.add_told(frame, segmentation)
        if frame.problem is not None:
            return False
        assert truth is not None
        counted, border_px = self._near(index, frame), self._settings.border_px
        self.scores.add(
            score_frame(frame, segmentation, truth, instances, counted=counted, border_px=border_px)
        )
        return True

    def _instance_truth(self, index: int) -> InstanceTruth | None:
        """Return the true objects, None where they, or the teacher's, are not told apart."""
        if not (self._config.teacher.is_depth and isinstance(self._dataset, KnowsInstances)):
            return None
        return self._dataset.instance_truth(index)

    def _near(self, index: int, frame: Frame) -> Mask | None:
        """(H, W) bool: near enough to count; None = all of it."""
        limit = self._settings.max_distance
        if limit is None:
            return None
        distance = frame.depth
        if isinstance(self._dataset, KnowsDistances):
            distance = self._dataset.true_depth(index)
        if distance is None:
            return np.zeros(frame.rgb.shape[:2], np.bool_)
        near: Mask = distance <= limit
        return near

    def finish(self) -> dict[str, Any]:
        """Write teacher.json for the frames scored so far; return it, JSON-able."""
        if not self.scores.rows:
            reasons = self.problems.sentences(self.n_tried, "cannot be scored")
            found = ", ".join(["no frame could be scored", *reasons][:2])
            raise DataError(place(self._dataset), found, "look at it with `curiosight info`")
        figures = {
            "source": place(self._dataset),
            "preset": self._config.preset,
            "teacher": self._config.teacher.source,
            "temporal": self._is_temporal,
            **asdict(self._settings),
            "problems": self.problems.counts(),
            **self.scores.table(),
        }
        self._out.write_json("teacher.json", figures)
        return figures
