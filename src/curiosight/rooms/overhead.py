"""Where an arm holds a camera over the tables of a room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.free_space import Place
from curiosight.rooms.plan import FloorPlan
from curiosight.rooms.room import Room
from curiosight.rooms.viewpoints import camera_pose

Box = npt.NDArray[np.float64]  # (2, 3) metres: lowest and highest corner

HEIGHTS, TILTS_DEG = (0.5, 1.2), (60.0, 90.0)
# What is smaller is looked past rather than at.
MIN_TABLE_AREA = 0.2
# Of the camera from anything, walls among it.
CLEARANCE = 0.12
# An arm at a table reaches this far beside it: 1.2 m up at 60 degrees.
REACH = 0.75
_N_TRIES = 1000


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A top that nothing is built over: its pose, and x_min, y_min, x_max, y_max on it."""

    T_room_top: Pose
    area: tuple[float, float, float, float]

    @property
    def square_metres(self) -> float:
        x_min, y_min, x_max, y_max = self.area
        return (x_max - x_min) * (y_max - y_min)

    def distance(self, place: Place) -> float:
        """Return the metres from (x, y) in the room to the top, seen from above; 0 = over it."""
        x, y = (np.asarray(place) - self.T_room_top[:2, 3]) @ self.T_room_top[:2, :2]
        x_min, y_min, x_max, y_max = self.area
        return float(np.hypot(max(x_min - x, 0, x - x_max), max(y_min - y, 0, y - y_max)))


class OverTables:
    """The places that an arm over the tables of a room can bring a camera to.

    Raises ValueError where the room has no table.
    """

    def __init__(self, room: Room) -> None:
        self._plan: FloorPlan = room.plan
        self.tables = tables_of(room)
        if not self.tables:
            raise ValueError(
                f"over: expected a room with a table of {MIN_TABLE_AREA} m2, got {room.settings}"
            )
        self._boxes = np.array(
            [
                (part.mesh.vertices.min(0) - CLEARANCE, part.mesh.vertices.max(0) + CLEARANCE)
                for part in room.scene.parts
            ]
        )

    def contains(self, place: Place) -> bool:
        """Tell whether the camera can be brought over (x, y)."""
        is_inside = bool(self._plan.contains(np.asarray(place)))
        return is_inside and any(table.distance(place) <= REACH for table in self.tables)

    def check(self, place: Place) -> None:
        """Raise ValueError for a place that the arm does not reach."""
        if not self.contains(place):
            raise ValueError(
                f"viewpoint: expected a place over a table or at most {REACH} m beside it, "
                f"got ({place[0]:.2f}, {place[1]:.2f})"
            )

    def way(self, start: Place, goal: Place) -> float:
        """Return the metres between two places: nothing stands in an arm's way."""
        return float(np.linalg.norm(np.subtract(goal, start)))

    def ways(self, start: Place, goals: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the (n,) metres to (n, 2) places."""
        return np.asarray(np.linalg.norm(goals - start, axis=1))

    def draw_places(self, n: int, rng: np.random.Generator) -> npt.NDArray[np.float64]:
        """Return (n, 2) places on tables, evenly distributed."""
        return np.array([self._draw_target(rng)[:2] for _ in range(n)]).reshape(-1, 2)

    def draw_poses(
        self,
        n: int,
        rng: np.random.Generator,
        *,
        height: float | None,
        tilt_deg: float | None,
        roll_deg: float = 0.0,
    ) -> list[Pose]:
        """Return poses that look down at a place on a table, wherever the camera fits.

        height: metres over the table. tilt_deg: downwards. None = each its own.
        """
        poses: list[Pose] = []
        for _ in range(_N_TRIES * n):
            if len(poses) == n:
                return poses
            target = self._draw_target(rng)
            draws = (rng.uniform(*HEIGHTS), rng.uniform(*TILTS_DEG), rng.uniform(0, 360))
            pose = looking_at(
                target,
                float(draws[2]),
                height=float(draws[0]) if height is None else height,
                tilt_deg=float(draws[1]) if tilt_deg is None else tilt_deg,
                roll_deg=roll_deg,
            )
            if self._is_clear(pose[:3, 3]):
                poses.append(pose)
        raise ValueError(f"over: expected space over the tables, got none at height={height}")

    def target(self, place: Place) -> npt.NDArray[np.float64]:
        """Return the point (3,) of a table that lies at (x, y); raises ValueError beside tables."""
        for table in self.tables:
            if table.distance(place) == 0:
                return np.array([*place, table.T_room_top[2, 3]])
        found = f"({place[0]:.2f}, {place[1]:.2f})"
        raise ValueError(f"viewpoint: expected a place on a table to look at, got {found}")

    def _draw_target(self, rng: np.random.Generator) -> npt.NDArray[np.float64]:
        """Return a point (3,) on a table; larger ones are looked at more often."""
        areas = np.array([table.square_metres for table in self.tables])
        table = self.tables[int(rng.choice(len(areas), p=areas / areas.sum()))]
        x_min, y_min, x_max, y_max = table.area
        x, y = rng.uniform((x_min, y_min), (x_max, y_max))
        return np.asarray((table.T_room_top @ (x, y, 0.0, 1.0))[:3])

    def _is_clear(self, place: npt.NDArray[np.float64]) -> bool:
        """Tell whether a camera at (x, y, z) is in the room, and in nothing that is in it."""
        is_in = (self._boxes[:, 0] < place) & (place < self._boxes[:, 1])
        return bool(self._plan.contains(place[:2])) and not is_in.all(1).any()


def looking_at(
    target: npt.NDArray[np.float64],
    heading_deg: float,
    *,
    height: float,
    tilt_deg: float,
    roll_deg: float = 0.0,
) -> Pose:
    """Return T_room_camera of a camera `height` metres above a point, which is in its middle."""
    beside = height / np.tan(np.radians(tilt_deg))
    heading = np.radians(heading_deg)
    return camera_pose(
        float(target[0] - beside * np.cos(heading)),
        float(target[1] - beside * np.sin(heading)),
        heading_deg,
        height=float(target[2]) + height,
        tilt_deg=tilt_deg,
        roll_deg=roll_deg,
    )


def tables_of(room: Room) -> tuple[Table, ...]:
    """Return the tops that end their furniture: not those below wall cupboards."""
    tables = [
        Table(T_room_top, area)
        for placed in room.furniture
        for top, (T_room_top, area) in zip(placed.furniture.tops, placed.tops, strict=True)
        if top.height > placed.furniture.size[2] - 0.05
    ]
    return tuple(table for table in tables if table.square_metres >= MIN_TABLE_AREA)
