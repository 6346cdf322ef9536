"""A teacher that first looks round: the survey is made of the first frames that come."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from curiosight.errors import DataError
from curiosight.frame import Frame
from curiosight.learner.observation import Teaches
from curiosight.teacher import Segmentation

N_FRAMES = 8
# Frames of the survey are at least so far apart, by their stamps.
APART_NS = 300_000_000
MAX_RANGE = 4.0


class SurveyingTeacher:
    """Say nothing of the first frames, and teach by what they show together from then on.

    make: a teacher by the frames of the survey; those have depth and no problem.
    """

    def __init__(
        self, make: Callable[[Sequence[Frame]], Teaches], n_frames: int = N_FRAMES
    ) -> None:
        if n_frames < 1:
            raise ValueError(f"n_frames: expected 1 or more, got {n_frames}")
        self._make, self._n_frames = make, n_frames
        self._frames: list[Frame] = []
        self._teacher: Teaches | None = None

    @property
    def is_ready(self) -> bool:
        return self._teacher is not None

    def segment(self, frame: Frame) -> Segmentation:
        if frame.problem is not None or frame.depth is None:
            return Segmentation.of_nothing(frame, frame.problem or "no depth", MAX_RANGE)
        if self._teacher is None:
            told = self._look_round(frame)
        if self._teacher is None:
            return Segmentation.of_nothing(frame, told, MAX_RANGE)
        return self._teacher.segment(frame)

    def _look_round(self, frame: Frame) -> str:
        """Take a frame to the survey; return, in words, how far it is."""
        last = self._frames[-1].stamp_ns if self._frames else None
        if last is None or frame.stamp_ns is None or abs(frame.stamp_ns - last) >= APART_NS:
            self._frames.append(frame)
        told = f"looking round: {len(self._frames)} of {self._n_frames} frames"
        if len(self._frames) >= self._n_frames:
            frames, self._frames = self._frames, []
            try:
                self._teacher = self._make(frames)
            except (ValueError, DataError) as error:  # others may show more
                told = f"looking round: {error}"
        return told
