"""Score saliency maps against ground truth, or the teacher where there is none (sec. III-A)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.evaluation import MapScores, SplitKind, make_folds
from curiosight.experiments.comparing import DEPTH, Comparison, Judged, Methods
from curiosight.experiments.components import (
    count_learned,
    heard,
    load_learner,
    make_teacher,
    place,
)
from curiosight.experiments.depth_at_hand import DepthAtHand
from curiosight.experiments.learning import OffLine
from curiosight.experiments.problems import Problems
from curiosight.experiments.timing import one_thread
from curiosight.experiments.truth import Truth, find_truth
from curiosight.frame import Frame
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches

# Frames that a comparison shows.
N_SHOWN = 6


class Evaluation:
    """Score a model on the frames of a recording that have a truth.

    Without depth only colour counts: what the teacher left open cannot be told apart then.

    model: a file that `explore` or `learn` wrote; its features and forest replace those of the
        settings.
    methods: to judge on the same frames, see `choose_methods`; None = none.
    comparison: of the model with them; None without any.
    """

    def __init__(
        self, config: Config, model: Path, dataset: Dataset, *, methods: Methods | None = None
    ) -> None:
        self._model = model
        self.learner, self.config = load_learner(model, config, None)
        has_teacher = dataset.has_depth or not config.teacher.is_depth
        teacher = make_teacher(config, dataset) if has_teacher else None
        self.truth = find_truth(dataset, range(len(dataset)), teacher)
        self.n_learned = count_learned(self.learner, dataset, self.truth.indices)
        self.comparison = _compare(self.config, methods, self.truth, self.learner)
        self.scores = _scores(self.comparison, config, self.learner)
        self.at_hand = _at_hand(config, self.truth, self.learner)
        self.problems = Problems()

    def __len__(self) -> int:
        return len(self.truth.indices)

    def __iter__(self) -> Iterator[Frame]:
        """Score frame by frame; yield each when it is done."""
        yield from _score(self, self.learner, self.truth)

    def metrics(self) -> dict[str, Any]:
        """Return all figures, JSON-able."""
        return {
            "model": str(self._model),
            "test_frames_learned": self.n_learned,
            "source": place(self.truth.dataset),
            "truth": self.truth.kind,
            **_checked(self.scores, self.truth.dataset),
            **self.at_hand.metrics(),
            **_of_methods(self.comparison),
        }


class CrossValidation:
    """Train on most of a recording and test on the rest, in turn (sec. III-A).

    Every fold learns off-line (see `OffLine`) from the teacher's labels alone; frames are
    tested against ground truth where the recording has any.

    n_untrained: the folds so far that learned nothing, and score as an untrained model does.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        *,
        n_folds: int,
        split: SplitKind,
        teacher: Teaches | None = None,
        methods: Methods | None = None,
    ) -> None:
        self.config = config
        self.dataset = dataset
        rng = np.random.default_rng(config.run.seed)
        self.folds = make_folds(len(dataset), n_folds, split, rng, gap=config.test.gap)
        self.split = split
        self.n_learned = 0
        self.off_line = OffLine(config, dataset, teacher=teacher)
        self.truth = find_truth(dataset, range(len(dataset)), self.off_line.teacher)
        self.comparison = _compare(config, methods, self.truth, self.learner)
        self.scores = _scores(self.comparison, config, self.learner)
        self.at_hand = _at_hand(config, self.truth, self.learner)
        self.problems = self.off_line.problems
        self.n_untrained = 0

    @property
    def learner(self) -> SaliencyLearner:
        """The model, as the last fold left it."""
        return self.off_line.learner

    def __len__(self) -> int:
        """Count the frames that are looked at, to learn and to test."""
        return self.off_line.n_looks + len(self.truth.indices)

    def __iter__(self) -> Iterator[Frame]:
        """Learn and score frame by frame; yield each when it is done."""
        yield from self.off_line
        for training, test in self.folds:
            learner = self.off_line.fit(training.tolist())
            self.n_untrained += not learner.is_trained
            tested = tuple(sorted(set(self.truth.indices) & set(test.tolist())))
            part = replace(self.truth, indices=tested)
            yield from _score(self, learner, part)

    def metrics(self) -> dict[str, Any]:
        """Return all figures, JSON-able."""
        return {
            "source": place(self.dataset),
            "truth": self.truth.kind,
            "folds": len(self.folds),
            "split": self.split,
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            "taught_nothing": self.off_line.lessons.summary(),
            "folds_that_learned_nothing": self.n_untrained,
            **_checked(self.scores, self.dataset),
            **self.at_hand.metrics(),
            **_of_methods(self.comparison),
        }


def _compare(
    config: Config, methods: Methods | None, truth: Truth, learner: SaliencyLearner
) -> Comparison | None:
    if methods is None:
        return None
    if truth.kind == "teacher" or config.teacher.source != "depth":
        # What it would be tested against, or not depth.
        methods = {name: method for name, method in methods.items() if name != DEPTH}
    ids = truth.dataset.ids
    spread = np.linspace(0, len(truth.indices) - 1, min(N_SHOWN, len(truth.indices)))
    return Comparison(
        f"ours ({config.preset})",
        methods,
        max_range=config.max_range,
        threshold=learner.threshold,
        seed=config.run.seed,
        show=[ids[truth.indices[round(place)]] for place in spread],
    )


def _scores(comparison: Comparison | None, config: Config, learner: SaliencyLearner) -> MapScores:
    """Return what collects the scores of the learned map."""
    if comparison is not None:
        return comparison.scores[comparison.ours].maps
    return MapScores(max_range=config.max_range, threshold=learner.threshold)


def _at_hand(config: Config, truth: Truth, learner: SaliencyLearner) -> DepthAtHand:
    is_depth = truth.kind == "ground truth" and config.teacher.is_depth
    teacher = heard(config, truth.teacher) if is_depth and truth.teacher is not None else None
    return DepthAtHand(teacher, threshold=learner.threshold, seed=config.run.seed)


def _score(
    to: Evaluation | CrossValidation, learner: SaliencyLearner, truth: Truth
) -> Iterator[Frame]:
    """Add the maps of a truth's usable frames to the scores; yield each frame when it is done."""
    comparison = to.comparison
    with one_thread() if comparison else nullcontext():
        for index, (frame, labels) in zip(truth.indices, truth, strict=True):
            to.problems.add(frame)
            if labels is not None:
                taught = labels if truth.kind == "teacher" else truth.teacher_labels(frame)
                maps = learner.maps(frame.rgb, frame.T_world_camera)
                to.at_hand.add(frame, learner, maps, labels)
                distances = truth.true_depth(index)
                if comparison is None:
                    to.scores.add(frame.id, maps.saliency, labels, taught, frame.depth, distances)
                else:
                    learned = partial(learner.saliency, T_world_camera=frame.T_world_camera)
                    comparison.add(Judged(frame, labels, taught, distances), learned)
            yield frame


def _of_methods(comparison: Comparison | None) -> dict[str, Any]:
    return {} if comparison is None else {"methods": comparison.metrics()}


def _checked(scores: MapScores, dataset: Dataset) -> dict[str, Any]:
    if not scores.frames:
        raise DataError(
            place(dataset), "no frame could be scored", "look at it with `curiosight info`"
        )
    return scores.table()
