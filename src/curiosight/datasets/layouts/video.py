"""Read a video file: colour only, frame after frame."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from curiosight.datasets.recording import GroundTruth
from curiosight.errors import DataError
from curiosight.frame import Frame, Pose, Rgb

VIDEO_ENDINGS = frozenset({".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg"})
NS_PER_SECOND = 1_000_000_000


class Video:
    """A video without depth. Frames are read in order; going back starts again at the front."""

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
        self._capture = _open_capture(path)
        n_frames = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        first = self._capture.read()[1] if n_frames > 0 else None
        if first is None:
            raise DataError(path, "cannot be read as a video", "convert it, to .mp4 say")
        self._shape: tuple[int, ...] = first.shape
        self._fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        self._next = 1
        self.ids = tuple(f"{index:06d}" for index in range(n_frames))
        self.poses: tuple[Pose | None, ...] = (None,) * n_frames

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        rgb = self._read(index)
        return Frame(
            id=self.ids[index],
            rgb=np.zeros(self._shape, np.uint8) if rgb is None else rgb,
            stamp_ns=round(index / self._fps * NS_PER_SECOND) if self._fps > 0 else None,
            problem=f"{self.path.name} cannot be decoded here" if rgb is None else None,
        )

    def has_ground_truth(self, index: int) -> bool:
        """Return False: a video has no ground truth."""
        return False

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return None: a video has no ground truth."""
        return None

    def _read(self, index: int) -> Rgb | None:
        """Decode frame `index`, passing over those between; None where the stream breaks off."""
        if index < self._next:
            self._capture = _open_capture(self.path)
            self._next = 0
        while self._next < index:
            self._capture.grab()
            self._next += 1
        is_readable, bgr = self._capture.read()
        self._next += 1
        rgb: Rgb | None = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB) if is_readable else None
        return rgb


def _open_capture(path: Path) -> Any:
    # FFmpeg would print its complaints of a damaged file; -8 is its word for silence.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    return cv2.VideoCapture(str(path))
