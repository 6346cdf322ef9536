"""Where a robot may stand, by an occupancy grid, and the views from there."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose, Viewpoint
from curiosight.robot.ros.squares import Squares

Floats = npt.NDArray[np.float64]
# Cells of an occupancy grid up to this are free; -1 = unknown.
MOST_FREE = 25


@dataclass(frozen=True, slots=True)
class Place:
    """Where the robot stands: metres, and radians from the world's x axis to its y axis."""

    x: float
    y: float
    yaw: float

    def pose(self, z: float = 0.0) -> Pose:
        """Return T_world_base."""
        pose = np.eye(4)
        pose[:2, :2] = [[cos(self.yaw), -sin(self.yaw)], [sin(self.yaw), cos(self.yaw)]]
        pose[:3, 3] = self.x, self.y, z
        return pose

    @classmethod
    def of(cls, T_world_base: Pose) -> Place:
        x, y = float(T_world_base[0, 3]), float(T_world_base[1, 3])
        return cls(x, y, float(np.arctan2(T_world_base[1, 0], T_world_base[0, 0])))


@dataclass(frozen=True, slots=True, eq=False)
class FloorMap:
    """An occupancy grid. cells: (H, W) int8, -1 = unknown, 0 to 100; resolution: metres a cell.

    origin: where the corner of its first cell is, and how it is turned.
    """

    cells: npt.NDArray[np.int8]
    resolution: float
    origin: Place

    def reachable(self, here: tuple[float, float], clearance: float, spacing: float) -> Floats:
        """Return (n, 2) metres: places on free floor that joins the robot's, about `spacing` apart.

        clearance: from whatever is not free, metres.
        """
        is_free = (self.cells >= 0) & (self.cells <= MOST_FREE)
        padded = np.pad(is_free.astype(np.uint8), 1)
        away = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] * self.resolution
        is_clear = is_free & (away >= clearance)
        if not is_clear.any():
            return np.zeros((0, 2))
        v, u = np.nonzero(is_clear)
        centres = self._to_world(np.stack([u + 0.5, v + 0.5], axis=1) * self.resolution)
        nearest = int(np.argmin(((centres - here) ** 2).sum(axis=1)))
        _, parts = cv2.connectedComponents(is_clear.astype(np.uint8), connectivity=4)
        centres = centres[parts[v, u] == parts[v[nearest], u[nearest]]]
        return _thinned(centres, spacing)

    def _to_world(self, places: Floats) -> Floats:
        turned = places @ self.origin.pose()[:2, :2].T
        return np.asarray(turned + np.array([self.origin.x, self.origin.y]))


def _thinned(places: Floats, spacing: float) -> Floats:
    """Keep of each square of a lattice the place that is nearest to its middle."""
    cells = np.floor(places / spacing).astype(np.int64)
    off = ((places - (cells + 0.5) * spacing) ** 2).sum(axis=1)
    order = np.lexsort((off, cells[:, 1], cells[:, 0]))
    is_first = np.ones(len(order), np.bool_)
    is_first[1:] = (np.diff(cells[order], axis=0) != 0).any(axis=1)
    return places[order[is_first]]


def views_from(
    places: Floats, squares: Squares, T_base_camera: Pose, *, n_headings: int = 4, z: float = 0.0
) -> tuple[tuple[Viewpoint, ...], dict[int, Place]]:
    """Return views in all directions from places, and where the robot stands for each.

    T_base_camera: the camera on the robot. z: of the floor in the world, metres.
    """
    stands: dict[int, Place] = {}
    views: list[Viewpoint] = []
    for x, y in places.tolist():
        region = squares.at(x, y)
        for heading in range(n_headings):
            place = Place(x, y, -pi + 2 * pi * heading / n_headings)
            stands[len(views)] = place
            views.append(Viewpoint(len(views), region, place.pose(z) @ T_base_camera))
    return tuple(views), stands
