"""What RealSense's own recordings say beside usual messages: cameras, and times of frames."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.bags.bag import Bag, Topic
from curiosight.frame import Pose, is_rigid
from curiosight.frame.rotations import matrix_of

STREAM = re.compile(r"^(/device_\d+/sensor_\d+/[^/]+_\d+)/")
# ROS 1 until 2025, databases since.
KINDS = ("geometry_msgs/msg/Transform", "std_msgs/msg/String")
CLOCK, TIME = re.compile(r"timestamp_domain=([^;]+)"), re.compile(r";timestamp=(\d+(?:\.\d+)?)")
Times = npt.NDArray[np.int64]
PARTS = re.compile(r"rotation=([^;]+);translation=([^;]+)")


def stream_extrinsics(bag: Bag, colour: Topic, depth: Topic) -> tuple[Pose, str] | None:
    """Return T_colour_depth of RealSense's streams, and the topic that tells; None = none does.

    Each stream says how to get to it from the axes of a reference, by a number.
    """
    told = {}
    for name, image in (("colour", colour), ("depth", depth)):
        stream = STREAM.match(image.name)
        if stream is None:
            return None
        told[name] = _of_stream(bag, stream[1])
    for reference, (T_colour_reference, topic) in told["colour"].items():
        if reference in told["depth"]:
            T_depth_reference, _ = told["depth"][reference]
            return T_colour_reference @ np.linalg.inv(T_depth_reference), topic
    return None


def frame_times(bag: Bag, colour: Topic, depth: Topic) -> tuple[Times, Times] | None:
    """Return when the images of both streams were taken, nanoseconds, one an image.

    Stamps in its databases say when a frame arrived: colour comes later than the depth of its
    moment, and may be nearer to the next. None where not all images of both have a time of their
    own, by one clock.
    """
    told = [_times_of(bag, image) for image in (colour, depth)]
    if told[0] is None or told[1] is None or told[0][1] != told[1][1]:
        return None
    return told[0][0], told[1][0]


def _times_of(bag: Bag, image: Topic) -> tuple[Times, str] | None:
    """Return the times of a stream's images, and by which clock."""
    stream = STREAM.match(image.name)
    about = None if stream is None else bag.topics.get(f"{stream[1]}/image/metadata")
    if about is None or about.type != KINDS[1]:
        return None
    clocks, at = set(), {}
    for number, message in about.readable():
        clock, time = CLOCK.search(message.data), TIME.search(message.data)
        if clock is not None and time is not None:
            clocks.add(clock[1])
            at[int(about.logged_ns[number])] = round(float(time[1]) * 1e6)
    logged = image.logged_ns.tolist()
    if len(clocks) != 1 or not all(moment in at for moment in logged):
        return None
    return np.array([at[moment] for moment in logged], np.int64), clocks.pop()


def _of_stream(bag: Bag, stream: str) -> dict[int, tuple[Pose, str]]:
    """Return T_stream_reference by the number of the reference."""
    pattern = re.compile(rf"^{re.escape(stream)}/tf/(?:ref_)?(\d+)$")
    found = {}
    for topic in bag.topics.values():
        match = pattern.match(topic.name)
        if match is None or topic.type not in KINDS or (message := topic.first()) is None:
            continue
        pose = _text_pose(message.data) if topic.type == KINDS[1] else _message_pose(message)
        if pose is not None and is_rigid(pose):
            found[int(match[1])] = pose, topic.name
    return found


def _message_pose(message: Any) -> Pose | None:
    at, turn = message.translation, message.rotation
    quaternion = [turn.x, turn.y, turn.z, turn.w]
    if not 0.9 < np.linalg.norm(quaternion) < 1.1:
        return None
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(quaternion)
    pose[:3, 3] = at.x, at.y, at.z
    return pose


def _text_pose(text: str) -> Pose | None:
    """Read "rotation=9 numbers, column after column;translation=3"."""
    parts = PARTS.search(text)
    if parts is None:
        return None
    pose = np.eye(4)
    try:
        turn, at = ([float(word) for word in part.split(",")] for part in parts.groups())
        pose[:3, :3], pose[:3, 3] = np.reshape(turn, (3, 3), order="F"), at
    except ValueError:
        return None
    return pose
