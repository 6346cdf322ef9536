"""The poses of the colour camera, by tf, odometry, or whatever else of a bag tells them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from curiosight.datasets.bags.bag import Topic
from curiosight.datasets.bags.bag_camera import frame_of
from curiosight.datasets.bags.choice import Choice
from curiosight.datasets.bags.message_types import TF_MESSAGE
from curiosight.datasets.bags.transforms import Transforms, poses_told
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
    topic = choice.pose
    is_tf = topic is not None and topic.type == TF_MESSAGE
    if is_tf or not choice.is_pose_named:
        if transforms.is_located(frame):
            links = transforms.chain(frame)
            names = " and ".join(one.name for one in tf)
            return transforms.poses(frame, stamps_ns), [
                f"pose {names} ({links[-1].parent} → {frame})"
            ]
        if is_tf or topic is None:
            lost = f"tf does not say where {frame or 'the colour camera'} is: no poses"
            return [None] * len(stamps_ns), ["", lost] if tf else []
    assert topic is not None
    link, parent, child = poses_told(topic)
    T_child_camera, remarks = _camera_on(child, frame, transforms)
    poses = [None if pose is None else pose @ T_child_camera for pose in link.at(stamps_ns)]
    told = f"pose {topic.name} ({parent} → {child})" if child else f"pose {topic.name}"
    return poses, [told, *remarks]


def _camera_on(child: str, frame: str, transforms: Transforms) -> tuple[Pose, list[str]]:
    """Return the colour camera in the frame whose poses are told, and what was assumed."""
    if child and child == frame:
        return np.eye(4), []
    T_child_camera = transforms.between(child, frame) if child else None
    if T_child_camera is not None:
        return T_child_camera, []
    if child and "optical" not in child:
        return T_BODY_CAMERA, [f"no tf from {child} to the camera: it is taken to look ahead there"]
    return np.eye(4), ["its poses are taken for those of the colour camera, z forward"]
