"""A camera's ways through a home: from room to room, or round one of its tables."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from curiosight.frame import Pose
from curiosight.rooms.free_space import FreeSpace, Place
from curiosight.rooms.home.floor_plan import HomePlan
from curiosight.rooms.home.home import Home
from curiosight.rooms.tours import drive, find_orbit

# Places drawn in a room, of which the one nearest to its middle is where the robot stops.
_N_TRIES = 30


def drive_around(
    plan: HomePlan, floor: FreeSpace, rng: np.random.Generator, n: int | None
) -> list[tuple[float, float, float]]:
    """Return x, y and heading (degrees) of n pictures on a robot's way through all doors.

    Once it has been in all rooms it begins anew, in another order. n: None = it ends there.
    """
    n_rooms = len(plan.lots)
    if n is not None:
        return list(islice(drive(floor, _stops(plan, floor, rng)), n))
    # The way from the last room to the first closes the round.
    return list(drive(floor, islice(_stops(plan, floor, rng), n_rooms + 1)))


def _stops(plan: HomePlan, floor: FreeSpace, rng: np.random.Generator) -> Iterator[Place]:
    """Yield a place in each room, the nearest first, again and again."""
    middles = np.array([lot.outline.mean(0) for lot in plan.lots])
    parts = [floor.within(lot.outline) for lot in plan.lots]
    here = int(rng.integers(len(middles)))
    while True:
        left = set(range(len(middles)))
        while left:
            here = min(left, key=lambda k: float(np.linalg.norm(middles[k] - middles[here])))
            left.remove(here)
            places = parts[here].draw_places(_N_TRIES, rng)
            yield places[np.argmin(np.linalg.norm(places - middles[here], axis=1))]


def draw_orbit(
    home: Home, n: int, rng: np.random.Generator, *, height: float, roll_deg: float
) -> list[Pose]:
    """Return n poses round the table of the home that has most space around it.

    Raises ValueError where no room has a table.
    """
    found = [(find_orbit(home.room(number), height), number) for number in range(home.n_rooms)]
    orbits = [(orbit, number) for orbit, number in found if orbit is not None]
    if not orbits:
        raise ValueError(f"path: expected a home with a table, got {home.settings}")
    orbit, number = max(orbits, key=lambda one: one[0].length)
    T_world_room = home.plan.lots[number].T_world_room
    return [T_world_room @ pose for pose in orbit.poses(n, rng, height=height, roll_deg=roll_deg)]
