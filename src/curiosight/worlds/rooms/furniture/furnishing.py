"""Where furniture stands: along walls and free in the room, so that a robot can go everywhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.worlds.rooms.furniture import kitchen, soft, storage, tables
from curiosight.worlds.rooms.furniture.kind import Furniture, Placed
from curiosight.worlds.rooms.mesh import standing
from curiosight.worlds.rooms.plan import FloorPlan, Rectangle
from curiosight.worlds.rooms.shell import Shell

Draw = Callable[[np.random.Generator], Furniture]

# Metres: between a wall and what stands at it, or what stands under a window; before its front;
# around what stands free; width of a way.
AT_WALL, AT_WINDOW, IN_FRONT, AROUND = 0.03, 0.18, 0.75, 0.8
ROBOT_RADIUS, WAY_RADIUS, CELL = 0.35, 0.40, 0.05
LARGEST_SHARE = 0.33
N_TRIES = 60


def furnish(plan: FloorPlan, shell: Shell, rng: np.random.Generator) -> tuple[Placed, ...]:
    """Put a believable set of furniture in a room; what finds no place is left out.

    Doors stay clear, windows too of what is tall, and the floor that a robot of 35 cm radius
    can stand on is one piece.
    """
    furnishing = _Furnishing(plan, shell)
    for draw in _draw_set(rng):
        furnishing.place(draw(rng), rng)
    return tuple(furnishing.placed)


def _draw_set(rng: np.random.Generator) -> list[Draw]:
    """Draw which pieces a room has, the most wanted ones first."""
    wanted: list[Draw] = [kitchen.kitchen_counter if rng.random() < 0.6 else storage.sideboard]
    wanted += [tables.table, soft.sofa if rng.random() < 0.65 else soft.bed, storage.shelf]
    if wanted[2] is soft.sofa and rng.random() < 0.7:
        wanted.append(tables.coffee_table)
    extras: list[tuple[Draw, float]] = [
        (tables.desk, 0.6),
        (storage.sideboard, 0.5),
        (tables.table, 0.3),
        (storage.tv_board, 0.4),
        (storage.shelf, 0.4),
        (storage.wardrobe, 0.35),
        (soft.armchair, 0.35),
    ]
    return wanted + [draw for draw, chance in extras if rng.random() < chance]


class _Furnishing:
    """What stands in a room so far."""

    def __init__(self, plan: FloorPlan, shell: Shell) -> None:
        self._plan = plan
        self._doors = shell.kept_free
        self._windows = [opening for opening in shell.openings if opening.kind == "window"]
        self.placed: list[Placed] = []

    def place(self, furniture: Furniture, rng: np.random.Generator) -> None:
        """Put a piece at the first place tried that suits; leave it out where none does."""
        for _ in range(N_TRIES):
            pose = self._at_wall(furniture, rng) if furniture.against_wall else self._free(rng)
            if pose is not None and self._suits(Placed(furniture, pose)):
                self.placed.append(Placed(furniture, pose))
                return

    def _at_wall(self, furniture: Furniture, rng: np.random.Generator) -> Pose | None:
        """Draw a place at a wall, often in a corner; None where it does not fit there."""
        width, depth, height = furniture.size
        wall = self._plan.walls[rng.integers(len(self._plan.walls))]
        spare = wall.length - width - 2 * AT_WALL
        x = AT_WALL + width / 2 + spare * float(rng.choice([0.0, 1.0, *rng.random(2)]))
        behind = [
            window
            for window in self._windows
            if window.wall is wall and abs(x - window.middle) < (width + window.width) / 2 + 0.3
        ]
        is_before_glass = any(window.bottom < height for window in behind)
        if spare < 0 or is_before_glass:
            return None
        return wall.T_room_wall @ standing(x, -depth / 2 - (AT_WINDOW if behind else AT_WALL))

    def _free(self, rng: np.random.Generator) -> Pose:
        x_min, y_min, x_max, y_max = self._plan.bounds
        turn = float(rng.choice([0.0, np.pi / 2])) + rng.choice([0.0, 1.0]) * rng.normal(0, 0.06)
        return standing(rng.uniform(x_min, x_max), rng.uniform(y_min, y_max), 0.0, turn)

    def _suits(self, candidate: Placed) -> bool:
        """Tell whether a piece stands inside, clear of all others and of doors and ways."""
        box, stands_free = _box(candidate), not candidate.furniture.against_wall
        inside = np.stack(
            np.meshgrid(np.linspace(box[0], box[2], 9), np.linspace(box[1], box[3], 9)), -1
        )
        to_wall = AROUND if stands_free else AT_WALL / 2
        if (
            not self._plan.contains(inside).all()
            or self._plan.wall_distance(inside).min() < to_wall
        ):
            return False
        if any(_meet(box, door) for door in self._doors):
            return False
        for other in self.placed:
            is_way = stands_free or not other.furniture.against_wall
            if _meet(_grown(box, AROUND if is_way else AT_WALL / 2), _box(other)):
                return False
            if _meet(_front(candidate), _box(other)) or _meet(box, _front(other)):
                return False
        return self._leaves_ways([*map(_box, self.placed), box])

    def _leaves_ways(self, boxes: Sequence[Rectangle]) -> bool:
        """Tell whether the floor is neither too full nor cut in pieces."""
        covered = sum((b[2] - b[0]) * (b[3] - b[1]) for b in boxes)
        if covered > LARGEST_SHARE * self._plan.area:
            return False
        clearance = floor_clearance(self._plan, boxes)
        return all(n_pieces(clearance > radius) == 1 for radius in (ROBOT_RADIUS, WAY_RADIUS))


def floor_clearance(plan: FloorPlan, boxes: Sequence[Rectangle]) -> npt.NDArray[np.float32]:
    """Return metres to the nearest wall or box, on a grid of 5 cm cells; 0 inside of them."""
    x_min, y_min, x_max, y_max = plan.bounds
    x = np.arange(x_min - CELL / 2, x_max + CELL, CELL)
    y = np.arange(y_min - CELL / 2, y_max + CELL, CELL)
    is_open = plan.contains(np.stack(np.meshgrid(x, y), -1))
    for left, low, right, high in boxes:
        is_open &= ~((x >= left) & (x <= right) & ((y >= low) & (y <= high))[:, None])
    is_open[[0, -1]] = False
    is_open[:, [0, -1]] = False
    distance = cv2.distanceTransform(is_open.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(distance * CELL, np.float32)


def n_pieces(is_free: npt.NDArray[np.bool_]) -> int:
    """Return into how many pieces free cells fall; neighbours at a corner hang together."""
    return int(cv2.connectedComponents(is_free.astype(np.uint8), connectivity=8)[0]) - 1


def _box(placed: Placed) -> Rectangle:
    """Return the rectangle around a piece, seen from above."""
    return _around(placed.footprint)


def _front(placed: Placed) -> Rectangle:
    """Return the floor before a piece, where one stands to use it."""
    width, depth, _ = placed.furniture.size
    y = -depth / 2
    corners = np.array(
        [(x, y - reach, 0, 1) for x in (-width / 2, width / 2) for reach in (0, IN_FRONT)]
    )
    return _around((corners @ placed.T_room_furniture.T)[:, :2])


def _around(points: npt.NDArray[np.float64]) -> Rectangle:
    (x_min, y_min), (x_max, y_max) = points.min(0), points.max(0)
    return float(x_min), float(y_min), float(x_max), float(y_max)


def _grown(box: Rectangle, by: float) -> Rectangle:
    return box[0] - by, box[1] - by, box[2] + by, box[3] + by


def _meet(one: Rectangle, other: Rectangle) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
