"""What a teacher said in its own thread, told to the learner in another."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from curiosight.frame import Frame
from curiosight.robot.feed import Shot
from curiosight.teacher import Segmentation
from curiosight.teacher.cloud.tracking import UpTracker
from curiosight.teacher.memory.temporal import Remembered


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What the teacher says of a frame.

    number: of the frames it labelled, from 1; 0 = not counted.
    noted: what the frame changed of its memory; None = nothing, or it has none.
    """

    shot: Shot
    segmentation: Segmentation
    number: int = 0
    noted: Remembered | UpTracker | None = None


class Told:
    """A teacher that repeats what another has said already of this very frame."""

    def __init__(self) -> None:
        self._verdict: Verdict | None = None

    @contextmanager
    def says(self, verdict: Verdict) -> Iterator[None]:
        """Repeat this one as long as the context lasts."""
        self._verdict = verdict
        yield
        self._verdict = None

    def segment(self, frame: Frame) -> Segmentation:
        verdict = self._verdict
        if verdict is None or verdict.shot.frame is not frame:
            raise ValueError("frame: expected the one that was labelled before, got another")
        return verdict.segmentation
