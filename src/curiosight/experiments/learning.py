"""Learn a whole recording at once: the paper's off-line model, its lower bound of the error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.components import make_learner, make_teacher, place
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.learner import SaliencyLearner, fit_labels
from curiosight.segmentation import Teacher


class OffLine:
    """The off-line model of some frames: each is sampled once, then every tree grows at once.

    A frame gives up to `learner.n_pixels` labelled pixels. Where all frames together give more
    than `forest.max_samples`, a uniformly random choice of that many is kept, so that every
    frame counts alike.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        *,
        indices: Sequence[int] | None = None,
        teacher: Teacher | None = None,
        seed: int | np.random.SeedSequence | None = None,
        problems: Problems | None = None,
    ) -> None:
        self.config = config
        self.dataset = dataset
        self.indices = range(len(dataset)) if indices is None else indices
        self.teacher = teacher or make_teacher(config, dataset)
        rng = np.random.default_rng(config.run.seed if seed is None else seed)
        self.learner: SaliencyLearner = make_learner(config, self.teacher, rng)
        self.problems = problems or Problems()
        self.n_frames = 0
        self.n_sampled = 0
        self._rows: list[Any] = []
        self._is_salient: list[Any] = []

    def __iter__(self) -> Iterator[Frame]:
        """Sample each frame; yield it when its samples are taken."""
        with Prefetch(self.dataset, memory_mb=self.config.run.memory_mb) as frames:
            for turn, index in enumerate(self.indices):
                frame = frames[int(index)]
                frames.expect([int(i) for i in self.indices[turn + 1 : turn + 4]])
                self._sample(frame)
                yield frame

    def finish(self) -> SaliencyLearner:
        """Grow the trees on what was sampled so far and return the model.

        It stays untrained where the frames did not show both objects and what is none.
        """
        if self.n_sampled:
            self.learner.forest.fit(np.concatenate(self._rows), np.concatenate(self._is_salient))
        return self.learner

    def _sample(self, frame: Frame) -> None:
        segmentation = self.learner.segment(frame)
        self.problems.add(frame, segmentation.problem)
        description = self.learner.describe(frame.rgb)
        labels = fit_labels(segmentation.labels, description)
        rows, is_salient = self.learner.sample(description, labels)
        self._rows.append(rows)
        self._is_salient.append(is_salient)
        self.n_frames += 1
        self.n_sampled += len(rows)

    def summary(self) -> dict[str, Any]:
        """Return what was learned from, JSON-able."""
        return {
            "source": place(self.dataset),
            "layout": self.dataset.name,
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            "scene": self.teacher.survey.scene,
            "frames": self.n_frames,
            "samples_drawn": self.n_sampled,
            "samples_kept": self.learner.forest.n_samples,
            "problems": self.problems.counts(),
        }
