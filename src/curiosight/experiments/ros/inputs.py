"""What the node listens to, and what it sees of it."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from curiosight.datasets.bags.bag_camera import RECTIFIED
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.topics.frames import Joining, TopicFrames
from curiosight.datasets.topics.tf_buffer import TfBuffer
from curiosight.experiments.ros.ears import LATCHED, SENSOR, Ear, Ears
from curiosight.experiments.ros.packages import Ros
from curiosight.robot.ros.goals import FloorMap, Place
from curiosight.robot.ros.missing import Quality, Seen

COMPRESSED = re.compile(r"/compressed(Depth)?$")
DEPTH_INFO = "CameraInfo of depth"
# By so many frames it is judged what they lack: single messages get lost.
N_JUDGED = 8


def beside(image_topic: str) -> str:
    """Return where the CameraInfo of an image topic is.

    >>> beside("/camera/color/image_raw/compressed")
    '/camera/color/camera_info'
    """
    return COMPRESSED.sub("", image_topic).rpartition("/")[0] + "/camera_info"


class Inputs:
    """Subscriptions, made by `open` and given up by `close`.

    values: of the parameters. on_colour: is given each colour message, in the executor's thread.
    """

    def __init__(
        self, ros: Ros, node: Any, values: dict[str, Any], on_colour: Callable[[Any], None]
    ) -> None:
        self._ros, self._node, self._values, self._on_colour = ros, node, values, on_colour
        self.tf = TfBuffer()
        self.frames = TopicFrames(self.tf, self._joining())
        self.floor: FloorMap | None = None
        self._ears = Ears(ros, node)
        self._told: tuple[int, dict[str, int]] = (0, {})
        self._lacking: dict[str, int] = {}

    @property
    def has_depth(self) -> bool:
        return bool(self._values["depth_topic"])

    def _joining(self) -> Joining:
        values = self._values
        return Joining(
            world=values["world_frame"],
            max_gap_s=values["max_stamp_gap"],
            wait_s=values["max_wait"],
            depth_form=DepthForm(values["depth_unit"]),
            is_rectified=bool(RECTIFIED.search(values["color_topic"])),
            is_depth_rectified=bool(RECTIFIED.search(values["depth_topic"])),
        )

    def open(self) -> None:
        values, frames, ros = self._values, self.frames, self._ros
        listen = self._ears.listen
        asked = Quality(values["reliability"], "volatile")
        colour, depth = values["color_topic"], values["depth_topic"]
        listen(colour, "colour", self._image_type(colour), asked, self._on_colour)
        info = values["color_info_topic"] or beside(colour)
        if self.has_depth:
            depth_info = values["depth_info_topic"] or beside(depth)
            listen(depth, "depth", self._image_type(depth), asked, frames.add_depth)
            kind = ros.sensor_msgs_msg.CameraInfo
            take = partial(setattr, frames, "info")
            listen(info, "CameraInfo of colour", kind, SENSOR, take)
            if depth_info != info:
                take = partial(setattr, frames, "depth_info")
                listen(depth_info, DEPTH_INFO, kind, SENSOR, take)
        tf = ros.tf2_msgs_msg.TFMessage
        moving = Quality("best_effort", "volatile")
        take = partial(self.tf.take, is_static=False)
        listen("/tf", "transforms", tf, moving, take, depth=100)
        take = partial(self.tf.take, is_static=True)
        listen("/tf_static", "static transforms", tf, LATCHED, take, depth=100)
        grid = ros.nav_msgs_msg.OccupancyGrid
        listen(values["map_topic"], "map", grid, LATCHED, self._take_floor, depth=1)

    def close(self) -> None:
        self._ears.close()

    def _image_type(self, topic: str) -> Any:
        messages = self._ros.sensor_msgs_msg
        return messages.CompressedImage if COMPRESSED.search(topic) else messages.Image

    def _take_floor(self, message: Any) -> None:
        info = message.info
        cells = np.asarray(message.data, np.int8)
        if info.resolution > 0 and cells.size == info.height * info.width > 0:
            origin, shape = place_of(info.origin), (info.height, info.width)
            self.floor = FloorMap(cells.reshape(shape), float(info.resolution), origin)

    def base_pose(self) -> Any:
        """Return T_world_base as far as it is known now; None = it is not."""
        values = self._values
        link = self.tf.parents.get(values["base_frame"].removeprefix("/"))
        now_ns = self.frames.last_colour_ns
        if link is not None and link.rows:
            now_ns = link.rows[-1][0]
        if now_ns is None:
            return None
        return self.tf.pose(values["world_frame"], values["base_frame"], now_ns, hold_ns=10**9)

    def camera_on_base(self) -> Any:
        """Return T_base_camera as it is now; None = not known."""
        stamp = self.frames.last_colour_ns
        if stamp is None:
            return None
        camera, base = self.frames.colour_frame, self._values["base_frame"]
        return self.tf.pose(base, camera, stamp, hold_ns=10**9)

    def seen(self, refused: dict[str, str]) -> Seen:
        """Return what is seen of the graph now; refused: of our own topics."""
        topics = [self._ears.seen(ear) for ear in self._ears.all if self._is_needed(ear)]
        lost = {one.kind for one in topics if not one.kinds}
        return Seen(
            topics,
            self.frames.apart_s(),
            self._values["max_stamp_gap"],
            self._tf_missing(),
            refused,
            self._lacks(),
            self._alike(lost) if lost else {},
        )

    def _is_needed(self, ear: Ear) -> bool:
        if ear.what == DEPTH_INFO:  # not where depth is registered
            return self.frames.depth_frame != self.frames.colour_frame
        return ear.what not in _WHERE

    def _alike(self, wanted: set[str]) -> dict[str, list[str]]:
        """Return which topics of others there are, by type."""
        own = self._node.get_fully_qualified_name() + "/"
        alike: dict[str, list[str]] = {}
        for name, kinds in self._node.get_topic_names_and_types():
            for kind in wanted.intersection(kinds):
                if not name.startswith(own) and self._node.count_publishers(name):
                    alike.setdefault(kind, []).append(name)
        return alike

    def _tf_missing(self) -> str | None:
        stamp = self.frames.last_colour_ns
        if stamp is None:
            return None
        world, camera = self._values["world_frame"], self.frames.colour_frame
        # The last image's own transform may be on its way.
        if self.tf.pose(world, camera, stamp, hold_ns=500_000_000) is not None:
            return None
        why = self.tf.why_not(world, camera, stamp)
        if why is None:
            return None
        of_tf = [self._ears.seen(ear) for ear in self._ears.all if ear.what in _WHERE[:2]]
        return "; ".join([why, *(one.misfit for one in of_tf if one.misfit)])

    def _lacks(self) -> dict[str, int]:
        """Return what most of the last frames taught nothing for, and how many."""
        frames, (n_before, told) = self.frames, self._told
        n_frames = frames.n_settled - n_before
        if n_frames >= N_JUDGED:
            fresh = {why: n - told.get(why, 0) for why, n in frames.lacks.items()}
            self._lacking = {why: n for why, n in fresh.items() if n > 0 and 2 * n >= n_frames}
            self._told = frames.n_settled, dict(frames.lacks)
        return self._lacking


# Topics that are asked for only where poses are.
_WHERE = ("transforms", "static transforms", "map")


def place_of(pose: Any) -> Place:
    """Return where on the floor a Pose is."""
    turn = pose.orientation
    yaw = np.arctan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2))
    return Place(pose.position.x, pose.position.y, float(yaw))
