"""The upright box around a thing."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.frame.level import ground_axes

Array = npt.NDArray[Any]
# Of its surface, by which stray readings are left out at each end.
STRAY = 0.01


def upright_box(
    points: Array, up: Array, base: float | None = None
) -> tuple[Pose, tuple[float, float, float]]:
    """Return T_world_centre, (4, 4), and width, length and height in metres of the box.

    points: (n, 3) of the world, at least one. up: (3,) unit vector. base: metres along up that it
    stands at; None = as the points have it. Its axes are those of the box: z is up, y its longer
    side.
    """
    axes = -ground_axes(up)
    places = (points @ axes.T).astype(np.float32)
    heights = points @ up
    low, high = _ends(heights)
    if base is not None and base < high:
        low = base
    inner = _without_stray(places)
    (x, y), (width, length), degrees = cv2.minAreaRect(np.ascontiguousarray(inner))
    if width > length:
        width, length, degrees = length, width, degrees - 90.0
    angle = np.deg2rad(degrees)
    along = np.cos(angle) * axes[0] + np.sin(angle) * axes[1]
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = along, np.cross(up, along), up
    pose[:3, 3] = x * axes[0] + y * axes[1] + (low + high) / 2 * up
    return pose, (float(width), float(length), float(max(high - low, 0.0)))


def _ends(values: Array) -> tuple[float, float]:
    # Of few points none is stray.
    low, high = (
        np.quantile(values, STRAY, method="lower"),
        np.quantile(values, 1 - STRAY, method="higher"),
    )
    return float(low), float(high)


def _without_stray(places: Array) -> Array:
    """Return (n, 2) places without those beyond the ends along either axis."""
    low, high = np.transpose([_ends(along) for along in places.T])
    kept = places[((places >= low) & (places <= high)).all(axis=1)]
    return kept if len(kept) else places
