"""What figures are of: a source, its off-line model, and frames that it did not learn from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.evaluation import TestView, every_nth
from curiosight.evaluation.baselines import Saliency
from curiosight.evaluation.score_histograms import Floats, score_histogram
from curiosight.experiments.comparing import Comparison, Judged, Methods
from curiosight.experiments.components import make_learner, make_teacher, survey_dataset
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.preparing import reach_and_tests
from curiosight.experiments.timing import one_thread
from curiosight.experiments.truth import Truth, find_truth, split_frames, spread
from curiosight.frame import Frame, Label, Rgb
from curiosight.learner.description import Labels
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.rooms.drawn_views import DrawnViews

OURS = "ours"
# Frames that figures of examples show.
N_SHOWN = 5
# Of such a frame's pixels so many are salient, where there are such frames.
SHOWN_SHARE = 0.01
# Of a recording with truth of nearly every frame every so many are tested on (of a short one,
# more), and so many neighbours on each side left out: of a moving camera, and of separate scenes.
MOVING_EVERY, MOVING_GAP = 10, 1
SCENES_EVERY, SCENES_GAP = 5, 0
# Scores at which maps of others may be cut: the best of all is taken.
N_LEVELS = 256


def with_tests_apart(config: Config, dataset: Dataset) -> Config:
    """Return settings by which no frame is tested on that was learned from.

    Raises ValueError for a recording of too few frames for that.
    """
    if isinstance(dataset, DrawnViews):
        return config
    learned, tested = split_frames(config, dataset)
    if not set(learned) & set(tested):
        return config
    is_moving = any(pose is not None for pose in dataset.poses)
    most, gap = (MOVING_EVERY, MOVING_GAP) if is_moving else (SCENES_EVERY, SCENES_GAP)
    every = min(most, max(2 * gap + 2, len(dataset) // 2))
    every_nth(len(dataset), every, gap=gap)  # refuses too short a recording
    return replace(config, test=replace(config.test, every=every, gap=gap))


class Subject:
    """A source as `prepare` left it, and the frames that it is tested on.

    config: as it was prepared with. Of a source that changes, it is as it is after the change.
    """

    def __init__(self, config: Config, dataset: Dataset, prepared: Prepared) -> None:
        self.config, self.dataset, self.prepared = config, dataset, prepared

    @cached_property
    def teacher(self) -> Teaches:
        """What labels a frame by itself, with what it knows of the place."""
        return make_teacher(self.config, self.dataset, survey_dataset(self.config, self.dataset))

    @cached_property
    def learner(self) -> SaliencyLearner:
        """The off-line model: of one visit of every view."""
        learner = make_learner(self.config, None)
        shown = self.prepared.phases[-1].shown
        views = range(0, len(shown), self.prepared.n_visits)
        learner.fit([shown[index].visit.lesson for index in views])
        return learner

    @cached_property
    def truth(self) -> Truth:
        """The frames to test on; without ground truth the teacher's labels stand in."""
        dataset, indices = self.dataset, reach_and_tests(self.config, self.dataset)[1]
        if isinstance(dataset, DrawnViews):
            dataset = dataset.own_test_views(is_after=len(self.prepared.phases) > 1)
            indices = range(len(dataset))
        teacher = None if any(map(dataset.has_ground_truth, indices)) else self.teacher
        return find_truth(dataset, indices, teacher, max_frames=self.config.test.max_frames)

    @property
    def has_truth(self) -> bool:
        """Tell whether there is ground truth to test on."""
        return self.truth.kind == "ground truth"

    @property
    def shown(self) -> tuple[int, ...]:
        """The test frames that are looked at, evenly spread over those that show something."""
        indices, tests = self.truth.indices, self.prepared.phases[-1].tests
        if len(tests) == len(indices):  # else some could not be used
            pairs = zip(indices, tests, strict=True)
            indices = tuple(index for index, view in pairs if _shows_something(view)) or indices
        return spread(indices, N_SHOWN)

    def saliency(self, frame: Frame) -> Saliency:
        """Return the off-line model's map of a frame, from its colours and where it is from."""
        return self.learner.saliency(frame.rgb, frame.T_world_camera)

    @property
    def compared(self) -> Truth:
        """What methods are compared on: without ground truth but a few frames, to look at."""
        return self.truth if self.has_truth else replace(self.truth, indices=self.shown)

    def comparison(self, methods: Methods) -> Comparison:
        """Return what collects the maps of all methods, still empty."""
        return Comparison(
            OURS,
            methods,
            max_range=self.config.max_range,
            threshold=self.learner.threshold,
            seed=self.config.run.seed,
            show=[self.truth.dataset.ids[index] for index in self.shown],
        )

    def compare(self, comparison: Comparison) -> Iterator[Frame]:
        """Map frame by frame with all methods; yield each when it is done."""
        truth = self.compared
        with one_thread():
            for index, (frame, labels) in zip(truth.indices, truth, strict=True):
                if labels is not None:
                    told = self.teacher.segment(frame).labels
                    known = labels if self.has_truth else np.full_like(labels, Label.UNKNOWN)
                    distances = truth.true_depth(index)
                    comparison.add(Judged(frame, known, told, distances), partial(self._map, frame))
                yield frame

    def _map(self, frame: Frame, rgb: Rgb) -> Saliency:
        return self.learner.saliency(rgb, frame.T_world_camera)

    def labelled(self) -> Iterator[tuple[int, Frame, Labels]]:
        """Yield the usable test frames with their labels and their numbers."""
        for index, (frame, labels) in zip(self.truth.indices, self.truth, strict=True):
            if labels is not None:
                yield index, frame, labels


def _shows_something(view: TestView) -> bool:
    salient = int(view.salient.sum())
    return salient >= SHOWN_SHARE * max(1, salient + int(view.other.sum()))


def least_error(subject: Subject, method: Methods, name: str) -> tuple[float, float] | None:
    """Return the least overall error of a method that learns nothing, and where it is cut.

    One threshold for all test frames, the best for it. None where nothing is salient.
    """
    find = method[name]
    assert find is not None
    errors: list[Floats] = []
    for _, frame, labels in subject.labelled():
        other, salient = score_histogram(find(frame.rgb), labels, n_levels=N_LEVELS)
        if salient.any():
            hits, false_alarms = _counted_above(salient), _counted_above(other)
            errors.append(1 - 2 * hits / (hits + false_alarms + salient.sum()))
    if not errors:
        return None
    means = np.mean(errors, axis=0)
    best = int(np.argmin(means))
    return float(means[best]), (best - 0.5) / (N_LEVELS - 1)


def _counted_above(counts: np.ndarray) -> Floats:
    """Return how many pixels have each level or more."""
    return np.cumsum(counts[::-1])[::-1].astype(np.float64)


def example_row(
    id: str, labels: Labels, saliency: Saliency, truth: Labels | None
) -> dict[str, Any]:
    """Return what depth says of which share of a frame, and how salient it is where."""
    row: dict[str, Any] = {"id": id}
    for label in Label:
        row[f"depth_says_{label.name.lower()}"] = float((labels == label).mean())
    for label in (Label.SALIENT, Label.NOT_SALIENT):
        of_label = saliency[:0] if truth is None else saliency[truth == label]
        row[f"saliency_where_truth_is_{label.name.lower()}"] = _mean(of_label)
    says_nothing = np.isin(labels, (Label.UNKNOWN, Label.UNAVAILABLE))
    row["saliency_where_depth_says_nothing"] = _mean(saliency[says_nothing])
    return row


def _mean(values: Saliency) -> float | None:
    return float(values.mean()) if values.size else None
