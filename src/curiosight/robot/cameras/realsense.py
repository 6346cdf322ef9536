"""RealSense cameras through pyrealsense2, and recordings of them played in their place.

Its pipeline and syncer are not used: in playback they pair depth with the colour of another
moment, and give frames twice. Frames of both streams are paired here, by their stamps.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.cameras.depth_camera import DepthCamera, with_window
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.layouts.ros_bag import frame_id
from curiosight.frame import Camera, Frame
from curiosight.robot.cameras.camera import CameraError, importing
from curiosight.robot.cameras.pairing import Pairing
from curiosight.robot.feed import RATE_HZ, EndedError

COLOUR, DEPTH = 0, 1
# Profiles nearest to this are taken: more pixels make maps later, not better.
WANTED_SIZE = (640, 480)
RECORDINGS = (".db3", ".bag")
# Of the time between two frames: what is farther apart is not of one moment.
PAIR_SHARE = 0.6
N_QUEUED = 8
# A stream that has given nothing for so long has stopped.
STOPPED_S = 1.0
MAX_OFF = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class _Taken:
    """A frame of the driver, and what its stamp is counted from."""

    frame: Any
    stamp_ms: float
    clock: Any
    came_ms: float


class RealSense:
    """A camera, a recording or a drawn stand-in, given as a device of pyrealsense2."""

    has_depth, waits = True, False

    def __init__(self, name: str, device: Any) -> None:
        rs = _module(name)
        self.name, self._rs = name, rs
        sensors = device.query_sensors()
        colour, depth = (
            _choose(name, sensors, word, stream, formats)
            for word, stream, formats in (
                ("colour", rs.stream.color, (rs.format.rgb8, rs.format.bgr8)),
                ("depth", rs.stream.depth, (rs.format.z16,)),
            )
        )
        self._is_bgr = colour[1].format() == rs.format.bgr8
        self._read_calibration(colour[1], depth[1])
        period_ms = 1000 / (min(colour[1].fps(), depth[1].fps()) or RATE_HZ)
        self._pairing = Pairing(_apart_ms, PAIR_SHARE * period_ms)
        self._heard_at: list[float | None] = [None, None]
        self._queue = rs.frame_queue(N_QUEUED, keep_frames=True)
        self._playback = device.as_playback() if device.is_playback() else None
        # A sensor of both, as the D405 has it, is opened once.
        self._sensors = [colour[0]] if _is_one(colour[0], depth[0]) else [colour[0], depth[0]]
        profiles = [[colour[1], depth[1]]] if len(self._sensors) == 1 else [[colour[1]], [depth[1]]]
        try:
            for sensor, chosen in zip(self._sensors, profiles, strict=True):
                sensor.open(chosen)
            for sensor in self._sensors:
                sensor.start(self._queue)
        except RuntimeError as error:
            self.close()
            found = f"cannot be started ({error})"
            raise CameraError(name, found, "close what else uses it, or plug it in again") from None

    def _read_calibration(self, colour: Any, depth: Any) -> None:
        intrinsics = colour.get_intrinsics()
        camera = _camera_of(intrinsics)
        extrinsics = depth.get_extrinsics_to(colour)
        T_colour_depth = np.eye(4)
        T_colour_depth[:3, :3] = np.reshape(extrinsics.rotation, (3, 3), order="F")
        T_colour_depth[:3, 3] = extrinsics.translation
        beside = DepthCamera(_camera_of(depth.get_intrinsics()), T_colour_depth)
        is_there = np.abs(T_colour_depth - np.eye(4)).max() < MAX_OFF
        is_one = is_there and beside.camera == camera
        self._depth_camera = None if is_one else beside
        self.camera = camera if is_one else with_window(Path(self.name), camera, beside)
        remarks = [f"colour {_size_of(colour)}, depth {_size_of(depth)}"]
        if self._depth_camera is not None:
            remarks.append("depth is registered to colour")
        if np.any(intrinsics.coeffs):
            remarks.append("the distortion of its lens is not straightened")
        self.remarks = tuple(remarks)

    def grab(self, timeout_s: float) -> tuple[_Taken, _Taken] | None:
        is_there, frame = self._queue.try_wait_for_frame(round(1000 * timeout_s))
        if not is_there:
            self._check_end()
            return None
        newest = None
        for single in frame.as_frameset() if frame.is_frameset() else [frame]:
            stream = DEPTH if single.profile.stream_type() == self._rs.stream.depth else COLOUR
            self._heard_at[stream] = time.monotonic()
            newest = self._pairing.add(stream, _taken(single)) or newest
        return newest

    def _check_end(self) -> None:
        playback = self._playback
        if playback is None:
            return
        if playback.current_status() != self._rs.playback_status.playing:
            raise EndedError(f"{self.name} is at its end")

    def frame(self, grabbed: tuple[_Taken, _Taken]) -> Frame:
        colour, depth = (taken.frame for taken in grabbed)
        pixels: npt.NDArray[np.uint8] = np.asanyarray(colour.get_data())
        rgb = np.ascontiguousarray(pixels[..., ::-1] if self._is_bgr else pixels).copy()
        units = float(depth.as_depth_frame().get_units())
        metres = DepthForm(units).to_metres(np.asanyarray(depth.get_data()))
        if self._depth_camera is not None:
            metres = self._depth_camera.registered(metres, self.camera)
        stamp_ns = round(grabbed[COLOUR].stamp_ms * 1e6)
        return Frame(frame_id(stamp_ns), rgb, metres, self.camera, stamp_ns=stamp_ns)

    def silence(self, now: float | None = None) -> str:
        now = time.monotonic() if now is None else now
        named = dict(zip(("colour", "depth"), self._heard_at, strict=True))
        never = [name for name, at in named.items() if at is None]
        stopped = [name for name, at in named.items() if at is not None and now - at > STOPPED_S]
        if never:
            return f"no {' and no '.join(never)} at all"
        if stopped:
            return f"{' and '.join(stopped)} {'have' if len(stopped) > 1 else 'has'} stopped"
        return "colour and depth come, but not of one moment"

    def close(self) -> None:
        for sensor in self._sensors:
            with suppress(RuntimeError):  # it was not started, or is gone
                sensor.stop()
            with suppress(RuntimeError):
                sensor.close()
        self._sensors = []


def open_realsense(which: str) -> RealSense:
    """Open a camera by its serial number, the first where none is given, or play a recording.

    Raises `CameraError` where there is none, or pyrealsense2 is not installed or cannot be loaded.
    """
    name = f"realsense:{which}" if which else "realsense"
    rs = _module(name)
    if Path(which).suffix.lower() in RECORDINGS:
        return RealSense(name, _playback(rs, name, which))
    devices = connected(rs)
    serials = [device.get_info(rs.camera_info.serial_number) for device in devices]
    for device, serial in zip(devices, serials, strict=True):
        if which in ("", serial):
            return RealSense(f"realsense:{serial}", device)
    looked = f"no RealSense camera{f' of serial number {which}' if which else ''} was found"
    others = f"; there are {', '.join(serials)}" if serials else " on USB or the network"
    raise CameraError(name, f"{looked}{others}", "plug it in (a port of USB 3), and see its rights")


def connected(rs: Any) -> Sequence[Any]:
    """Return the devices of all cameras that the driver finds."""
    return list(rs.context().query_devices())


def _playback(rs: Any, name: str, path: str) -> Any:
    if not Path(path).is_file():
        raise CameraError(name, "there is no such recording", "check the path")
    try:
        return rs.context().load_device(path)
    except RuntimeError as error:
        remedy = "as a recording (`curiosight info FILE`) it may still be read"
        raise CameraError(name, f"the driver cannot play it ({error})", remedy) from None


def _module(name: str) -> Any:
    remedy = "install that library; libusb is libusb-1.0-0 on Debian and Ubuntu"
    with importing(name, "pyrealsense2", "realsense", remedy):
        import pyrealsense2
    return pyrealsense2


def _choose(
    name: str, sensors: Iterable[Any], word: str, stream: Any, formats: Sequence[Any]
) -> tuple[Any, Any]:
    """Return the sensor and profile of a stream nearest to what is wanted."""
    offered = [
        (sensor, profile.as_video_stream_profile())
        for sensor in sensors
        for profile in sensor.get_stream_profiles()
        if profile.stream_type() == stream and profile.format() in formats
    ]
    if not offered:
        raise CameraError(name, f"has no stream of {word}", "take one with colour and depth")
    pixels = WANTED_SIZE[0] * WANTED_SIZE[1]

    def distance(one: tuple[Any, Any]) -> tuple[float, float, int]:
        profile = one[1]
        off = abs(profile.width() * profile.height() - pixels)
        return abs(profile.fps() - RATE_HZ), off, formats.index(profile.format())

    return min(offered, key=distance)


def _is_one(first: Any, second: Any) -> bool:
    return first is second or first == second


def _taken(frame: Any) -> _Taken:
    clock = frame.get_frame_timestamp_domain()
    return _Taken(frame, frame.get_timestamp(), clock, 1000 * time.monotonic())


def _apart_ms(one: _Taken, other: _Taken) -> float:
    """Return how far apart two frames were taken; came, where clocks differ."""
    if one.clock == other.clock:
        return abs(one.stamp_ms - other.stamp_ms)
    return abs(one.came_ms - other.came_ms)


def _camera_of(intrinsics: Any) -> Camera:
    return Camera(
        intrinsics.width,
        intrinsics.height,
        intrinsics.fx,
        intrinsics.fy,
        intrinsics.ppx,
        intrinsics.ppy,
    )


def _size_of(profile: Any) -> str:
    return f"{profile.width()}x{profile.height()} at {profile.fps()} Hz"
