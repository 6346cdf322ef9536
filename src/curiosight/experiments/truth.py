"""What predictions are tested against: ground truth where there is any, else the teacher."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset, KnowsDistances, Prefetch
from curiosight.errors import DataError
from curiosight.evaluation import away_from, every_nth
from curiosight.experiments.components import place
from curiosight.experiments.problems import Problems
from curiosight.frame import Depth, Frame
from curiosight.learner.observation import Teaches

Labels = npt.NDArray[np.uint8]
Kind = Literal["ground truth", "teacher", "nothing"]
# Where testing was not asked for: of the frames, those that must be left to learn from if the
# frames with ground truth are to be kept out of learning.
LEAST_TO_LEARN = 0.5
# Of a recording without ground truth every so many frames are tested on.
TEST_EVERY = 10


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The frames of a recording to test on, and where their labels come from."""

    kind: Kind
    dataset: Dataset
    indices: tuple[int, ...]
    teacher: Teaches | None

    def __iter__(self) -> Iterator[tuple[Frame, Labels | None]]:
        """Yield each frame with its (H, W) labels, None where it or its ground truth is bad."""
        with Prefetch(self.dataset) as frames:
            for index, frame in zip(self.indices, frames.in_order(self.indices), strict=True):
                labels = None
                if frame.problem is None:
                    try:
                        labels = self._labels(index, frame)
                    except DataError as error:
                        frame = replace(frame, problem=f"ground truth: {error.found}")
                yield frame, labels

    def true_depth(self, index: int) -> Depth | None:
        """Return a frame's real distances; None where the recording knows only its sensor's."""
        return self.dataset.true_depth(index) if isinstance(self.dataset, KnowsDistances) else None

    def labelled_frames(self, problems: Problems) -> Iterator[tuple[Frame, Labels]]:
        """Yield the usable frames with their labels; note what is wrong with the others.

        Raises `DataError` at the end where not one frame could be used.
        """
        n_usable = 0
        for frame, labels in self:
            problems.add(frame)
            if labels is not None:
                n_usable += 1
                yield frame, labels
        if self.indices and not n_usable:
            sentence = next(problems.sentences(len(self.indices), "cannot be tested on"), "")
            raise DataError(place(self.dataset), sentence, "mend them, or test on others")

    def _labels(self, index: int, frame: Frame) -> Labels:
        if self.kind == "ground truth":
            labels = self.dataset.ground_truth(index)
            assert labels is not None
            return labels
        labels = self.teacher_labels(frame)
        assert labels is not None
        return labels

    def teacher_labels(self, frame: Frame) -> Labels | None:
        """Return the (H, W) labels that the teacher gives a frame; None without a teacher."""
        return None if self.teacher is None else self.teacher.segment(frame).labels


def find_truth(
    dataset: Dataset,
    indices: Sequence[int],
    teacher: Teaches | None,
    *,
    max_frames: int | None = None,
) -> Truth:
    """Return what the frames can be tested against.

    Where any frame has ground truth, only those that have it count; else the teacher's labels
    stand in. max_frames: of more, that many are taken, evenly spread; None = all.
    """
    if not len(indices):
        return Truth("nothing", dataset, (), None)
    with_truth = [index for index in indices if dataset.has_ground_truth(index)]
    if not with_truth and teacher is None:
        found = "has neither ground truth nor depth to compare with"
        raise DataError(place(dataset), found, "give --ground-truth")
    kind: Kind = "ground truth" if with_truth else "teacher"
    return Truth(kind, dataset, spread(with_truth or indices, max_frames), teacher)


def find_truth_of_all(
    dataset: Dataset,
    indices: Sequence[int],
    make_teacher: Callable[[], Teaches],
    *,
    max_frames: int | None = None,
) -> Truth:
    """Return what frames can be tested against that were chosen for it, see `find_truth`.

    make_teacher: is called only where no frame has ground truth.
    """
    has_truth = any(map(dataset.has_ground_truth, indices))
    teacher = None if has_truth else make_teacher()
    return find_truth(dataset, indices, teacher, max_frames=max_frames)


def noting_ids(
    labelled: Iterable[tuple[Frame, Labels]], ids: list[str]
) -> Iterator[tuple[Frame, Labels]]:
    """Yield labelled frames, and add their ids to a list."""
    for frame, labels in labelled:
        ids.append(frame.id)
        yield frame, labels


def spread(indices: Sequence[int], max_frames: int | None) -> tuple[int, ...]:
    """Return all of some frames, or of more than `max_frames` that many, evenly spread."""
    n_kept = len(indices) if max_frames is None else min(len(indices), max_frames)
    places = np.linspace(0, len(indices) - 1, n_kept).astype(int)
    return tuple(int(indices[place]) for place in places)


def split_frames(
    config: Config, dataset: Dataset, is_within_reach: npt.NDArray[np.bool_] | None = None
) -> tuple[Sequence[int], Sequence[int]]:
    """Return the frames of a recording to learn from and those to test on.

    Where the settings do not keep every so many (`test.every`), those with ground truth are kept
    and their neighbours left out, unless too few others would be left (`LEAST_TO_LEARN`).

    is_within_reach: (len(dataset),) of each frame whether it can be learned from; None = all.
    """
    if config.test.every:
        training, test = every_nth(len(dataset), config.test.every, gap=config.test.gap)
        return training.tolist(), test.tolist()
    if is_within_reach is None:
        is_within_reach = np.ones(len(dataset), np.bool_)
    with_truth = [index for index in range(len(dataset)) if dataset.has_ground_truth(index)]
    test = np.array(spread(with_truth, config.test.max_frames), np.int64)
    training = away_from(test, len(dataset), config.test.gap)
    if is_within_reach[training].sum() < LEAST_TO_LEARN * is_within_reach.sum():
        training = np.arange(len(dataset))
    return training.tolist(), test.tolist()


def split_or_every_nth(config: Config, dataset: Dataset) -> tuple[Sequence[int], Sequence[int]]:
    """Return what `split_frames` does; without ground truth every `TEST_EVERY`-th is tested on.

    The teacher's labels stand in there, of frames that nobody learns from.
    """
    training, tests = split_frames(config, dataset)
    if tests:
        return training, tests
    kept = replace(config, test=replace(config.test, every=TEST_EVERY))
    return split_frames(kept, dataset)
