"""Where the rooms of a home lie: on both sides of a corridor, a doorway each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.free_space import Polygon
from curiosight.rooms.mesh import standing
from curiosight.rooms.plan import FloorPlan, Wall
from curiosight.rooms.shell import DOORWAY, Opening, draw_windows

# Metres: of the corridor, of the walls between it and the rooms, and between rooms.
CORRIDOR_WIDTHS = (1.7, 2.1)
DOOR_WALL, PARTY_WALL = 0.2, 0.2
# Metres by which the corridor's picture reaches into a doorway: there both pictures are whole.
OVERLAP = 0.01
WIDTHS, DEPTHS, HEIGHTS = (4.8, 7.4), (4.1, 5.8), (2.4, 2.8)
_TOUCHING = 1e-6
L_SHARE, SMALLEST_L = 0.3, 5.8


@dataclass(frozen=True, slots=True, eq=False)
class Lot:
    """A room's place in the home.

    plan: of the room, its front wall on its own x axis. openings: of its walls, the doorway
    first. T_world_room: from the room's frame to the home's.
    """

    plan: FloorPlan
    openings: tuple[Opening, ...]
    T_world_room: Pose

    @property
    def outline(self) -> Polygon:
        """Its (K, 2) corners in the home."""
        return in_world(self.T_world_room, self.plan.outline)

    @property
    def door(self) -> Opening:
        """The doorway to the corridor."""
        return self.openings[0]

    @property
    def door_area(self) -> Polygon:
        """The (4, 2) corners of the floor inside the doorway, in the home."""
        x_min, y_min, x_max, y_max = self.door.front(-DOOR_WALL)
        corners = np.array([(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)])
        return in_world(self.T_world_room, corners)

    def contains(self, place: npt.ArrayLike) -> bool:
        """Tell whether (x, y) of the home is in the room or its doorway."""
        x, y = (np.asarray(place) - self.T_world_room[:2, 3]) @ self.T_world_room[:2, :2]
        left, low, right, high = self.door.front(-DOOR_WALL)
        in_doorway = left <= x <= right and low - _TOUCHING <= y <= high + _TOUCHING
        return in_doorway or bool(self.plan.contains(np.array([x, y])))

    def before_door(self, metres: float) -> npt.NDArray[np.float64]:
        """Return the place so far inside the room before its doorway, (2,) in the home."""
        wall = self.door.wall.T_room_wall
        place = wall[:2, 3] + self.door.middle * wall[:2, 0] - metres * wall[:2, 1]
        placed: npt.NDArray[np.float64] = in_world(self.T_world_room, place[None])[0]
        return placed


@dataclass(frozen=True, slots=True, eq=False)
class HomePlan:
    """A home seen from above: the lots of its rooms, and its corridor in the home's own frame.

    corridor_openings: the doorway of each room, in order; then windows.
    """

    lots: tuple[Lot, ...]
    corridor: FloorPlan
    corridor_openings: tuple[Opening, ...]


def in_world(T_world_room: Pose, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return (N, 2) places of a room in the home."""
    moved = np.asarray(points) @ T_world_room[:2, :2].T + T_world_room[:2, 3]
    return np.asarray(moved, np.float64)


def draw_home_plan(n_rooms: int, rng: np.random.Generator) -> HomePlan:
    """Draw the floor plan of a home; the corridor's axis is the world's x axis."""
    corridor_width = float(np.round(rng.uniform(*CORRIDOR_WIDTHS), 2))
    ends = [0.0, 0.0]  # of the rows to the left and to the right of the corridor
    rows: list[int] = []
    starts: list[float] = []
    plans = [_draw_outline(rng) for _ in range(n_rooms)]
    for plan in plans:
        row = int(np.argmin(ends))
        rows.append(row)
        starts.append(ends[row])
        ends[row] += plan.bounds[2] + PARTY_WALL
    length = max(ends) - PARTY_WALL
    lots = [
        _draw_lot(plan, row, start, corridor_width, is_at_end, rng)
        for plan, row, start, is_at_end in zip(plans, rows, starts, _are_at_ends(rows), strict=True)
    ]
    half = corridor_width / 2
    outline = np.array([(0, -half), (length, -half), (length, half), (0, half)])
    corridor = FloorPlan(outline, float(np.round(rng.uniform(*HEIGHTS), 2)))
    doorways = [_across(lot, corridor.walls) for lot in lots]
    windows = draw_windows(corridor, corridor.walls[int(rng.choice([1, 3]))], rng)
    return HomePlan(tuple(lots), corridor, (*doorways, *windows))


def _draw_outline(rng: np.random.Generator) -> FloorPlan:
    """Draw a room whose front wall is whole: a rectangle, or an L."""
    x, y = np.round((rng.uniform(*WIDTHS), rng.uniform(*DEPTHS)), 2)
    height = float(np.round(rng.uniform(*HEIGHTS), 2))
    if rng.random() >= L_SHARE or x < SMALLEST_L:
        return FloorPlan(np.array([(0, 0), (x, 0), (x, y), (0, y)]), height)
    cut_x, cut_y = np.round((x * rng.uniform(0.3, 0.42), y * rng.uniform(0.3, 0.42)), 2)
    if rng.random() < 0.5:
        corners = [(0, 0), (x, 0), (x, y - cut_y), (x - cut_x, y - cut_y), (x - cut_x, y), (0, y)]
    else:
        corners = [(0, 0), (x, 0), (x, y), (cut_x, y), (cut_x, y - cut_y), (0, y - cut_y)]
    return FloorPlan(np.array(corners), height)


def _are_at_ends(rows: Sequence[int]) -> list[tuple[bool, bool]]:
    """Tell of each room whether it is the first and whether it is the last of its row."""
    places = {row: [k for k, other in enumerate(rows) if other == row] for row in (0, 1)}
    return [(k == places[row][0], k == places[row][-1]) for k, row in enumerate(rows)]


def _draw_lot(
    plan: FloorPlan,
    row: int,
    start: float,
    corridor_width: float,
    is_at_end: tuple[bool, bool],
    rng: np.random.Generator,
) -> Lot:
    """Put a room into its row, and draw its doorway and its windows, which look outside."""
    away = corridor_width / 2 + DOOR_WALL
    width = plan.bounds[2]
    pose = standing(start, away) if row == 0 else standing(start + width, -away, 0.0, np.pi)
    front = plan.walls[0]
    door_width, height = float(rng.uniform(0.9, 1.0)), float(rng.uniform(2.0, 2.1))
    left = float(rng.uniform(0.3, 0.8))
    if rng.random() < 0.5:
        left = front.length - left - door_width
    door = Opening(DOORWAY, front, left, left + door_width, 0.0, height, DOOR_WALL)
    at_low, at_high = is_at_end if row == 0 else is_at_end[::-1]
    outer = [
        wall
        for wall in plan.walls[1:]
        if wall.length > 1.9 and _is_outer(wall, width, at_low, at_high)
    ]
    n_lit = int(rng.integers(1, min(2, len(outer)) + 1))
    lit = [outer[number] for number in rng.permutation(len(outer))[:n_lit]]
    windows = [window for wall in lit for window in draw_windows(plan, wall, rng)]
    return Lot(plan, (door, *windows), pose)


def _is_outer(wall: Wall, width: float, at_low: bool, at_high: bool) -> bool:
    """Tell whether there is no other room behind a wall; the notch of an L is outside too."""
    x = wall.ends[:, 0]
    is_low, is_high = bool((x < 1e-6).all()), bool((x > width - 1e-6).all())
    return not (is_low and not at_low) and not (is_high and not at_high)


def _across(lot: Lot, walls: Sequence[Wall]) -> Opening:
    """Return a room's doorway as an opening of the corridor's wall."""
    middle = lot.before_door(-DOOR_WALL)
    wall = walls[2] if middle[1] > 0 else walls[0]
    at = float((middle - wall.T_room_wall[:2, 3]) @ wall.T_room_wall[:2, 0])
    half = lot.door.width / 2
    return Opening(DOORWAY, wall, at - half, at + half, 0.0, lot.door.top, OVERLAP)
