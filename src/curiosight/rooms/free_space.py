"""Where a robot can stand in a room, and how long its ways are."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.rooms.compiling import kernel
from curiosight.rooms.shortest_ways import shortest_ways

Polygon = npt.NDArray[np.floating[Any]]  # (K, 2) metres
Place = npt.NDArray[np.floating[Any]]  # (2,) metres
Mask = npt.NDArray[np.bool_]

ROBOT_RADIUS = 0.25  # metres; a small robot with a mast

# A way through a corner of four cells leads past it on both sides; in cells.
_ASIDE = np.array([1e-3, 7e-4])


class FreeSpace:
    """The floor that a round robot can reach.

    outline: of the room. obstacles: footprints of what stands on the floor.
    radius: of the robot, metres. cell: side of a grid cell, metres. more: outlines of other
    rooms and doorways that hang together with it.

    Where obstacles cut the room in pieces, only the largest counts.
    """

    def __init__(
        self,
        outline: Polygon,
        obstacles: Sequence[Polygon],
        *,
        radius: float = ROBOT_RADIUS,
        cell: float = 0.05,
        more: Sequence[Polygon] = (),
    ) -> None:
        self._cell = cell
        outlines = [np.asarray(polygon, np.float64) for polygon in (outline, *more)]
        corners = np.concatenate(outlines)
        self._origin = corners.min(0)
        extent = corners.max(0) - self._origin
        width, height = (int(n) + 1 for n in np.ceil(extent / cell))
        is_open = np.zeros((height + 2, width + 2), np.uint8)
        for polygon in outlines:
            self._fill(is_open, polygon, 1)
        for obstacle in obstacles:
            self._fill(is_open, obstacle, 0)
        clearance = cv2.distanceTransform(is_open, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * cell
        self.is_free = _largest_piece(clearance > radius)

    def within(self, outline: Polygon) -> FreeSpace:
        """Return the part of it inside an outline, such as that of one room."""
        inside = np.zeros(self.is_free.shape, np.uint8)
        self._fill(inside, outline, 1)
        return self._part(self.is_free & (inside > 0))

    def routable(self) -> FreeSpace:
        """Return the part of it that hangs together by the sides of cells: what `route` can do."""
        return self._part(_largest_piece(self.is_free, connectivity=4))

    def shared_with(self, other: FreeSpace) -> FreeSpace:
        """Return what is free here and there; both must be of the same outlines."""
        return self._part(_largest_piece(self.is_free & other.is_free))

    def _part(self, is_free: Mask) -> FreeSpace:
        part = copy(self)
        part.is_free = is_free
        return part

    @property
    def area(self) -> float:
        """Square metres that the robot's centre can reach."""
        return float(self.is_free.sum()) * self._cell**2

    def contains(self, place: Place) -> bool:
        """Tell whether the robot can stand at (x, y)."""
        row, column = self._cell_of(place)
        inside = 0 <= row < self.is_free.shape[0] and 0 <= column < self.is_free.shape[1]
        return bool(inside and self.is_free[row, column])

    def check(self, place: Place) -> None:
        """Raise ValueError for a place where the robot cannot stand."""
        if not self.contains(place):
            raise ValueError(
                f"viewpoint: expected a place where a robot can stand, got ({place[0]:.2f}, "
                f"{place[1]:.2f}): in a wall, in furniture or too close to them"
            )

    def draw_places(self, n: int, rng: np.random.Generator) -> npt.NDArray[np.float64]:
        """Return (n, 2) places, evenly distributed."""
        rows, columns = np.nonzero(self.is_free)
        if not len(rows):
            raise ValueError("places: expected free floor, got none; the room is too full")
        chosen = rng.integers(len(rows), size=n)
        centres = np.stack([columns[chosen], rows[chosen]], 1) - 1.0
        places = self._origin + (centres + rng.uniform(-0.5, 0.5, (n, 2))) * self._cell
        return np.asarray(places)

    def way(self, start: Place, goal: Place) -> float:
        """Return the metres of the shortest way between two free places.

        On the grid's 8 directions, but never shorter than the straight line, and equal to it
        where nothing stands in between.
        """
        straight = float(np.linalg.norm(np.subtract(goal, start)))
        if self._is_clear(start, goal):
            return straight
        first, last = self._cell_of(start), self._cell_of(goal)
        # A short way is found without a look at the rest of a large floor.
        reach, longest = 1.5 * straight + 1, 1.5 * self._cell * int(self.is_free.sum())
        while True:
            metres = shortest_ways(self.is_free, first, side=self._cell, longest=reach)[0][last]
            if np.isfinite(metres) or reach > longest:
                return max(straight, float(metres))
            reach *= 2

    def ways(self, start: Place, goals: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.float64]:
        """Return the (n,) metres of the ways to (n, 2) places, each as `way` tells it."""
        metres, _ = shortest_ways(self.is_free, self._cell_of(start), side=self._cell)
        straight = np.linalg.norm(goals - start, axis=1)
        around = np.array([metres[self._cell_of(goal)] for goal in goals])
        is_clear = self._are_clear(start, goals)
        lengths: npt.NDArray[np.float64] = np.where(
            is_clear, straight, np.maximum(straight, around)
        )
        return lengths

    def route(self, start: Place, goal: Place) -> npt.NDArray[np.float64]:
        """Return (K, 2) places from one to another, with straight ways between them.

        Both must be of the part that is `routable`.
        """
        ends = np.array([start, goal], np.float64)
        if self._is_free_between(*ends):
            return ends
        first, last = (self._cell_of(place) for place in ends)
        _, before = shortest_ways(self.is_free, first, side=self._cell, has_corners=False)
        cells = [last]
        while cells[-1] != first:
            if before[cells[-1]] < 0:
                raise ValueError(f"route: expected a way from {start} to {goal}, got none")
            row, column = divmod(int(before[cells[-1]]), before.shape[1])
            cells.append((row, column))
        columns_rows = np.array(cells[::-1])[:, ::-1]
        centres = self._origin + (columns_rows - 1.0) * self._cell
        return self._straightened(np.concatenate([ends[:1], centres, ends[1:]]))

    def _straightened(self, places: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the places without those that one can pass by on a straight way."""
        kept, here = [0], 0
        while here < len(places) - 1:
            there = here + 1
            while there + 1 < len(places) and self._is_free_between(
                places[here], places[there + 1]
            ):
                there += 1
            kept.append(there)
            here = there
        return places[kept]

    def _is_free_between(self, start: Place, goal: Place) -> bool:
        """Tell whether each cell is free that a straight way leads through or touches."""
        first = (np.asarray(start) - self._origin) / self._cell + 1.5
        last = (np.asarray(goal) - self._origin) / self._cell + 1.5
        return all(self._is_free_along(first + aside, last + aside) for aside in (_ASIDE, -_ASIDE))

    def _is_free_along(self, first: Place, last: Place) -> bool:
        """Tell whether each cell is free on a straight way between places, in cells."""
        step = last - first
        shares = [np.array([0.0, 1.0])]
        for axis in np.flatnonzero(step):
            low, high = sorted((first[axis], last[axis]))
            shares.append((np.arange(np.ceil(low), np.floor(high) + 1) - first[axis]) / step[axis])
        edges = np.sort(np.concatenate(shares))
        middles = (edges[1:] + edges[:-1]) / 2
        columns, rows = np.floor(first + middles[:, None] * step).astype(np.int64).T
        return bool(self.is_free[rows, columns].all())

    def _is_clear(self, start: Place, goal: Place) -> bool:
        return bool(self._are_clear(start, np.asarray(goal)[None])[0])

    def _are_clear(self, start: Place, goals: npt.NDArray[np.floating[Any]]) -> Mask:
        """Tell of (n, 2) places whether nothing stands on the straight way to each."""
        start, goals = np.asarray(start, np.float64), np.asarray(goals, np.float64)
        metres = np.linalg.norm(goals - start, axis=1)
        shares = np.linspace(0, 1, 2 + int(metres.max(initial=0) / (0.5 * self._cell)))
        return _are_clear(self.is_free, self._origin, self._cell, start, goals, shares)

    def _cell_of(self, place: Place) -> tuple[int, int]:
        cell = np.rint((place - self._origin) / self._cell) + 1
        return int(cell[1]), int(cell[0])

    def _fill(self, grid: npt.NDArray[np.uint8], polygon: Polygon, value: int) -> None:
        """Fill a polygon; the grid has a border of one closed cell around the room."""
        corners = np.rint((np.asarray(polygon) - self._origin) / self._cell + 1).astype(np.int32)
        cv2.fillPoly(grid, [corners], value)


@kernel
def _are_clear(
    is_free: Mask, origin: Place, cell: float, start: Place, goals: Place, shares: Place
) -> Mask:
    """Tell of (n, 2) goals whether at all (k,) shares of the straight way to each is free floor."""
    height, width = is_free.shape
    clear = np.ones(len(goals), np.bool_)
    for goal in range(len(goals)):
        for share in shares:
            x = start[0] + share * (goals[goal, 0] - start[0])
            y = start[1] + share * (goals[goal, 1] - start[1])
            column = int(np.rint((x - origin[0]) / cell)) + 1
            row = int(np.rint((y - origin[1]) / cell)) + 1
            is_inside = 0 <= column < width and 0 <= row < height
            if not is_inside or not is_free[row, column]:
                clear[goal] = False
                break
    return clear


def _largest_piece(is_free: Mask, connectivity: int = 8) -> Mask:
    n_pieces, pieces = cv2.connectedComponents(is_free.astype(np.uint8), connectivity=connectivity)
    if n_pieces == 1:
        return is_free
    sizes = np.bincount(pieces.ravel(), minlength=n_pieces)
    sizes[0] = 0
    return np.asarray(pieces == sizes.argmax())
