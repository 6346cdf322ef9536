"""A teacher that first looks round: the survey is made of the frames that come."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from curiosight.errors import DataError
from curiosight.frame import Frame, Mount
from curiosight.learner.observation import Teaches
from curiosight.teacher import Segmentation
from curiosight.teacher.memory.gravity import UP_OF_MOUNT

# Frames of the first survey, and of the second, which takes the place of the first.
N_FRAMES = (8, 24)
# They are at least so far apart by their stamps: until the first survey, and then.
APART_NS = (300_000_000, 2_000_000_000)
MAX_RANGE = 4.0


class SurveyingTeacher:
    """Say nothing of the first frames, and teach by what they show together from then on.

    make: a teacher by the frames of the survey; those have depth and no problem. It is asked again
        once there are more.
    """

    def __init__(
        self,
        make: Callable[[Sequence[Frame]], Teaches],
        n_frames: tuple[int, int] = N_FRAMES,
    ) -> None:
        if not 1 <= n_frames[0] <= n_frames[1]:
            raise ValueError(f"n_frames: expected 1 or more, then as many or more, got {n_frames}")
        self._make, self._n_frames = make, n_frames
        self._frames: list[Frame] = []
        self._teacher: Teaches | None = None
        self._is_settled = False

    @property
    def is_ready(self) -> bool:
        return self._teacher is not None

    def segment(self, frame: Frame) -> Segmentation:
        if frame.problem is not None or frame.depth is None:
            return Segmentation.of_nothing(frame, frame.problem or "no depth", MAX_RANGE)
        told = "" if self._is_settled else self._look_round(frame)
        if self._teacher is None:
            return Segmentation.of_nothing(frame, told, MAX_RANGE)
        return self._teacher.segment(frame)

    def _look_round(self, frame: Frame) -> str:
        """Take a frame to the survey; return, in words, how far it is."""
        stage = int(self.is_ready)
        last = self._frames[-1].stamp_ns if self._frames else None
        if last is None or frame.stamp_ns is None or abs(frame.stamp_ns - last) >= APART_NS[stage]:
            self._frames.append(frame)
        n_wanted = self._n_frames[stage]
        if len(self._frames) < n_wanted:
            return f"looking round: {len(self._frames)} of {n_wanted} frames"
        try:
            self._teacher = self._make(self._frames)
        except (ValueError, DataError) as error:  # others may show more
            self._frames = []
            return f"looking round: {error}"
        if len(self._frames) >= self._n_frames[1]:
            self._frames, self._is_settled = [], True
        return ""


def mount_by_poses(frames: Sequence[Frame]) -> Mount | None:
    """Return how the camera is held, where poses tell: the world's z points up (REP 103)."""
    ups = [
        one.T_world_camera[2, :3] for one in frames if one.T_world_camera is not None
    ]  # the world's z in the camera's axes
    if not ups:
        return None
    up = np.mean(ups, axis=0)
    return max(UP_OF_MOUNT, key=lambda mount: float(UP_OF_MOUNT[mount] @ up))
