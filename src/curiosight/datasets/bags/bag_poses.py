"""The poses of the colour camera, by tf, odometry, or whatever else of a bag tells them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from curiosight.datasets.bags.bag import Topic
from curiosight.datasets.bags.choice import Choice
from curiosight.datasets.bags.message_types import TF_MESSAGE
from curiosight.datasets.bags.transforms import Transforms, frame_of, poses_told
from curiosight.frame import Pose

# Axes forward, left, up of a body (REP 103) to right, down, forward of a camera.
T_BODY_CAMERA: Pose = np.array(
    [[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float64
)


def find_bag_poses(
    choice: Choice, tf: Sequence[Topic], transforms: Transforms, stamps_ns: Sequence[int]
) -> tuple[list[Pose | None], list[str]]:
    """Return camera to world at each stamp, and in words from where; then what to remark.

    tf goes before other topics unless one of these was named.
    """
    frame = frame_of(choice.colour)
    topic = None if choice.pose is None or choice.pose.type == TF_MESSAGE else choice.pose
    is_asked = topic is not None and (choice.is_pose_named or not transforms.is_fixed(frame))
    told: list[str] = []
    if is_asked and topic is not None:
        link, child = poses_told(topic)
        told = [f"{topic.name} ({link.parent} → {child})" if child else topic.name]
        is_joined = transforms.join(child, link, frame, instead=choice.is_pose_named)
        if not is_joined and (choice.is_pose_named or not transforms.is_located(frame)):
            T_child_camera, remarks = _camera_on(child, frame)
            poses = [None if pose is None else pose @ T_child_camera for pose in link.at(stamps_ns)]
            return poses, [f"pose {told[0]}", *remarks]
        told = told if is_joined else []
    if transforms.is_located(frame):
        told += [one.name for one in tf]
        root = transforms.chain(frame)[-1].parent
        return transforms.poses(frame, stamps_ns), [f"pose {', '.join(told)} ({root} → {frame})"]
    lost = f"tf does not say where {frame or 'the colour camera'} is: no poses"
    return [None] * len(stamps_ns), ["", lost] if tf else []


def _camera_on(child: str, frame: str) -> tuple[Pose, list[str]]:
    """Return the colour camera in the frame whose poses are told, and what was assumed."""
    if child and child == frame:
        return np.eye(4), []
    if child and "optical" not in child:
        return T_BODY_CAMERA, [f"no tf from {child} to the camera: it is taken to look ahead there"]
    return np.eye(4), ["its poses are taken for those of the colour camera, z forward"]
