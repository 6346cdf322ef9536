"""What a learner is taught by, and what it takes down of each frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame
from curiosight.learner.description import Counts, Description, Saliency
from curiosight.learner.experts import Change
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
    """

    frame: Frame
    segmentation: Segmentation
    description: Description
    scores: Votes
    counts: tuple[Counts, Counts]
    error: float | None
    change: Change

    @property
    def saliency(self) -> Saliency:
        """(h, w) map of the shrunken image, in [0, 1], before learning."""
        return self.scores[self.description.row_of_pixel]
