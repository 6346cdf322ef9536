"""What an off-line model is tested on place by place: views of a drawn home of their own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.datasets.places import known_places
from curiosight.evaluation import HeldOut, TestView, describe_tests
from curiosight.experiments.components import make_learner, make_teacher
from curiosight.experiments.problems import Problems
from curiosight.experiments.truth import find_truth_of_all, noting_ids
from curiosight.learner.learner import SaliencyLearner
from curiosight.rooms.drawn_views import DrawnViews


class PlaceTests:
    """Test views of several rooms; a recording, of which every frame is learned, has none.

    place_of_frame: the room of each frame; None = nothing can be told. Of a home that changes
    neither, for its tests are of two homes. place_of_test: (n_tests,) of those that have an F1.
    """

    def __init__(self, config: Config, dataset: Dataset) -> None:
        self._config, self._dataset = config, dataset
        self.place_of_frame: Sequence[int] | None = None
        if isinstance(dataset, DrawnViews) and dataset.n_before_change is None:
            known = known_places(dataset)
            self.place_of_frame = known if known and len(set(known)) > 1 else None

    @property
    def place_of_test(self) -> npt.NDArray[np.int64]:
        return self._described[1]

    def errors(self, learner: SaliencyLearner) -> npt.NDArray[np.float64]:
        """Return (n_tests,) of 1 - F1 of a model with the settings' features."""
        return HeldOut(learner, self._described[0]).errors()

    @cached_property
    def _described(self) -> tuple[list[TestView], npt.NDArray[np.int64]]:
        """The views, drawn and described when they are first asked for."""
        config, dataset = self._config, self._dataset
        assert isinstance(dataset, DrawnViews)
        tests = dataset.own_test_views()
        truth = find_truth_of_all(
            tests,
            range(len(tests)),
            lambda: make_teacher(config, tests),
            max_frames=config.test.max_frames,
        )
        ids: list[str] = []
        labelled = noting_ids(truth.labelled_frames(Problems()), ids)
        views = list(describe_tests(make_learner(config, None), labelled))
        place_of = dict(zip(tests.ids, known_places(tests) or (), strict=True))
        scored = [place_of[id] for id, view in zip(ids, views, strict=True) if view.salient.any()]
        return views, np.array(scored, np.int64)
