"""Where a camera stands and what it sees from there, as cells of a map seen from above."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Pose
from curiosight.learner.glance import Glance
from curiosight.learner.looks import Look

Array = npt.NDArray[Any]
Cells = npt.NDArray[np.int32]

CELL = 0.5  # metres: less than a door is wide
# What lies farther along the optical axis is not looked at well, metres.
MAX_SIGHT = 4.0
# How far a camera without depth is taken to see.
BLIND_SIGHT = 2.0
# Readings along each side of the image, and points along each ray.
_N_ACROSS, _N_DOWN, _N_ALONG = 32, 24, 12
_WIDE = 2**20


def cell_of(T_world_camera: Pose, axes: Array) -> tuple[int, int]:
    """Return the cell that a camera stands in.

    axes: (2, 3), see `ground_axes`.
    """
    x, y = np.floor(axes @ T_world_camera[:3, 3] / CELL).astype(int)
    return int(x), int(y)


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """What tells the place of a view.

    look: of the image as a whole.
    T_world_camera: (4, 4); None = unknown. rays: (n, 3) from the camera to what it sees, in the
        world's frame, metres; without a pose none.
    up: (3,) unit vector in the world's frame; None = the frame does not tell.
    glance: by which it is told whether the place has changed; None = it is not.
    """

    look: Look
    T_world_camera: Pose | None = None
    rays: Array | None = None
    up: Array | None = None
    glance: Glance | None = None

    @classmethod
    def of(
        cls, frame: Frame, look: Look, up: Array | None = None, glance: Glance | None = None
    ) -> Self:
        """Return what a frame tells."""
        pose = frame.T_world_camera
        if pose is None:
            return cls(look)
        rays = (_rays(frame) @ pose[:3, :3].T).astype(np.float32)
        return cls(look, pose, rays, up, glance)

    def cells(self, axes: Array) -> Cells:
        """Return the (n, 2) cells that a posed view looks through, up to what it sees: all free.

        axes: (2, 3), see `ground_axes`.
        """
        assert self.T_world_camera is not None
        assert self.rays is not None
        along = np.linspace(0, 1, _N_ALONG)[:, None, None]
        points = (axes @ self.T_world_camera[:3, 3] + along * (self.rays @ axes.T)) / CELL
        x, y = np.floor(points).reshape(-1, 2).astype(np.int64).T
        # One number a cell, for speed.
        _, first = np.unique(x * _WIDE + y, return_index=True)
        cells: Cells = np.stack([x[first], y[first]], axis=1).astype(np.int32)
        return cells


def _rays(frame: Frame) -> Array:
    """Return (n, 3) from the camera to what it sees, in the camera's frame, metres."""
    if frame.depth is None or frame.camera is None:
        return np.array([[0.0, 0.0, BLIND_SIGHT]])
    height, width = frame.depth.shape
    step = max(1, height // _N_DOWN), max(1, width // _N_ACROSS)
    depth = frame.depth[:: step[0], :: step[1]].astype(float)
    v, u = np.nonzero(depth > 0)
    z = np.minimum(depth[v, u], MAX_SIGHT)
    camera = frame.camera
    x = (u * step[1] - camera.cx) / camera.fx * z
    y = (v * step[0] - camera.cy) / camera.fy * z
    rays: Array = np.stack([x, y, z], axis=1)
    return rays
