"""What an exploration is tested on (sec. III-A)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.datasets.places import known_places
from curiosight.errors import DataError
from curiosight.evaluation import HeldOut, describe_tests
from curiosight.experiments.components import make_teacher
from curiosight.experiments.problems import Problems
from curiosight.experiments.truth import (
    Truth,
    find_truth,
    find_truth_of_all,
    noting_ids,
    split_frames,
)
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.rooms.drawn_views import DrawnViews


class ExplorationTests:
    """The frames that a learner is tested on while it explores, and those left to learn from.

    test_source: another recording to test on, instead of the settings' `test.every`. Where
        neither is given a room or home is tested on views of its own, after a change of the home
        on views as it is then, and a recording on its frames with
        ground truth; these and their neighbours (`test.gap`) are not learned from, unless that
        would leave too few others (`LEAST_TO_LEARN`).
    is_within_reach: (len(dataset),) of each frame whether it can be learned from.
    training: the frames to learn from. held_out, problems: of the frames of `truth`.
    places: (n_frames,) of each frame that has an F1 its room, -1 = not known; truth, for the report
        alone. None where rooms are not known.
    n_before_change: looks after which `go_on_after_change` is due; None = never.
    is_asked: for by settings or `test_source`, or by the room.
    unused_truth: why the ground truth of the recording cannot be tested against, where it was
        not asked for; None = it can, or there is none.
    """

    truth: Truth
    problems: Problems
    held_out: HeldOut
    places: npt.NDArray[np.int64] | None

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        learner: SaliencyLearner,
        teacher: Teaches,
        is_within_reach: npt.NDArray[np.bool_],
        test_source: Dataset | None = None,
    ) -> None:
        self._config, self._dataset = config, dataset
        self._learner, self._teacher = learner, teacher
        self.n_before_change: int | None = None
        if test_source is None and not config.test.every and isinstance(dataset, DrawnViews):
            test_source = dataset.own_test_views()
            self.n_before_change = dataset.n_before_change
        self.is_asked = test_source is not None or config.test.every > 0
        self.unused_truth: str | None = None
        self.training = self._choose(test_source, is_within_reach)

    def go_on_after_change(self) -> None:
        """Test from now on what is drawn as it is after its change."""
        assert isinstance(self._dataset, DrawnViews)
        self._test_on(self._truth_of(self._dataset.own_test_views(is_after=True)))

    def _choose(
        self, test_source: Dataset | None, is_within_reach: npt.NDArray[np.bool_]
    ) -> Sequence[int]:
        """Set up what is tested on, and return the frames to learn from."""
        training: Sequence[int] = range(len(self._dataset))
        if test_source is not None:
            truth = self._truth_of(test_source)
        else:
            training, tests = split_frames(self._config, self._dataset, is_within_reach)
            most = self._config.test.max_frames
            truth = find_truth(self._dataset, tests, self._teacher, max_frames=most)
        try:
            self._test_on(truth)
        except DataError as error:
            if self.is_asked:
                raise
            self.unused_truth = error.found
            self._test_on(Truth("nothing", self._dataset, (), None))
            return range(len(self._dataset))
        return training

    def _test_on(self, truth: Truth) -> None:
        self.truth = truth
        self.problems = Problems()
        ids: list[str] = []
        labelled = noting_ids(truth.labelled_frames(self.problems), ids)
        self.held_out = HeldOut(self._learner, describe_tests(self._learner, labelled))
        known = known_places(truth.dataset) if truth.indices else None
        self.places = None
        if known is not None:
            place_of = dict(zip(truth.dataset.ids, known, strict=True))
            scored = [place_of[ids[number]] for number in self.held_out.scored]
            self.places = np.array(scored, np.int64)

    def _truth_of(self, test_source: Dataset) -> Truth:
        return find_truth_of_all(
            test_source,
            range(len(test_source)),
            lambda: make_teacher(self._config, test_source),
            max_frames=self._config.test.max_frames,
        )
