"""What RealSense's own recordings say beside usual messages: where each stream's camera is."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from curiosight.datasets.bags.bag import Bag, Topic
from curiosight.frame import Pose, is_rigid

STREAM = re.compile(r"^(/device_\d+/sensor_\d+/[^/]+_\d+)/")
# ROS 1 until 2025, databases since.
KINDS = ("geometry_msgs/msg/Transform", "std_msgs/msg/String")
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
    pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
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
