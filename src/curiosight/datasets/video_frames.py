"""Read the frames of a video by their number, wherever they stand in it."""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import Any

import cv2

from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError
from curiosight.errors.inputs import check_file
from curiosight.frame import Rgb

# So many frames ahead are sooner decoded and passed over than sought.
MAX_STEPS = 30
RAW_PACKETS = -1
MIN_FRAME_BYTES = 4


class VideoFrames:
    """A video whose frames are asked for in any order; one thread at a time decodes.

    Frames are told by their time, which the file lists: seeking is right or is tried from
    farther ahead, to the beginning. Where the times cannot be listed, frames are counted from
    the beginning. Raises `DataError` for what is no video.

    is_turned: turn pictures as the file's metadata say; False = as they are stored.
    shape: (H, W, 3) of its frames. n_announced: frames that the file says it holds.
    """

    def __init__(self, path: Path, *, is_turned: bool) -> None:
        self.path = path
        self._is_turned = is_turned
        self._lock = threading.RLock()
        self._capture = _open_capture(path, is_turned)
        self._at = -1  # the frame that was decoded last; before the first, -1
        self._n_readable: int | None = None  # known once decoding broke off
        self._place_of: dict[float, int] | None = None
        self._is_listed = False
        announced = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        # A header may say anything; no frame is smaller than what names it in the file.
        self.n_announced = min(max(0, announced), path.stat().st_size // MIN_FRAME_BYTES)
        self.fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        try:
            self.shape: tuple[int, ...] = self.read(0).shape
        except UnreadableFile:
            raise DataError(path, "cannot be read as a video", "convert it, to .mp4 say") from None

    @property
    def n_frames(self) -> int:
        """Return how many frames the file lists."""
        with self._lock:
            places = self._places()
        return self.n_announced if places is None else len(places)

    def read(self, index: int) -> Rgb:
        """Decode a frame, (H, W, 3) uint8, red first; raises `UnreadableFile`."""
        with self._lock:
            if self._n_readable is not None and index >= self._n_readable:
                raise UnreadableFile(f"{self.path.name} breaks off before frame {index}")
            if not self._capture.isOpened():
                self._open()
            if not self._at <= index <= self._at + MAX_STEPS or self._at < 0 < index:
                self._seek(index)
            while self._at < index and self._grab():
                pass
            is_readable, bgr = self._capture.retrieve() if self._at == index else (False, None)
            if not is_readable:
                raise UnreadableFile(f"frame {index} of {self.path.name} cannot be decoded")
            rgb: Rgb = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
            return rgb

    def close(self) -> None:
        """Give back the decoder's memory; the next frame that is asked for opens it again."""
        with self._lock:
            self._capture.release()

    def _open(self) -> None:
        self._capture.release()
        self._capture = _open_capture(self.path, self._is_turned)
        self._at = -1

    def _grab(self) -> bool:
        """Decode the next frame; False where there is none."""
        before = self._at
        if before + 1 == self._n_readable:
            return False
        if not self._capture.grab():
            self._n_readable = before + 1
            return False
        self._at = before + 1
        if self._place_of is not None:
            self._at = self._place_of.get(self._capture.get(cv2.CAP_PROP_POS_MSEC), -1)
            if self._at <= before:
                # Its times are not those that it lists: count from the beginning.
                self._place_of = None
                self._open()
        return True

    def _seek(self, index: int) -> None:
        """Go to a frame or before it."""
        places = self._places()
        if places is None or index not in range(len(places)):
            if index < self._at or self._at < 0:
                self._open()
            return
        times = list(places)
        margin = 1
        while (first := round(times[index] * self.fps / 1000) - margin) > 0 and margin <= index:
            self._capture.set(cv2.CAP_PROP_POS_FRAMES, first)
            is_decoded = self._capture.grab()
            place = places.get(self._capture.get(cv2.CAP_PROP_POS_MSEC), -1) if is_decoded else -1
            if 0 <= place <= index:
                self._at = place
                return
            margin *= 4
        self._open()

    def _places(self) -> dict[float, int] | None:
        """Return the number of the frame at each time, ms; None where times tell no frames."""
        if not self._is_listed:
            self._is_listed = True
            self._place_of = _list_times(self.path)
            self._open()
            if self._place_of is not None and not (self._grab() and self._at == 0):
                self._place_of = None
                self._open()
        return self._place_of


def _list_times(path: Path) -> dict[float, int] | None:
    """Number the times of a video's frames without decoding them; None where they repeat."""
    capture = _open_capture(path, is_turned=False)
    if not capture.set(cv2.CAP_PROP_FORMAT, RAW_PACKETS):
        return None
    times = []
    while capture.grab():
        times.append(float(capture.get(cv2.CAP_PROP_POS_MSEC)))
    capture.release()
    # A file holds them in the order of decoding.
    places = {time: place for place, time in enumerate(sorted(times))}
    return places if len(places) == len(times) > 0 else None


def _open_capture(path: Path, is_turned: bool) -> Any:
    try:
        check_file(path, max_bytes=None)
    except OSError as error:
        found = f"cannot be read ({error.strerror})"
        raise DataError(path, found, "check the path") from None
    # FFmpeg would print its complaints of a damaged file; -8 is its word for silence.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    capture = cv2.VideoCapture(str(path))
    if not is_turned:
        # Among the parameters of the constructor it makes opening fail.
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    return capture
