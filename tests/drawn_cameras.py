"""Cameras that see a small room: of our own making, and as pyrealsense2 and depthai have them."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame
from curiosight.robot.cameras.camera import CameraError
from curiosight.robot.feed import EndedError, Feed, Shot
from room import View, kinect, poses_around, render

UNIT = 0.0005  # metres: twice as fine as usual
NEAR, MIDDLE = 1000, (59, 83)
FIRST_S = 1_700_000_000


@cache
def room_views(n_views: int = 4) -> tuple[View, ...]:
    return tuple(render(kinect(), pose) for pose in poses_around(n_views))


def shots_of(feed: Feed) -> tuple[list[Shot], Exception]:
    """Ask for frames until something is raised."""
    shots = []
    try:
        while True:
            if (shot := feed.newest(0.05)) is not None:
                shots.append(shot)
    except (CameraError, EndedError) as end:
        return shots, end


class DrawnCamera:
    """A `Device` of ours: 30 frames a second of the room, as many as `n_frames`, then `after`.

    after: what it raises; None = it is silent.
    """

    waits = False
    remarks = ("drawn",)

    def __init__(
        self,
        n_frames: int = 10_000,
        *,
        after: Exception | None = None,
        has_depth: bool = True,
        name: str = "drawn",
    ) -> None:
        self.name, self.has_depth = name, has_depth
        self._left, self._after = n_frames, after
        self.n_decoded, self.is_closed = 0, False

    def grab(self, timeout_s: float) -> int | None:
        time.sleep(1 / 30)
        if self._left:
            self._left -= 1
            return self._left
        if self._after is not None:
            raise self._after
        return None

    def frame(self, grabbed: int) -> Frame:
        self.n_decoded += 1
        view = room_views()[grabbed % len(room_views())]
        depth, camera = (view.depth, kinect()) if self.has_depth else (None, None)
        return Frame(f"{grabbed}", view.rgb, depth, camera)

    def silence(self) -> str:
        return "it was drawn so"

    def close(self) -> None:
        self.is_closed = True


def at_its_end() -> EndedError:
    return EndedError("drawn is at its end")


class DrawnRealSense:
    """A software device of pyrealsense2 with a depth and a colour sensor.

    T_colour_depth: where its depth camera is, by a shift along x in metres.
    """

    def __init__(self, *, shift: float = 0.0, serial: str = "SW123") -> None:
        import pyrealsense2 as rs

        self._rs = rs
        self.camera, self.depth_camera = kinect(), Camera(160, 120, 120.0, 120.0, 80.0, 60.0)
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.serial_number, serial)
        self.device.register_info(rs.camera_info.name, "Drawn camera")
        self._depth, self._colour = (self.device.add_sensor(name) for name in ("Depth", "Color"))
        depth = self._stream(rs.stream.depth, rs.format.z16, 2, self.depth_camera)
        colour = self._stream(rs.stream.color, rs.format.rgb8, 3, self.camera)
        self._depth.add_read_only_option(rs.option.depth_units, UNIT)
        self._of_depth = self._depth.add_video_stream(depth, True).as_video_stream_profile()
        self._of_colour = self._colour.add_video_stream(colour, True).as_video_stream_profile()
        beside = rs.extrinsics()
        beside.rotation, beside.translation = np.eye(3).ravel().tolist(), [shift, 0.0, 0.0]
        self._of_depth.register_extrinsics_to(self._of_colour, beside)

    def _stream(self, kind: Any, form: Any, n_bytes: int, camera: Camera) -> Any:
        rs = self._rs
        stream, intrinsics = rs.video_stream(), rs.intrinsics()
        intrinsics.width, intrinsics.height = camera.width, camera.height
        intrinsics.fx, intrinsics.fy = camera.fx, camera.fy
        intrinsics.ppx, intrinsics.ppy = camera.cx, camera.cy
        intrinsics.model, intrinsics.coeffs = rs.distortion.none, [0.0] * 5
        stream.type, stream.fmt, stream.bpp = kind, form, n_bytes
        stream.index, stream.uid, stream.fps = 0, int(kind == rs.stream.color), 30
        stream.width, stream.height, stream.intrinsics = camera.width, camera.height, intrinsics
        return stream

    def show_colour(self, number: int, rgb: npt.NDArray[np.uint8], late_ms: float = 2.0) -> None:
        frame = self._frame(rgb, self._of_colour, number, late_ms)
        self._colour.on_video_frame(frame)

    def show_depth(self, number: int, units: npt.NDArray[np.uint16]) -> None:
        frame = self._frame(units, self._of_depth, number, 0.0)
        frame.depth_units = UNIT
        self._depth.on_video_frame(frame)

    def _frame(self, pixels: npt.NDArray[Any], profile: Any, number: int, late_ms: float) -> Any:
        frame = self._rs.software_video_frame()
        frame.pixels = np.ascontiguousarray(pixels)
        frame.stride, frame.bpp = pixels.strides[0], pixels.strides[1]
        frame.timestamp = FIRST_S * 1000 + number * 100 / 3 + late_ms
        frame.domain = self._rs.timestamp_domain.system_time
        frame.frame_number, frame.profile = number, profile
        return frame

    def show(self, number: int) -> None:
        """Show the room, marked by the number: colour in a corner, depth before the middle."""
        view = room_views()[number % len(room_views())]
        rgb, depth = view.rgb.copy(), np.nan_to_num(view.depth / UNIT).astype(np.uint16)
        rgb[:8, :8], depth[54:66, 74:86] = number % 256, NEAR + number % 256
        self.show_depth(number, depth)
        self.show_colour(number, rgb)

    @contextmanager
    def showing(self) -> Iterator[None]:
        """Show frame after frame, in a thread, until somebody has closed it."""
        is_over = threading.Event()

        def run() -> None:
            with suppress(RuntimeError):  # it was closed
                for number in itertools.count():
                    self.show(number)
                    if is_over.wait(1 / 30):
                        return

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            is_over.set()
            thread.join()
