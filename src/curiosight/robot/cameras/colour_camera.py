"""Colour cameras that OpenCV knows (V4L2, UVC), and a video in their place."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2

from curiosight.datasets.layouts.ros_bag import frame_id
from curiosight.frame import Frame, Rgb
from curiosight.robot.cameras.camera import CameraError
from curiosight.robot.feed import PAUSE_S, RATE_HZ, EndedError

NS_PER_SECOND = 1_000_000_000
# Between two questions to a camera that has nothing.
NAP_S = 0.02
DEVICES = Path("/dev")


class ColourCamera:
    """A camera of colour alone: by its number, or a video file, which is shown at its own pace.

    Raises `CameraError` where there is none.
    """

    has_depth = False

    def __init__(self, which: str) -> None:
        self.name = f"camera:{which}"
        self.remarks: tuple[str, ...] = ("colour alone: it is mapped, and teaches nothing",)
        self._is_video = self.waits = not which.isdecimal() and Path(which).is_file()
        self._capture = self._open(which)
        fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        self._period_s = 1 / (fps if 0 < fps < 1000 else RATE_HZ)
        self._n = 0
        self._due_at = 0.0
        self._is_closed = threading.Event()

    def _open(self, which: str) -> Any:
        if which.isdecimal():
            self._check_number(int(which))
        elif not Path(which).exists():
            raise CameraError(self.name, "there is no such device or video", _remedy())
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        with _silent():
            capture = cv2.VideoCapture(int(which) if which.isdecimal() else which)
        if not capture.isOpened():
            if self._is_video:
                raise CameraError(
                    self.name, "is no video", "give a video, or the number of a camera"
                )
            found = "cannot be opened, or another program has it"
            raise CameraError(self.name, found, _remedy())
        if not self._is_video:
            capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        return capture

    def _check_number(self, number: int) -> None:
        """Raise `CameraError` where the system lists its cameras, and this is none of them."""
        if not DEVICES.is_dir() or os.name != "posix" or os.uname().sysname != "Linux":
            return
        if not (DEVICES / f"video{number}").exists():
            found = f"there is no camera {number} (looked for {DEVICES}/video{number})"
            raise CameraError(self.name, found, _remedy())

    def grab(self, timeout_s: float) -> tuple[Rgb, int] | None:
        if self._is_video:
            self._wait_for_its_turn()
        is_there, bgr = self._capture.read()
        if not is_there and self._is_video:
            raise EndedError(f"{self.name} is at its end")
        if not is_there:
            self._is_closed.wait(NAP_S)
            return None
        number, self._n = self._n, self._n + 1
        return bgr, round(number * self._period_s * 1e9) if self._is_video else time.time_ns()

    def _wait_for_its_turn(self) -> None:
        """Wait until the next image of a video is due: after the last, or at once after a pause."""
        now = time.monotonic()
        if now - self._due_at > PAUSE_S:
            self._due_at = now
        self._is_closed.wait(max(0.0, self._due_at - now))
        self._due_at += self._period_s

    def frame(self, grabbed: tuple[Rgb, int]) -> Frame:
        bgr, stamp_ns = grabbed
        return Frame(frame_id(stamp_ns), cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), stamp_ns=stamp_ns)

    def silence(self) -> str:
        return "the driver answers, without an image" if self._n else "not one so far"

    def close(self) -> None:
        self._is_closed.set()
        self._capture.release()


@contextmanager
def _silent() -> Iterator[None]:
    """Have OpenCV say nothing of its own: what it found is said in one line."""
    levels = cv2.utils.logging
    before = levels.getLogLevel()
    levels.setLogLevel(levels.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        levels.setLogLevel(before)


def _remedy() -> str:
    """Name the cameras that there are."""
    found = sorted(path.name.removeprefix("video") for path in DEVICES.glob("video[0-9]*"))
    if not found:
        return "plug one in"
    return f"there are camera:{', camera:'.join(found)}"
