"""Score saliency maps against ground truth, or the teacher where there is none (sec. III-A)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.evaluation import MapScores, SplitKind, make_folds
from curiosight.experiments.components import (
    count_learned,
    load_learner,
    make_teacher,
    place,
)
from curiosight.experiments.learning import OffLine
from curiosight.experiments.problems import Problems
from curiosight.experiments.truth import Truth, find_truth
from curiosight.frame import Frame
from curiosight.learner import SaliencyLearner, Teaches


class Evaluation:
    """Score a model on the frames of a recording that have a truth.

    Without depth only colour counts: what the teacher left open cannot be told apart then.

    model: a file that `explore` or `learn` wrote; its features and forest replace those of the
        settings.
    """

    def __init__(self, config: Config, model: Path, dataset: Dataset) -> None:
        self._model = model
        self.learner, self.config = load_learner(model, config, None)
        has_teacher = dataset.has_depth or config.teacher.source != "depth"
        teacher = make_teacher(config, dataset) if has_teacher else None
        self.truth = find_truth(dataset, range(len(dataset)), teacher)
        self.n_learned = count_learned(self.learner, dataset, self.truth.indices)
        self.scores = MapScores(max_range=config.max_range, threshold=self.learner.threshold)
        self.problems = Problems()

    def __len__(self) -> int:
        return len(self.truth.indices)

    def __iter__(self) -> Iterator[Frame]:
        """Score frame by frame; yield each when it is done."""
        yield from _score(self.scores, self.learner, self.truth, self.problems)

    def metrics(self) -> dict[str, Any]:
        """Return all figures, JSON-able."""
        return {
            "model": str(self._model),
            "test_frames_learned": self.n_learned,
            "source": place(self.truth.dataset),
            "truth": self.truth.kind,
            **_checked(self.scores, self.truth.dataset),
        }


class CrossValidation:
    """Train on most of a recording and test on the rest, in turn (sec. III-A).

    Every fold learns off-line (see `OffLine`) from the teacher's labels alone; frames are
    tested against ground truth where the recording has any.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        *,
        n_folds: int,
        split: SplitKind,
        teacher: Teaches | None = None,
    ) -> None:
        self.config = config
        self.dataset = dataset
        rng = np.random.default_rng(config.run.seed)
        self.folds = make_folds(len(dataset), n_folds, split, rng, gap=config.test.gap)
        self.split = split
        self.n_learned = 0
        self.off_line = OffLine(config, dataset, teacher=teacher)
        self.truth = find_truth(dataset, range(len(dataset)), self.off_line.teacher)
        self.scores = MapScores(max_range=config.max_range, threshold=self.learner.threshold)
        self.problems = self.off_line.problems

    @property
    def learner(self) -> SaliencyLearner:
        """The model, as the last fold left it."""
        return self.off_line.learner

    def __len__(self) -> int:
        """Count the frames that are looked at, to learn and to test."""
        return len(self.dataset) + len(self.truth.indices)

    def __iter__(self) -> Iterator[Frame]:
        """Learn and score frame by frame; yield each when it is done."""
        yield from self.off_line
        for training, test in self.folds:
            learner = self.off_line.fit(training.tolist())
            tested = tuple(sorted(set(self.truth.indices) & set(test.tolist())))
            yield from _score(
                self.scores, learner, replace(self.truth, indices=tested), self.problems
            )

    def metrics(self) -> dict[str, Any]:
        """Return all figures, JSON-able."""
        return {
            "source": place(self.dataset),
            "truth": self.truth.kind,
            "folds": len(self.folds),
            "split": self.split,
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            **_checked(self.scores, self.dataset),
        }


def _score(
    scores: MapScores, learner: SaliencyLearner, truth: Truth, problems: Problems
) -> Iterator[Frame]:
    """Add the maps of a truth's usable frames to the scores; yield each frame when it is done."""
    for index, (frame, labels) in zip(truth.indices, truth, strict=True):
        problems.add(frame)
        if labels is not None:
            taught = labels if truth.kind == "teacher" else truth.teacher_labels(frame)
            saliency, distances = learner.saliency(frame.rgb), truth.true_depth(index)
            scores.add(frame.id, saliency, labels, taught, frame.depth, distances)
        yield frame


def _checked(scores: MapScores, dataset: Dataset) -> dict[str, Any]:
    if not scores.frames:
        raise DataError(
            place(dataset), "no frame could be scored", "look at it with `curiosight info`"
        )
    return scores.table()
