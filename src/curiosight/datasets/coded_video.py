"""Decode video that needs a decoder through PyAV, frame by frame, with all its bits."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError

# So many frames ahead are sooner decoded and passed over than sought.
MAX_STEPS = 30
# Depth as it is stored; any other form of pixels would be brought to eight bits.
DEEP = ("gray16le", "gray16be", "grayf32le", "gray12le", "gray10le")


class CodedVideo:
    """One stream of a file whose frames are asked for by time, in any order; one thread at a time.

    stream: its number in the file. Raises `DataError` where PyAV is not installed.
    """

    def __init__(self, path: Path, stream: int) -> None:
        require_av(path)
        self.path, self._stream = path, stream
        self._lock = threading.Lock()
        self._container: Any = None
        self._frames: Iterator[Any] = iter(())
        self._at_ns = -1

    def read(self, time_ns: int, gap_ns: int, *, is_depth: bool) -> npt.NDArray[Any]:
        """Return the frame of a time; gap_ns: to the next one, about. Raises `UnreadableFile`.

        Colour is (H, W, 3) uint8, depth (H, W) as it is stored.
        """
        with self._lock:
            try:
                frame = self._frame(time_ns, gap_ns)
                if frame is not None:
                    return _pixels(frame, is_depth=is_depth)
            # What FFmpeg makes of damage has many names.
            except Exception as error:
                self._close()
                what = f"{self.path.name} at {time_ns / 1e9:.3f} s cannot be decoded"
                raise UnreadableFile(what) from error
        raise UnreadableFile(f"{self.path.name} has no image at {time_ns / 1e9:.3f} s")

    def _frame(self, time_ns: int, gap_ns: int) -> Any | None:
        half_ns = max(gap_ns // 2, 1_000_000)
        if not 0 <= self._at_ns < time_ns - half_ns < self._at_ns + MAX_STEPS * gap_ns:
            self._seek(time_ns)
        for frame in self._frames:
            self._at_ns = round((frame.time or 0.0) * 1e9)
            if self._at_ns >= time_ns - half_ns:
                return frame if self._at_ns <= time_ns + half_ns else None
        self._at_ns = -1
        return None

    def _seek(self, time_ns: int) -> None:
        import av

        if self._container is None:
            self._container = av.open(str(self.path))
        stream = self._container.streams[self._stream]
        self._container.seek(int(time_ns / 1e9 / stream.time_base), stream=stream)
        self._frames = self._container.decode(stream)

    def _close(self) -> None:
        if self._container is not None:
            self._container.close()
        self._container, self._frames, self._at_ns = None, iter(()), -1


def count_frames(path: Path) -> int:
    """Return how many images the video of a file holds; raises `DataError` where it is none."""
    import av

    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            n_told = int(stream.frames)
            return n_told or sum(packet.size > 0 for packet in container.demux(stream))
    except (av.FFmpegError, IndexError) as error:
        raise DataError(path, f"cannot be read as a video ({error})", "copy it again") from None


def require_av(path: Path) -> None:
    """Raise `DataError` where PyAV is not installed."""
    try:
        import av  # noqa: F401
    except ImportError:
        found = "is coded in a way that needs PyAV, which is missing"
        raise DataError(path, found, "pip install 'curiosight[video]'") from None


def _pixels(frame: Any, *, is_depth: bool) -> npt.NDArray[Any]:
    if not is_depth:
        rgb: npt.NDArray[np.uint8] = frame.to_ndarray(format="rgb24")
        return rgb
    if frame.format.name not in DEEP:
        raise UnreadableFile(f"depth is stored as {frame.format.name}, which is no depth")
    depth: npt.NDArray[Any] = frame.to_ndarray()
    return depth
