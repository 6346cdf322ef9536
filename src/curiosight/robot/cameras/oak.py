"""OAK cameras through depthai (3.x): depth is made, and registered to colour, on the camera."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.depth_files import MILLIMETRES, DepthForm
from curiosight.datasets.layouts.ros_bag import frame_id
from curiosight.frame import Camera, Depth, Frame, Rgb
from curiosight.robot.cameras.camera import CameraError, importing
from curiosight.robot.feed import RATE_HZ, EndedError

SIZE = (640, 400)
COLOUR, DEPTH = "colour", "depth"
# Of the time between two frames: what is farther apart is not of one moment.
PAIR_SHARE = 0.6
NAP_S = 0.005


class Oak:
    """What comes out of a pipeline: groups of `COLOUR` and `DEPTH`, or images of colour alone.

    queue: of the pipeline's output, which holds one. depth_form: what its depth is counted in.
    is_replay: it has an end.
    """

    waits = False

    def __init__(
        self,
        name: str,
        pipeline: Any,
        queue: Any,
        depth_form: DepthForm | None = MILLIMETRES,
        *,
        is_replay: bool = False,
    ) -> None:
        self.name, self.has_depth = name, depth_form is not None
        self._pipeline, self._queue, self._depth_form = pipeline, queue, depth_form
        self._is_replay = is_replay
        how = "depth is registered to colour by the camera"
        alone = "colour alone: it is mapped, and teaches nothing"
        self.remarks: tuple[str, ...] = (how if self.has_depth else alone,)

    def grab(self, timeout_s: float) -> Any | None:
        until = time.monotonic() + timeout_s
        while True:
            # Asked again and again: a wait that blocks would not end when the pipeline does.
            message = self._ask()
            if message is not None or time.monotonic() > until:
                return message
            time.sleep(NAP_S)

    def _ask(self) -> Any | None:
        try:
            message = self._queue.tryGet()
            if message is not None or self._pipeline.isRunning():
                return message
            found = "its pipeline has stopped"
        # What depthai raises of a camera that is unplugged is of several kinds.
        except Exception as error:
            found = f"was lost ({error})"
        if self._is_replay:
            raise EndedError(f"{self.name} is at its end")
        raise CameraError(self.name, found, "plug it in again, and start again")

    def frame(self, grabbed: Any) -> Frame:
        colour = grabbed[COLOUR] if self.has_depth else grabbed
        rgb: Rgb = np.ascontiguousarray(colour.getCvFrame()[..., ::-1])
        stamp_ns = round(colour.getTimestamp() / timedelta(microseconds=1)) * 1000
        if self._depth_form is None:
            return Frame(frame_id(stamp_ns), rgb, stamp_ns=stamp_ns)
        camera = self._camera_of(colour, rgb.shape)
        metres = self._metres(grabbed[DEPTH].getFrame(), rgb.shape)
        return Frame(frame_id(stamp_ns), rgb, metres, camera, stamp_ns=stamp_ns)

    def _camera_of(self, colour: Any, shape: tuple[int, ...]) -> Camera:
        """Return the intrinsics that the camera sends with every image."""
        (fx, _, cx), (_, fy, cy), _ = colour.getTransformation().getIntrinsicMatrix()
        try:
            return Camera(shape[1], shape[0], fx, fy, cx, cy)
        except ValueError as error:
            remedy = "calibrate it with Luxonis' tools"
            raise CameraError(self.name, f"sends no calibration ({error})", remedy) from None

    def _metres(self, raw: npt.NDArray[np.uint16], shape: tuple[int, ...]) -> Depth:
        assert self._depth_form is not None
        if raw.shape != shape[:2]:
            found = f"sends depth of {raw.shape[1]}x{raw.shape[0]} beside colour of "
            found += f"{shape[1]}x{shape[0]}"
            raise CameraError(self.name, found, "update depthai: they should be of one size")
        return self._depth_form.to_metres(raw)

    def silence(self) -> str:
        return "its pipeline runs, without an image"

    def close(self) -> None:
        with suppress(RuntimeError):  # what is lost cannot be stopped
            self._pipeline.stop()
            self._pipeline.wait()


def open_oak(which: str) -> Oak:
    """Open a camera by its id or address, the first where none is given, or replay a video.

    Raises `CameraError` where there is none, or depthai is not installed.
    """
    name = f"oak:{which}" if which else "oak"
    if Path(which).is_file():
        return _replay(name, which)
    dai = depthai(name)
    found = [info for info in dai.Device.getAllAvailableDevices() if _is_asked(info, which)]
    if not found:
        what = f"no OAK camera{f' {which}' if which else ''} was found on USB or the network"
        raise CameraError(name, what, "plug it in, and see the rights of USB (udev rules)")
    try:
        device = dai.Device(found[0])
        pipeline = dai.Pipeline(device)
        queue, form = _wire(dai, pipeline, has_stereo=bool(device.getAvailableStereoPairs()))
        pipeline.start()
    except RuntimeError as error:
        raise CameraError(name, f"cannot be started ({error})", "plug it in again") from None
    return Oak(name, pipeline, queue, form)


def _is_asked(info: Any, which: str) -> bool:
    return which in ("", info.deviceId, info.name)


def _wire(dai: Any, pipeline: Any, *, has_stereo: bool) -> tuple[Any, DepthForm | None]:
    """Make colour, and depth registered to it, of one moment; return their queue and the unit.

    has_stereo: it has eyes for depth; without, the unit is None.
    """
    camera = pipeline.create(dai.node.Camera).build()
    colour = camera.requestOutput(
        SIZE, dai.ImgFrame.Type.RGB888i, fps=RATE_HZ, enableUndistortion=True
    )
    if not has_stereo:
        return colour.createOutputQueue(maxSize=1, blocking=False), None
    depth = pipeline.create(dai.node.Depth)
    depth.setAlignTo(colour)
    queue = synced(dai, pipeline, colour, depth.depth)
    pipeline.build()
    return queue, DepthForm(_unit_m(dai, depth.getResolvedConfig()))


def synced(dai: Any, pipeline: Any, colour: Any, depth: Any) -> Any:
    """Bring two outputs together by their stamps; return the queue of the newest group."""
    sync = pipeline.create(dai.node.Sync)
    sync.setSyncThreshold(timedelta(seconds=PAIR_SHARE / RATE_HZ))
    sync.setRunOnHost(True)
    colour.link(sync.inputs[COLOUR])
    depth.link(sync.inputs[DEPTH])
    return sync.out.createOutputQueue(maxSize=1, blocking=False)


def _unit_m(dai: Any, config: Any) -> float:
    """Return metres per unit of depth, as the pipeline is set; millimetres where it says none."""
    unit_of: Callable[[], Any] | None = getattr(config, "getDepthUnit", None)
    units = dai.StereoDepthConfig.AlgorithmControl.DepthUnit
    metres = {units.METER: 1.0, units.CENTIMETER: 0.01, units.MILLIMETER: 0.001}
    return MILLIMETRES.scale if unit_of is None else metres.get(unit_of(), MILLIMETRES.scale)


def _replay(name: str, path: str) -> Oak:
    """Replay a video of colour through depthai, without a camera."""
    dai = depthai(name)
    pipeline = dai.Pipeline(False)
    video = pipeline.create(dai.node.ReplayVideo)
    video.setReplayVideoFile(path)
    video.setOutFrameType(dai.ImgFrame.Type.BGR888i)
    video.setLoop(False)
    queue = video.out.createOutputQueue(maxSize=1, blocking=False)
    try:
        pipeline.start()
    except RuntimeError as error:
        raise CameraError(name, f"cannot be replayed ({error})", "give an .mp4") from None
    return Oak(name, pipeline, queue, None, is_replay=True)


def depthai(name: str) -> Any:
    """Import depthai, silent about the USB of this machine."""
    os.environ.setdefault("DEPTHAI_LEVEL", "off")
    with importing(name, "depthai", "oak", "install that library"):
        import depthai as dai
    return dai
