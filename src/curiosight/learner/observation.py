"""What a learner is taught by, and what it takes down of each frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame
from curiosight.learner.description import Counts, Description, Saliency
from curiosight.learner.experts import Change
from curiosight.learner.features import Rows
from curiosight.learner.lesson import Taught
from curiosight.learner.sight import Sight
from curiosight.teacher import Segmentation

Votes = npt.NDArray[np.float32]


class Teaches(Protocol):
    """Whatever labels a frame's pixels: the depth segmentation, or a detector of one's own."""

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel; none as known where the frame has a `problem`."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """What one frame showed, was predicted to show, and taught.

    scores: (n,) float32 saliency of each row of `description`, before learning.
    counts: (n,) salient and (n,) other pixels of each, by the segmentation.
    error: 1 - F1 between them and the segmentation (eq. 1); None where no pixel is salient.
    change: the trees that were grown anew.
    taught: what makes another learner of the same state learn the same.
    """

    frame: Frame
    segmentation: Segmentation
    description: Description
    scores: Votes
    counts: tuple[Counts, Counts]
    error: float | None
    change: Change
    taught: Taught

    @property
    def saliency(self) -> Saliency:
        """(h, w) map of the shrunken image, in [0, 1], before learning."""
        return self.scores[self.description.row_of_pixel]


class Judges(Protocol):
    """A learner, as far as it tells how wrong it is."""

    def error_of(
        self, rows: Rows, counts: tuple[Counts, Counts], sight: Sight | None
    ) -> float | None: ...


@dataclass(frozen=True, slots=True, eq=False)
class Rescoring:
    """Tells, when called, the error of a look by the model as it is then; None as there.

    It holds the view's description, not its images.
    """

    learner: Judges
    rows: Rows
    counts: tuple[Counts, Counts]
    sight: Sight | None

    def __call__(self) -> float | None:
        return self.learner.error_of(self.rows, self.counts, self.sight)
