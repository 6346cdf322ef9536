"""Where views have looked: whether a place is seen free, or something is there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.voxels import Voxels, centres_of
from curiosight.frame import Camera, Depth, Pose

# Every so many rows and columns of a 640x480 image are kept.
STEP = 8
# Metres, and 1/m with the square of the distance, by which a reading must differ to be behind.
GAP, NOISE = 0.05, 0.01


class Seen(NamedTuple):
    """Shares of a surface: seen through, so that it is not there now; and seen where it was."""

    free: float
    there: float


class Glimpses:
    """Coarse depth images of a visit, with the poses that they were taken from."""

    def __init__(self) -> None:
        self._views: list[tuple[npt.NDArray[np.float16], Camera, Pose, int]] = []

    def add(self, depth: Depth, camera: Camera, T_world_camera: Pose) -> None:
        """Keep a view. depth: (H, W) float32 metres, NaN = no reading."""
        step = max(1, round(STEP * camera.width / 640))
        coarse = depth[::step, ::step].astype(np.float16)
        T_camera_world = np.linalg.inv(T_world_camera).astype(np.float64)
        self._views.append((coarse, camera, T_camera_world, step))

    def look_for(self, voxels: Voxels) -> Seen:
        """Return of which shares of a surface views saw that it is free, or that it is there.

        What lies before it, or at the border, tells nothing.
        """
        points = centres_of(voxels)
        n_free, n_there = np.zeros((2, len(points)), np.int64)
        for coarse, camera, T_camera_world, step in self._views:
            places = points @ T_camera_world[:3, :3].T + T_camera_world[:3, 3]
            z = places[:, 2]
            is_before = z > 0.2
            if not is_before.any():
                continue
            z = np.where(is_before, z, 1.0)
            u = np.rint((places[:, 0] / z * camera.fx + camera.cx) / step).astype(np.int64)
            v = np.rint((places[:, 1] / z * camera.fy + camera.cy) / step).astype(np.int64)
            height, width = coarse.shape
            where = np.flatnonzero(is_before & (u >= 0) & (u < width) & (v >= 0) & (v < height))
            if not len(where):
                continue
            behind = coarse[v[where], u[where]].astype(np.float64) - z[where]
            gap = GAP + NOISE * z[where] ** 2
            n_free[where] += behind > gap  # NaN compares false
            n_there[where] += np.abs(behind) <= gap
        if not len(points):
            return Seen(0.0, 0.0)
        is_free = n_free > n_there
        is_there = (n_there > 0) & ~is_free
        return Seen(float(is_free.mean()), float(is_there.mean()))
