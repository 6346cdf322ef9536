"""The outline of a room, and its walls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.mesh import standing

Points = npt.NDArray[np.floating[Any]]  # (N, 2) metres, seen from above
Rectangle = tuple[float, float, float, float]  # x_min, y_min, x_max, y_max

PLAN_SHAPES = ("rect", "l")


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """One straight wall.

    T_room_wall: (4, 4) from the wall's own frame, in which x runs along it from its left end
        to its right one as seen from inside, y points out of the room, z up.
    length: metres from end to end.
    """

    T_room_wall: Pose
    length: float

    @property
    def ends(self) -> Points:
        """The left and the right end, (2, 2) metres in the room."""
        left, along = self.T_room_wall[:2, 3], self.T_room_wall[:2, 0]
        return np.stack((left, left + self.length * along))


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """A room seen from above.

    outline: (K, 2) metres, counter-clockwise, each wall along x or y.
    height: metres from floor to ceiling.
    """

    outline: Points
    height: float

    def __post_init__(self) -> None:
        outline = np.asarray(self.outline)
        if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 4:
            raise ValueError(f"outline: expected (K, 2), K at least 4, got {outline.shape}")
        steps = np.roll(outline, -1, axis=0) - outline
        if (np.abs(steps).min(1) > 1e-9).any():
            raise ValueError("outline: expected walls along x or y, got a slanting one")
        if self.area <= 0:
            raise ValueError("outline: expected counter-clockwise corners, got clockwise ones")

    @property
    def area(self) -> float:
        """Square metres of floor."""
        x, y = self.outline.T
        return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)

    @property
    def bounds(self) -> Rectangle:
        """The rectangle around it."""
        (x_min, y_min), (x_max, y_max) = self.outline.min(0), self.outline.max(0)
        return float(x_min), float(y_min), float(x_max), float(y_max)

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Its walls, in the order of the outline."""
        ends = np.roll(self.outline, -1, axis=0)
        # Seen from inside, a counter-clockwise outline runs from right to left.
        return tuple(_wall(end, start) for start, end in zip(self.outline, ends, strict=True))

    @cached_property
    def rectangles(self) -> tuple[Rectangle, ...]:
        """Rectangles that cover the floor once."""
        starts, ends = self.outline, np.roll(self.outline, -1, axis=0)
        rectangles = []
        for x_min, x_max in pairwise(np.unique(self.outline[:, 0])):
            middle = (x_min + x_max) / 2
            is_above = (starts[:, 0] < middle) != (ends[:, 0] < middle)
            y = np.sort(starts[is_above, 1])
            rectangles += [
                (float(x_min), float(y_min), float(x_max), float(y_max))
                for y_min, y_max in y.reshape(-1, 2)
            ]
        return tuple(rectangles)

    def contains(self, points: Points) -> npt.NDArray[np.bool_]:
        """Tell for (..., 2) points whether they lie inside; a border counts as inside."""
        x, y = np.asarray(points)[..., 0], np.asarray(points)[..., 1]
        is_inside = np.zeros(x.shape, bool)
        for x_min, y_min, x_max, y_max in self.rectangles:
            is_inside |= (x >= x_min) & (x <= x_max) & (y >= y_min) & (y <= y_max)
        return is_inside

    def wall_distance(self, points: Points) -> npt.NDArray[np.float64]:
        """Return the metres from (..., 2) points to the nearest wall, on whichever side."""
        places = np.asarray(points, np.float64)
        distance = np.full(places.shape[:-1], np.inf)
        for wall in self.walls:
            offset = places - np.clip(places, wall.ends.min(0), wall.ends.max(0))
            distance = np.minimum(distance, np.linalg.norm(offset, axis=-1))
        return distance


def draw_plan(rng: np.random.Generator, shape: Literal["rect", "l"] | None = None) -> FloorPlan:
    """Draw a room's outline, its lowest corner at (0, 0).

    shape: "rect", 5.5-8 m by 4.2-6 m; "l", up to 9 m, without one corner; None = drawn.
    """
    if shape is None:
        shape = "l" if rng.random() < 0.4 else "rect"
    if shape not in PLAN_SHAPES:
        raise ValueError(f"shape: expected {' or '.join(PLAN_SHAPES)}, got {shape}")
    height = float(np.round(rng.uniform(2.4, 2.8), 2))
    if shape == "rect":
        size = np.round((rng.uniform(5.5, 8.0), rng.uniform(4.2, 6.0)), 2)
        return FloorPlan(size * [(0, 0), (1, 0), (1, 1), (0, 1)], height)
    x, y = np.round((rng.uniform(7.0, 9.0), rng.uniform(5.6, 7.0)), 2)
    cut_x, cut_y = np.round((x * rng.uniform(0.35, 0.5), y * rng.uniform(0.35, 0.5)), 2)
    outline = np.array(
        [(0, 0), (x, 0), (x, y - cut_y), (x - cut_x, y - cut_y), (x - cut_x, y), (0, y)]
    )
    return FloorPlan(_turned(outline, rng), height)


def _wall(left: Points, right: Points) -> Wall:
    x, y = right - left
    pose = standing(float(left[0]), float(left[1]), 0.0, float(np.arctan2(y, x)))
    return Wall(pose, float(np.hypot(x, y)))


def _turned(outline: Points, rng: np.random.Generator) -> Points:
    """Mirror an outline so that any of its corners may be the missing one."""
    size = outline.max(0)
    for axis in range(2):
        if rng.random() < 0.5:
            outline = outline.copy()
            outline[:, axis] = size[axis] - outline[:, axis]
            outline = outline[::-1]
    return outline
