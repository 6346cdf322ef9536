"""Look at a trajectory from above: where each camera stands and which way it looks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FromAbove:
    """A trajectory on the horizontal plane; NaN where a pose is unknown.

    positions: (n, 2) metres along the plane's two axes.
    headings: (n,) radians of the optical axis from the first of them to the second.
    """

    positions: Floats
    headings: Floats


def seen_from_above(poses: Sequence[Pose | None], up: npt.ArrayLike | None = None) -> FromAbove:
    """Project camera poses on the horizontal plane.

    up: (3,) world vector against gravity; None = the cameras' mean up axis (their -y), which
        is rough (23 degrees off for a hand-held camera that mostly looks down one way) but
        never far off, unlike an axis fitted to the path.
    """
    positions = np.full((len(poses), 2), np.nan)
    headings = np.full(len(poses), np.nan)
    posed = [index for index, pose in enumerate(poses) if pose is not None]
    if not posed:
        return FromAbove(positions, headings)
    T_world_camera = np.stack([pose for pose in poses if pose is not None])
    axes = horizontal_axes(-T_world_camera[:, :3, 1].mean(axis=0) if up is None else up)
    positions[posed] = T_world_camera[:, :3, 3] @ axes
    looks = T_world_camera[:, :3, 2] @ axes
    headings[posed] = np.arctan2(looks[:, 1], looks[:, 0])
    return FromAbove(positions, headings)


def horizontal_axes(up: npt.ArrayLike) -> Floats:
    """Return (3, 2) unit vectors: the world's x axis laid flat (y where x stands up), its left."""
    vector = np.asarray(up, dtype=np.float64)
    if vector.shape != (3,) or not np.linalg.norm(vector) > 1e-6:
        raise ValueError(f"up: expected a (3,) vector longer than 0, got {vector}")
    vector = vector / np.linalg.norm(vector)
    first = np.eye(3)[0 if abs(vector[0]) < 0.8 else 1]
    first = first - (first @ vector) * vector
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(vector, first)], axis=1)
