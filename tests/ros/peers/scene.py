"""Frames that the fake cameras show: a drive through a drawn room, drawn once."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

# Axes right, down, forward of a camera in those forward, left, up of a body (REP 103).
R_BODY_CAMERA = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])


def draw(path: Path, n_frames: int = 40) -> None:
    from curiosight.rooms import RoomSettings, RoomViews, draw_room

    views = RoomViews(draw_room(RoomSettings(seed=7, views=n_frames, path="drive")))
    frames = [views[index] for index in range(len(views))]
    camera = frames[0].camera
    assert camera is not None
    depths = [np.nan_to_num(1000 * frame.depth).astype(np.uint16) for frame in frames]
    np.savez(
        path,
        rgb=np.stack([frame.rgb for frame in frames]),
        depth=np.stack(depths),
        poses=np.stack([frame.T_world_camera for frame in frames]),
        K=[camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1],
    )


def quaternion(rotation: np.ndarray) -> list[float]:
    """Return x, y, z, w."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_quat().tolist()


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
