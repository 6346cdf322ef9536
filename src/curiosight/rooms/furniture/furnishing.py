"""Where furniture stands: along walls and free in the room, so that a robot can go everywhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.furniture import kitchen, soft, storage, tables
from curiosight.rooms.furniture.kind import Furniture, Placed
from curiosight.rooms.mesh import standing
from curiosight.rooms.plan import FloorPlan, Rectangle
from curiosight.rooms.shell import Shell

Draw = Callable[[np.random.Generator], Furniture]
# A piece, and the chance that a room has it.
Wanted = tuple[Draw, float]

# Metres from a wall to what stands at it, or to what stands under a window; free to the sides
# of a window, before a piece's front, and around what stands free.
AT_WALL, AT_WINDOW, BESIDE, IN_FRONT, AROUND = 0.03, 0.18, 0.35, 0.75, 0.8
# Half the width of the narrowest way, which all of the floor hangs together by, and of a wide one;
# side of a cell of the map of them.
NARROW_RADIUS, WIDE_RADIUS, CELL = 0.35, 0.40, 0.05
# Share of the floor that is covered at most, and that wide ways reach at least.
LARGEST_SHARE, MAIN_SHARE = 0.33, 0.97
FEWEST_TOPS, N_TRIES = 3, 120


def furnish(
    plan: FloorPlan,
    shell: Shell,
    rng: np.random.Generator,
    wanted: Sequence[Wanted] | None = None,
) -> tuple[Placed, ...]:
    """Put a believable set of furniture in a room; what finds no place is left out.

    Doors stay clear, windows too of what is tall, and the floor that a robot of 35 cm radius
    can stand on is one piece. wanted: None = a bit of everything, with enough tops for things.
    """
    furnishing = _Furnishing(plan, shell)
    if wanted is not None:
        for draw, chance in wanted:
            if rng.random() < chance:
                furnishing.place(draw(rng), rng)
        return tuple(furnishing.placed)
    for draw in _draw_set(rng):
        furnishing.place(draw(rng), rng)
    for draw in (storage.sideboard, tables.desk, storage.tv_board, tables.coffee_table):
        if furnishing.n_tops < FEWEST_TOPS:
            furnishing.place(draw(rng), rng)
    return tuple(furnishing.placed)


def _draw_set(rng: np.random.Generator) -> list[Draw]:
    """Draw which pieces a room has, the most wanted ones first."""
    wanted: list[Draw] = [kitchen.kitchen_counter if rng.random() < 0.6 else storage.sideboard]
    wanted += [tables.table, soft.sofa if rng.random() < 0.65 else soft.bed, storage.shelf]
    if wanted[2] is soft.sofa and rng.random() < 0.7:
        wanted.append(tables.coffee_table)
    extras: list[tuple[Draw, float]] = [
        (tables.desk, 0.75),
        (storage.sideboard, 0.5),
        (tables.table, 0.4),
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

    @property
    def n_tops(self) -> int:
        """How many surfaces there are for things to stand on."""
        return sum(len(placed.furniture.tops) for placed in self.placed)

    def place(self, furniture: Furniture, rng: np.random.Generator) -> None:
        """Put a piece at the first place tried that suits; leave it out where none does."""
        for _ in range(N_TRIES):
            pose = self._at_wall(furniture, rng) if furniture.against_wall else self._free(rng)
            if pose is not None and self._suits(Placed(furniture, pose)):
                self.placed.append(Placed(furniture, pose))
                return

    def _at_wall(self, furniture: Furniture, rng: np.random.Generator) -> Pose | None:
        """Draw a place at a wall, often in a corner; None where it does not fit there."""
        width, depth, _ = furniture.size
        wall = self._plan.walls[rng.integers(len(self._plan.walls))]
        spare = wall.length - width - 2 * AT_WALL
        x = AT_WALL + width / 2 + spare * float(rng.choice([0.0, 1.0, *rng.random(2)]))
        behind = [
            window
            for window in self._windows
            if window.wall is wall and abs(x - window.middle) < (width + window.width) / 2 + BESIDE
        ]
        if spare < 0:
            return None
        return wall.T_room_wall @ standing(x, -depth / 2 - (AT_WINDOW if behind else AT_WALL))

    def _free(self, rng: np.random.Generator) -> Pose:
        x_min, y_min, x_max, y_max = self._plan.bounds
        turn = float(rng.choice([0.0, np.pi / 2])) + rng.choice([0.0, 1.0]) * rng.normal(0, 0.06)
        return standing(rng.uniform(x_min, x_max), rng.uniform(y_min, y_max), 0.0, turn)

    def _suits(self, candidate: Placed) -> bool:
        """Tell whether a piece stands inside, clear of all others and of doors and ways."""
        box, front = _box(candidate), _front(candidate)
        stands_free = not candidate.furniture.against_wall
        if any(_meet(box, door) for door in self._doors) or self._is_before_window(candidate):
            return False
        for other in self.placed:
            is_way = stands_free or not other.furniture.against_wall
            if _meet(_grown(box, AROUND if is_way else AT_WALL / 2), _box(other)):
                return False
            if _meet(front, _box(other)) or _meet(box, _front(other)):
                return False
        to_wall = AROUND if stands_free else AT_WALL / 2
        return self._is_inside(box, to_wall) and self._leaves_ways(box)

    def _is_before_window(self, candidate: Placed) -> bool:
        """Tell whether a piece takes a window's light, or stands in its curtain or radiator."""
        height = candidate.furniture.size[2]
        return any(
            _meet(_box(candidate), window.front(0.5 if height > window.bottom else 0.15, BESIDE))
            for window in self._windows
        )

    def _is_inside(self, box: Rectangle, to_wall: float) -> bool:
        """Tell whether a rectangle is in the room, metres from all walls."""
        x, y = np.linspace(box[0], box[2], 9), np.linspace(box[1], box[3], 9)
        places = np.stack(np.meshgrid(x, y), -1)
        if not self._plan.contains(places).all():
            return False
        return bool(self._plan.wall_distance(places).min() >= to_wall)

    def _leaves_ways(self, box: Rectangle) -> bool:
        """Tell whether the floor is neither too full nor cut in pieces with one more box."""
        boxes = [*map(_box, self.placed), box]
        covered = sum((b[2] - b[0]) * (b[3] - b[1]) for b in boxes)
        if covered > LARGEST_SHARE * self._plan.area:
            return False
        clearance = floor_clearance(self._plan, boxes)
        wide = piece_sizes(clearance > WIDE_RADIUS)
        is_one_piece = len(piece_sizes(clearance > NARROW_RADIUS)) == 1
        return bool(is_one_piece and wide.max(initial=0) > MAIN_SHARE * wide.sum())


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


def piece_sizes(is_free: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Return how many cells each piece of the free ones has; corners hang together."""
    _, pieces = cv2.connectedComponents(is_free.astype(np.uint8), connectivity=8)
    return np.bincount(pieces.ravel())[1:]


def _box(placed: Placed) -> Rectangle:
    """Return the rectangle around a piece, seen from above."""
    return _around(placed.footprint)


def _front(placed: Placed) -> Rectangle:
    """Return the floor before a piece, where one stands to use it."""
    width, depth, _ = placed.furniture.size
    y = -depth / 2
    reaches, x = (0, IN_FRONT), (-width / 2, width / 2)
    corners = np.array([(side, y - reach, 0, 1) for side in x for reach in reaches])
    return _around((corners @ placed.T_room_furniture.T)[:, :2])


def _around(points: npt.NDArray[np.float64]) -> Rectangle:
    (x_min, y_min), (x_max, y_max) = points.min(0), points.max(0)
    return float(x_min), float(y_min), float(x_max), float(y_max)


def _grown(box: Rectangle, by: float) -> Rectangle:
    return box[0] - by, box[1] - by, box[2] + by, box[3] + by


def _meet(one: Rectangle, other: Rectangle) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
