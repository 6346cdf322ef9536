"""The frames that a survey looks at: small, and from one place or several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame

Array = npt.NDArray[Any]
# Nearer than this to the middle of all (metres) no pose is an outlier.
MIN_OUTLIER = 20.0
# Nor nearer than so many times the median distance to it.
OUTLIER_FACTOR = 10.0

# A map is made of places that are not farther apart than this along any axis, metres.
MAX_EXTENT = 20.0


def shrunk(frame: Frame, *, n_columns: int = 320) -> Frame:
    """Return every so many rows and columns of a frame, at least every second one.

    A survey that keeps dozens of frames needs no more of them.
    """
    camera = frame.camera
    if camera is None or frame.depth is None:
        return frame
    stride = max(2, camera.width // n_columns)
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
    rgb = np.zeros((*depth.shape, 3), np.uint8)
    return replace(frame, rgb=rgb, depth=depth, camera=small)


def _window(camera: Camera, stride: int) -> tuple[int, int, int, int] | None:
    """Return the depth window in every so many rows and columns; None where nothing is left."""
    if camera.depth_window is None:
        return None
    u_min, v_min, u_max, v_max = (-(-edge // stride) for edge in camera.depth_window)
    return (u_min, v_min, u_max, v_max) if u_min < u_max and v_min < v_max else None


def without_outliers(frames: Sequence[Frame]) -> list[Frame]:
    """Return the frames but those whose pose is far from where all others are."""
    posed = [frame.T_world_camera for frame in frames if frame.T_world_camera is not None]
    if not posed:
        return list(frames)
    centre = np.median([pose[:3, 3] for pose in posed], axis=0)
    away = [_distance(frame, centre) for frame in frames]
    known = [metres for metres in away if metres is not None]
    limit = max(MIN_OUTLIER, OUTLIER_FACTOR * float(np.median(known)))
    return [
        frame
        for frame, metres in zip(frames, away, strict=True)
        if metres is None or metres <= limit
    ]


def _distance(frame: Frame, centre: Array) -> float | None:
    pose = frame.T_world_camera
    return None if pose is None else float(np.linalg.norm(pose[:3, 3] - centre))


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
