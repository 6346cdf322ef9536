"""How far the camera moves between viewpoints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose, Viewpoint

Floats = npt.NDArray[np.float64]

# A small robot indoors.
METRES_PER_SECOND = 0.5
DEGREES_PER_SECOND = 60.0


def travel(T_world_a: Pose, T_world_b: Pose) -> tuple[float, float]:
    """Return the straight distance (metres) and the turn (degrees) between two cameras."""
    metres = float(np.linalg.norm(T_world_b[:3, 3] - T_world_a[:3, 3]))
    R_a_b = T_world_a[:3, :3].T @ T_world_b[:3, :3]
    axis = (R_a_b[2, 1] - R_a_b[1, 2], R_a_b[0, 2] - R_a_b[2, 0], R_a_b[1, 0] - R_a_b[0, 1])
    # atan2 of sine and cosine: arccos alone is blind to turns below 1e-6 degrees.
    turn = np.arctan2(np.linalg.norm(axis), np.trace(R_a_b) - 1)
    return metres, float(np.degrees(turn))


@overload
def travel_seconds(metres: float, degrees: float) -> float: ...
@overload
def travel_seconds(metres: Floats, degrees: Floats) -> Floats: ...
def travel_seconds(metres: float | Floats, degrees: float | Floats) -> float | Floats:
    """Return how long a small robot takes: first the turn, then the way."""
    return metres / METRES_PER_SECOND + degrees / DEGREES_PER_SECOND


def straight_ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> tuple[Floats, Floats]:
    """Return the (n,) metres and degrees to viewpoints, straight; 0 where a pose is not known."""
    metres, degrees = np.zeros((2, len(goals)))
    poses = [goal.T_world_camera for goal in goals]
    known = [number for number, pose in enumerate(poses) if pose is not None]
    if start.T_world_camera is None or not known:
        return metres, degrees
    # As `travel`, of all at once: a strategy asks for hundreds.
    T_world_b = np.stack([pose for pose in poses if pose is not None])
    metres[known] = np.linalg.norm(T_world_b[:, :3, 3] - start.T_world_camera[:3, 3], axis=1)
    R_a_b = start.T_world_camera[:3, :3].T @ T_world_b[:, :3, :3]
    axes = R_a_b[:, [2, 0, 1], [1, 2, 0]] - R_a_b[:, [1, 2, 0], [2, 0, 1]]
    turns = np.arctan2(np.linalg.norm(axes, axis=1), np.trace(R_a_b, axis1=1, axis2=2) - 1)
    degrees[known] = np.degrees(turns)
    return metres, degrees


class Odometer:
    """Sum the travel from viewpoint to viewpoint; those without a pose are passed over."""

    def __init__(self) -> None:
        self.metres = 0.0
        self.degrees = 0.0
        self._T_world_last: Pose | None = None

    def add(self, T_world_camera: Pose | None) -> None:
        """Move to the next viewpoint."""
        if T_world_camera is None:
            return
        if self._T_world_last is not None:
            metres, degrees = travel(self._T_world_last, T_world_camera)
            self.metres += metres
            self.degrees += degrees
        self._T_world_last = T_world_camera
