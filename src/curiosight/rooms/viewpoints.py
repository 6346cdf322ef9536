"""Where the camera looks from."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.free_space import FreeSpace, Polygon

# A robot's mast sways, and its floor is not quite level.
_SWAY_M, _SWAY_DEG = 0.01, 0.5
_MIN_WALL_DISTANCE = 1.6


def camera_pose(
    x: float, y: float, heading_deg: float, *, height: float, tilt_deg: float, roll_deg: float = 0.0
) -> Pose:
    """Return T_room_camera of a camera `height` metres above a place.

    heading: counter-clockwise from the room's x axis. tilt: downwards. roll: clockwise.
    """
    heading, tilt, roll = np.radians((heading_deg, tilt_deg, roll_deg))
    forward = np.array(
        [np.cos(heading) * np.cos(tilt), np.sin(heading) * np.cos(tilt), -np.sin(tilt)]
    )
    level = np.array([np.sin(heading), -np.cos(heading), 0.0])
    upright = np.cross(forward, level)
    pose = np.eye(4)
    pose[:3, 0] = np.cos(roll) * level + np.sin(roll) * upright
    pose[:3, 1] = np.cos(roll) * upright - np.sin(roll) * level
    pose[:3, 2] = forward
    pose[:3, 3] = x, y, height
    return pose


def draw_poses(
    n: int,
    free_space: FreeSpace,
    outline: Polygon,
    rng: np.random.Generator,
    *,
    height: float,
    tilt_deg: float,
    roll_deg: float = 0.0,
) -> list[Pose]:
    """Return poses where a robot can stand, with some room before the camera."""
    poses: list[Pose] = []
    while len(poses) < n:
        place = free_space.draw_places(1, rng)[0]
        heading = float(rng.uniform(0, 360))
        sway = rng.normal(0, 1, 3) * (_SWAY_M, _SWAY_DEG, _SWAY_DEG)
        if distance_to_wall(outline, place, heading) < _MIN_WALL_DISTANCE:
            continue
        poses.append(
            camera_pose(
                float(place[0]),
                float(place[1]),
                heading,
                height=height + float(sway[0]),
                tilt_deg=tilt_deg + float(sway[1]),
                roll_deg=roll_deg + float(sway[2]),
            )
        )
    return poses


def distance_to_wall(outline: Polygon, place: npt.NDArray[np.float64], heading_deg: float) -> float:
    """Return the metres from a place inside an outline to the first wall straight ahead."""
    ahead = np.array([np.cos(np.radians(heading_deg)), np.sin(np.radians(heading_deg))])
    starts = np.asarray(outline, np.float64)
    walls = np.roll(starts, -1, axis=0) - starts
    to_start = starts - place
    across = ahead[0] * walls[:, 1] - ahead[1] * walls[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        metres = (to_start[:, 0] * walls[:, 1] - to_start[:, 1] * walls[:, 0]) / across
        along = (to_start[:, 0] * ahead[1] - to_start[:, 1] * ahead[0]) / across
    is_hit = (metres > 0) & (along >= 0) & (along <= 1)
    return float(metres[is_hit].min()) if is_hit.any() else float("inf")
