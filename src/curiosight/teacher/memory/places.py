"""The frames that a survey looks at: small, and from one place or several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame
from curiosight.teacher.cloud.points import scale_of
from curiosight.teacher.things.union import join_linked, number_sets

Array = npt.NDArray[Any]
# Nearer than this to another (metres) no pose is an outlier, nor nearer than so many times what
# poses are from each other by the median.
MIN_GAP, GAP_FACTOR = 20.0, 10.0
# A map is made of places that are not farther apart than this along any axis, metres.
MAX_EXTENT = 20.0


def shrunk(frame: Frame, n_columns: int = 320) -> Frame:
    """Return every so many rows and columns of a frame, without its colours.

    n_columns: about as many are left of an image as wide as 640x480 ones, at least.
    """
    camera = frame.camera
    if camera is None or frame.depth is None:
        return frame
    # Sizes whose sides are rounded are no smaller.
    stride = max(1, int(scale_of(camera) * 640 / n_columns + 0.01))
    depth = frame.depth[::stride, ::stride].copy()
    small = Camera(
        depth.shape[1],
        depth.shape[0],
        camera.fx / stride,
        camera.fy / stride,
        camera.cx / stride,
        camera.cy / stride,
        _window(camera, stride),
    )
    rgb = np.broadcast_to(np.uint8(0), (*depth.shape, 3))
    return replace(frame, rgb=rgb, depth=depth, camera=small)


def _window(camera: Camera, stride: int) -> tuple[int, int, int, int] | None:
    """Return the depth window in every so many rows and columns; None where nothing is left."""
    if camera.depth_window is None:
        return None
    u_min, v_min, u_max, v_max = (-(-edge // stride) for edge in camera.depth_window)
    return (u_min, v_min, u_max, v_max) if u_min < u_max and v_min < v_max else None


def without_outliers(frames: Sequence[Frame]) -> list[Frame]:
    """Return the frames but those whose pose is far from where most others are.

    Over hundreds of metres the least tilt of what is taken for up moves the floor.
    """
    rows = [row for row, frame in enumerate(frames) if frame.T_world_camera is not None]
    if len(rows) < 3:
        return list(frames)
    positions = positions_of(frames)
    distances = np.linalg.norm(positions[:, None] - positions, axis=-1)
    np.fill_diagonal(distances, np.inf)
    gap = max(MIN_GAP, GAP_FACTOR * float(np.median(distances.min(axis=1))))
    parent = np.arange(len(positions))
    join_linked(distances < gap, parent)
    place = number_sets(parent)
    lost = np.array(rows)[place != np.argmax(np.bincount(place))]
    return [frame for row, frame in enumerate(frames) if row not in lost]


def positions_of(frames: Sequence[Frame]) -> Array:
    """(n, 3) metres: where the cameras of the frames with poses are in the world."""
    poses = [frame.T_world_camera for frame in frames if frame.T_world_camera is not None]
    return np.array([pose[:3, 3] for pose in poses]).reshape(-1, 3)


def neighbourhoods(positions: Array) -> list[npt.NDArray[np.intp]]:
    """Divide (n, 3) places in metres where they leave the widest gap, until none is wide.

    Return the rows of each part. A map of all would be as large as the way between them.
    """
    parts, waiting = [], [np.arange(len(positions))]
    while waiting:
        rows = waiting.pop()
        extent = np.ptp(positions[rows], axis=0) if len(rows) else np.zeros(3)
        if extent.max() <= MAX_EXTENT:
            parts.append(rows)
            continue
        axis = int(np.argmax(extent))
        ordered = rows[np.argsort(positions[rows, axis], kind="stable")]
        widest = 1 + int(np.argmax(np.diff(positions[ordered, axis])))
        waiting += [np.sort(ordered[widest:]), np.sort(ordered[:widest])]
    return parts
