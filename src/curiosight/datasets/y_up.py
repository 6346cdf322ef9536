"""Bring poses of cameras whose y axis points up to ours, whose y axis points down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from curiosight.datasets.recording import Entry
from curiosight.frame import Pose

MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])
REMARK = "fy is negative, the y axis points up: poses are mirrored at the plane y = 0"


def mirrored_pose(T_world_camera: Pose) -> Pose:
    """Return the pose of a camera with y down for one with y up, both with z forward.

    Such a camera has left-handed axes, and what it sees a world mirrored to ours. The camera's
    axes are turned to y down and the world's with them, so that both are right-handed; depth of
    any two frames agrees as before.
    """
    pose: Pose = MIRROR @ T_world_camera @ MIRROR
    return pose


def with_y_down(entries: Sequence[Entry], remarks: list[str]) -> list[Entry]:
    """Return the entries with poses of cameras whose y axis points down, and remark on it."""
    remarks.append(REMARK)
    return [
        entry
        if entry.T_world_camera is None
        else replace(entry, T_world_camera=mirrored_pose(entry.T_world_camera))
        for entry in entries
    ]
