"""From messages to frames: colour at once, and what belongs to it once it has come."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from curiosight.datasets.bags.camera_info import to_camera
from curiosight.datasets.bags.images import to_depth, to_rgb
from curiosight.datasets.bags.transforms import clean, stamp_of
from curiosight.datasets.cameras.registration import register_depth
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import MILLIMETRES, DepthForm
from curiosight.datasets.topics.by_stamp import ByStamp
from curiosight.datasets.topics.tf_buffer import TfBuffer
from curiosight.frame import Camera, Depth, Frame, Pose

NS = 1_000_000_000
MAX_OFF_PX = 0.5
# Colour images whose distance to depth is looked at.
N_COMPARED = 10


@dataclass(frozen=True, slots=True)
class Joining:
    """How what comes apart is put together.

    world: the frame that poses are in. max_gap_s: between the stamps of colour and its depth.
    wait_s: for depth and tf that a frame is taught with. hold_s: so long the last transform
    counts for later stamps. depth_form: the unit of depth. is_rectified, is_depth_rectified: the
    images are, so P of their CameraInfo holds.
    """

    world: str = "map"
    max_gap_s: float = 0.02
    wait_s: float = 0.2
    hold_s: float = 0.1
    depth_form: DepthForm = MILLIMETRES
    is_rectified: bool = False
    is_depth_rectified: bool = False


class TopicFrames:
    """Make frames of a colour topic, a depth topic, their CameraInfo, and tf.

    One thread adds messages; others make frames. Why frames could not be taught with is counted
    in `lacks`, of `n_settled` in all.
    """

    def __init__(self, tf: TfBuffer, joining: Joining) -> None:
        self.tf, self.joining = tf, joining
        self.depths = ByStamp[Any]()
        self.info: Any | None = None
        self.depth_info: Any | None = None
        self.colour_frame = ""
        self.depth_frame = ""
        self.last_colour_ns: int | None = None
        self.lacks: Counter[str] = Counter()
        self.n_settled = 0
        self._colours_ns: deque[int] = deque(maxlen=N_COMPARED)

    def apart_s(self) -> float | None:
        """Return how far the stamps of the last colour and depth images are apart, at the best.

        None where neither, or only one of them, has come.
        """
        gaps = [
            abs(found[0] - stamp) / NS
            for stamp in list(self._colours_ns)
            if (found := self.depths.nearest(stamp)) is not None
        ]
        return min(gaps, default=None)

    def add_depth(self, message: Any) -> None:
        self.depth_frame = clean(message.header.frame_id)
        self.depths.add(stamp_of(message.header), message)

    def mapped(self, message: Any) -> Frame:
        """Return the frame of a colour message, without depth, and where the camera is about now.

        Raises `UnreadableFile`.
        """
        rgb = to_rgb(message, "the colour image")
        stamp_ns = stamp_of(message.header)
        self.colour_frame, self.last_colour_ns = clean(message.header.frame_id), stamp_ns
        self._colours_ns.append(stamp_ns)
        # The last that is known, if need be: a map is not kept waiting for tf.
        pose = self.tf.pose(self.joining.world, self.colour_frame, stamp_ns, hold_ns=NS // 2)
        name = f"{stamp_ns // NS}.{stamp_ns % NS:09d}"
        return Frame(name, rgb, None, None, pose, stamp_ns)

    def settled(self, frame: Frame) -> Frame:
        """Return a frame of `mapped` with its depth and its own pose; it may wait for them.

        Where there is no depth for it, or no camera, it has a `problem`.
        """
        assert frame.stamp_ns is not None
        joining, stamp_ns = self.joining, frame.stamp_ns
        self.n_settled += 1
        found = self.depths.await_nearest(stamp_ns, round(joining.max_gap_s * NS), joining.wait_s)
        pose = self._pose_at(stamp_ns)
        try:
            if found is None:
                raise UnreadableFile(f"no depth within {1000 * joining.max_gap_s:.0f} ms")
            camera = self._camera(frame)
            depth = self._registered(found[1], camera, stamp_ns)
        except UnreadableFile as error:
            self.lacks[str(error)] += 1
            return replace(frame, T_world_camera=pose, problem=str(error))
        return replace(frame, depth=depth, camera=camera, T_world_camera=pose)

    def _pose_at(self, stamp_ns: int) -> Pose | None:
        hold_ns = round(self.joining.hold_s * NS)
        return self.tf.pose(self.joining.world, self.colour_frame, stamp_ns, hold_ns=hold_ns)

    def _camera(self, frame: Frame) -> Camera:
        if self.info is None:
            raise UnreadableFile("no CameraInfo of colour has come")
        height, width = frame.rgb.shape[:2]
        rectified = self.joining.is_rectified
        camera = to_camera(self.info, (width, height), is_rectified=rectified)
        if camera is None or (camera.width, camera.height) != (width, height):
            raise UnreadableFile(f"CameraInfo is of no camera of {width}x{height} pixels")
        return camera

    def _registered(self, message: Any, camera: Camera, stamp_ns: int) -> Depth:
        """Return depth in the colour camera: as it is where it is registered, else by its own."""
        depth = self.joining.depth_form.to_metres(to_depth(message, "the depth image"))
        size = depth.shape[1], depth.shape[0]
        of_depth = clean(message.header.frame_id)
        rectified = self.joining.is_depth_rectified
        own = self.depth_info and to_camera(self.depth_info, size, is_rectified=rectified)
        if of_depth == self.colour_frame:
            T_colour_depth: Pose | None = np.eye(4)
            if own is None:  # registered, if smaller
                own = to_camera(self.info, size, is_rectified=self.joining.is_rectified)
        else:
            T_colour_depth = self.tf.pose(self.colour_frame, of_depth, stamp_ns, hold_ns=NS)
        if T_colour_depth is None:
            raise UnreadableFile(
                f"depth is of {of_depth}, colour of {self.colour_frame}, and tf does not join them"
            )
        if own is None:
            raise UnreadableFile(f"depth is of {of_depth}, and no CameraInfo of it has come")
        if _is_same(own, camera) and np.abs(T_colour_depth - np.eye(4)).max() < 1e-6:
            return depth
        return register_depth(depth, own, camera, T_colour_depth)


def _is_same(one: Camera, other: Camera) -> bool:
    if (one.width, one.height) != (other.width, other.height):
        return False
    names = ("fx", "fy", "cx", "cy")
    return all(abs(getattr(one, name) - getattr(other, name)) < MAX_OFF_PX for name in names)
