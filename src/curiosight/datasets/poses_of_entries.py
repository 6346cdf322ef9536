"""Give the frames of a recording their poses, or bring those they have to ours."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.datasets.entries import Entry
from curiosight.datasets.pose_files import find_poses
from curiosight.datasets.reading import axes_of
from curiosight.frame import Pose

Y_UP = axes_of("right,up,forward")
MIRRORED = "fy is negative, the y axis points up: poses are mirrored at the plane y = 0"


def with_found_poses(folder: Path, entries: Sequence[Entry], remarks: list[str]) -> list[Entry]:
    """Return frames with the poses that a folder holds for them, in whatever files, and remark."""
    stamps = [entry.stamp_ns for entry in entries]
    found = find_poses(folder, [entry.rgb.stem for entry in entries], stamps)
    if found is None:
        return list(entries)
    remarks.append(found.remark)
    return [
        replace(entry, T_world_camera=pose)
        for entry, pose in zip(entries, found.poses, strict=True)
    ]


def with_y_down(entries: Iterable[Entry], remarks: list[str]) -> tuple[Entry, ...]:
    """Return frames with poses of cameras whose y axis points down, and remark on it."""
    remarks.append(MIRRORED)
    return with_changed_poses(entries, mirrored)


def with_changed_poses(
    entries: Iterable[Entry], change: Callable[[Pose], Pose]
) -> tuple[Entry, ...]:
    """Return frames with their poses changed; those without one stay so."""
    return tuple(
        entry
        if entry.T_world_camera is None
        else replace(entry, T_world_camera=change(entry.T_world_camera))
        for entry in entries
    )


def mirrored(pose: Pose) -> Pose:
    """Return the pose of a camera with y down for one with y up, both with z forward.

    Such a camera has left-handed axes, and what it sees a world mirrored to ours. The camera's
    axes are turned to y down and the world's with them, so that both are right-handed; depth of
    any two frames agrees as before.
    """
    return turned(pose, Y_UP)


def turned(pose: Pose, axes: npt.NDArray[np.float64]) -> Pose:
    """Return a pose whose camera has axes right, down, forward.

    axes: see `axes_of`. Where they make a left hand, the world's second axis is turned round.
    """
    other = pose.copy()
    other[:3, :3] = pose[:3, :3] @ axes
    if np.linalg.det(axes) < 0:
        other[1] *= -1
    return other


def inverted(pose: Pose) -> Pose:
    """Return camera to world of world to camera."""
    other: Pose = np.linalg.inv(pose).astype(np.float64)
    return other


def moved_out(pose: Pose, factor: float) -> Pose:
    """Return a pose whose position is in another unit."""
    other = pose.copy()
    other[:3, 3] *= factor
    return other
