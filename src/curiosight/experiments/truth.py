"""What predictions are tested against: ground truth where there is any, else the teacher."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.components import place
from curiosight.frame import Frame, Rgb
from curiosight.learner import Teaches

Labels = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The frames of a recording to test on, and where their labels come from."""

    kind: Literal["ground truth", "teacher", "nothing"]
    dataset: Dataset
    indices: tuple[int, ...]
    teacher: Teaches | None

    def __iter__(self) -> Iterator[tuple[Frame, Labels | None]]:
        """Yield each frame with its (H, W) labels, None where it or its ground truth is bad."""
        for index in self.indices:
            frame = self.dataset[index]
            labels = None
            if frame.problem is None:
                try:
                    labels = self._labels(index, frame)
                except DataError as error:
                    frame = replace(frame, problem=f"ground truth: {error.found}")
            yield frame, labels

    def labelled_frames(self) -> Iterator[tuple[Rgb, Labels]]:
        """Yield images and labels of the usable frames."""
        return ((frame.rgb, labels) for frame, labels in self if labels is not None)

    def _labels(self, index: int, frame: Frame) -> Labels:
        if self.kind == "ground truth":
            labels = self.dataset.ground_truth(index)
            assert labels is not None
            return labels
        assert self.teacher is not None
        return self.teacher.segment(frame).labels


def find_truth(dataset: Dataset, indices: Sequence[int], teacher: Teaches | None) -> Truth:
    """Return what the frames can be tested against.

    Where any frame has ground truth, only those that have it count; else the teacher's labels
    stand in.
    """
    with_truth = tuple(index for index in indices if dataset.has_ground_truth(index))
    if with_truth:
        return Truth("ground truth", dataset, with_truth, teacher)
    if not len(indices):
        return Truth("nothing", dataset, (), None)
    if teacher is None:
        found = "has neither ground truth nor depth to compare with"
        raise DataError(place(dataset), found, "give --ground-truth")
    return Truth("teacher", dataset, tuple(indices), teacher)
