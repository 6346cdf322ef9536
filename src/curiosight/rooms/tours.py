"""Ways of a camera through rooms, as it records them: driven by a robot, or carried by hand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.drawn_views import RATE_HZ
from curiosight.rooms.free_space import FreeSpace, Place, Polygon
from curiosight.rooms.overhead import CLEARANCE, Table, tables_of
from curiosight.rooms.room import Room
from curiosight.rooms.settings import PathName
from curiosight.rooms.viewpoints import camera_pose

METRES_PER_SECOND, DEGREES_PER_SECOND = 0.5, 60.0
# Metres from the table's corners to who holds the camera.
ARM_LENGTHS = (0.9, 0.7, 0.5)
N_DIRECTIONS = 72
# A hand sways by so much, so fast.
SWAY_M, SWAY_DEG, SWAY_HZ = 0.012, 0.8, (0.3, 1.6)

Floats = npt.NDArray[np.float64]


def tested_path(path: PathName | None) -> PathName | None:
    """Return the path of test views: a few pictures of a drive would all show one place."""
    return None if path == "drive" else path


def drive(space: FreeSpace, stops: Iterable[Place]) -> Iterator[tuple[float, float, float]]:
    """Yield x, y and heading (degrees) of each picture on a robot's way from stop to stop.

    It turns on the spot, goes straight, and looks all around at each stop.
    """
    heading = 0.0
    for start, goal in pairwise(stops):
        for here, there in pairwise(space.route(start, goal)):
            ahead = there - here
            wanted = float(np.degrees(np.arctan2(ahead[1], ahead[0])))
            turn = (wanted - heading + 180) % 360 - 180
            yield from _turning(here, heading, turn)
            heading = wanted
            n_steps = int(np.ceil(np.linalg.norm(ahead) * RATE_HZ / METRES_PER_SECOND))
            for share in np.arange(1, n_steps + 1) / max(n_steps, 1):
                x, y = here + share * ahead
                yield float(x), float(y), heading
        yield from _turning(np.asarray(goal), heading, 360.0)


def _turning(
    place: npt.NDArray[np.floating], heading: float, turn: float
) -> Iterator[tuple[float, float, float]]:
    n_steps = int(np.ceil(abs(turn) * RATE_HZ / DEGREES_PER_SECOND))
    for share in np.arange(1, n_steps + 1) / max(n_steps, 1):
        yield float(place[0]), float(place[1]), float(heading + share * turn)


@dataclass(frozen=True, slots=True)
class Orbit:
    """A way around a table: its middle (3,), and the arc (radians) that is free at a radius."""

    centre: Floats
    radius: float
    first: float
    length: float

    def poses(
        self, n: int, rng: np.random.Generator, *, height: float, roll_deg: float = 0.0
    ) -> list[Pose]:
        """Return n poses that look at the table all along the arc, as a hand holds a camera."""
        seconds = np.arange(n) / RATE_HZ
        is_round = self.length >= 2 * np.pi
        shares = np.arange(n) / (n if is_round else max(n - 1, 1))
        angles = self.first + self.length * shares
        sway = [_sway(seconds, rng) for _ in range(6)]
        poses = []
        for k, angle in enumerate(angles):
            beside = self.radius * np.array([np.cos(angle), np.sin(angle)])
            shift = SWAY_M * np.array([sway[0][k], sway[1][k], sway[2][k]])
            x, y = self.centre[:2] + beside + shift[:2]
            z = height + shift[2]
            down = np.degrees(np.arctan2(z - self.centre[2], self.radius))
            pose = camera_pose(
                float(x),
                float(y),
                float(np.degrees(angle) + 180 + SWAY_DEG * sway[3][k]),
                height=float(z),
                tilt_deg=float(down + SWAY_DEG * sway[4][k]),
                roll_deg=roll_deg + float(SWAY_DEG * sway[5][k]),
            )
            poses.append(pose)
        return poses


def find_orbit(room: Room, height: float) -> Orbit | None:
    """Return the longest way around a table of a room; None where there is no table.

    height: of the camera over the floor, metres.
    """
    bounds = [part.mesh.bounds for part in room.scene.parts]
    low = np.array([low for low, _ in bounds]) - CLEARANCE
    high = np.array([high for _, high in bounds]) + CLEARANCE
    angles = np.arange(N_DIRECTIONS) * 2 * np.pi / N_DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)], 1)
    best: Orbit | None = None
    for table in tables_of(room):
        centre, half = _middle(table)
        for arm in ARM_LENGTHS:
            places = np.column_stack(
                [centre[:2] + (half + arm) * ways, np.full(N_DIRECTIONS, height)]
            )
            is_in = np.all((low < places[:, None]) & (places[:, None] < high), axis=2)
            is_free = room.plan.contains(places[:, :2]) & ~is_in.any(axis=1)
            is_free &= room.plan.wall_distance(places[:, :2]) > CLEARANCE
            start, n_free = longest_run(is_free)
            step = 2 * np.pi / N_DIRECTIONS
            length = 2 * np.pi if n_free == N_DIRECTIONS else max(n_free - 1, 0) * step
            if best is None or length > best.length:
                best = Orbit(centre, half + arm, float(angles[start]), length)
    return best


def longest_run(is_free: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return start and length of the longest run of True on a circle."""
    if is_free.all():
        return 0, len(is_free)
    # From a place that is not free, no run goes on around the end.
    first = int(np.argmin(is_free))
    edges = np.flatnonzero(np.diff(np.roll(is_free, -first).astype(np.int8), append=0))
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return 0, 0
    longest = int(np.argmax(ends - starts))
    length = int(ends[longest] - starts[longest])
    return int(starts[longest] + 1 + first) % len(is_free), length


class HandHeld:
    """Where one carries a camera: anywhere inside of the walls."""

    def __init__(self, contains_all: Iterable[Polygon]) -> None:
        self._outlines = [np.asarray(outline, np.float32) for outline in contains_all]

    def contains(self, place: Place) -> bool:
        """Tell whether (x, y) is inside of the walls."""
        return any(_is_inside(outline, place) for outline in self._outlines)

    def check(self, place: Place) -> None:
        """Raise ValueError for a place outside."""
        if not self.contains(place):
            x, y = place
            raise ValueError(f"viewpoint: expected a place inside, got ({x:.2f}, {y:.2f})")

    def way(self, start: Place, goal: Place) -> float:
        """Return the metres between two places."""
        return float(np.linalg.norm(np.subtract(goal, start)))

    def ways(self, start: Place, goals: Floats) -> Floats:
        """Return the (n,) metres to (n, 2) places."""
        return np.asarray(np.linalg.norm(goals - start, axis=1))


def _is_inside(outline: Polygon, place: Place) -> bool:
    """Tell whether a ray from a place crosses the outline an odd number of times."""
    x, y = np.asarray(outline, np.float64).T
    next_x, next_y = np.roll(x, -1), np.roll(y, -1)
    crosses = (y > place[1]) != (next_y > place[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x + (place[1] - y) / (next_y - y) * (next_x - x)
    return bool(np.count_nonzero(crosses & (at > place[0])) % 2)


def _middle(table: Table) -> tuple[Floats, float]:
    """Return the middle of a top (3,) and half its diagonal."""
    x_min, y_min, x_max, y_max = table.area
    centre = table.T_room_top @ ((x_min + x_max) / 2, (y_min + y_max) / 2, 0.0, 1.0)
    return np.asarray(centre[:3]), float(np.hypot(x_max - x_min, y_max - y_min)) / 2


def _sway(seconds: Floats, rng: np.random.Generator) -> Floats:
    """Return a slow swing about 0, of deviation about 1."""
    rates, phases = rng.uniform(*SWAY_HZ, 3), rng.uniform(0, 2 * np.pi, 3)
    waves = np.sin(2 * np.pi * rates * seconds[:, None] + phases)
    return np.asarray(waves.sum(1) * np.sqrt(2 / 3))
