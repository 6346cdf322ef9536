"""Read a video file: colour only, frame after frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from curiosight.datasets.dataset import GroundTruth
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.video_frames import VideoFrames
from curiosight.errors import DataError
from curiosight.frame import Frame, Pose

VIDEO_ENDINGS = frozenset({".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg"})
NS_PER_SECOND = 1_000_000_000


class Video:
    """A video without depth."""

    name = "video"
    evidence = "the ending of a video"
    camera = None
    has_depth = False
    remarks: tuple[str, ...] = ()

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the path is a file with the ending of a video."""
        return path.is_file() and path.suffix.lower() in VIDEO_ENDINGS

    def __init__(self, path: Path) -> None:
        self.path = path
        self._frames = VideoFrames(path, is_turned=True)
        n_frames = self._frames.n_announced
        if not n_frames:
            raise DataError(path, "cannot be read as a video", "convert it, to .mp4 say")
        self.ids = tuple(f"{index:06d}" for index in range(n_frames))
        self.poses: tuple[Pose | None, ...] = (None,) * n_frames

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        fps = self._frames.fps
        rgb, problem = np.zeros(self._frames.shape, np.uint8), None
        try:
            rgb = self._frames.read(index)
        except UnreadableFile as fault:
            problem = str(fault)
        return Frame(
            id=self.ids[index],
            rgb=rgb,
            stamp_ns=round(index / fps * NS_PER_SECOND) if fps > 0 else None,
            problem=problem,
        )

    def has_ground_truth(self, index: int) -> bool:
        """Return False: a video has no ground truth."""
        return False

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return None: a video has no ground truth."""
        return None
