"""Walls, floor and ceiling: surfaces with openings cut out, their finish, and skirting.

Walls are drawn in their own frame (see `plan.Wall`): x to the right, y out of the room, z up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from curiosight.rooms import shapes
from curiosight.rooms.mesh import Material, Mesh, join, standing
from curiosight.rooms.plan import FloorPlan, Rectangle, Wall

FLOOR_SPACING, WALL_SPACING, CEILING_SPACING = 0.10, 0.13, 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Opening:
    """A door or a window: where it is in its wall, metres in the wall's frame.

    kind: "door" is closed, "doorway" open, "window". depth: metres of wall that an open one
    leads through.
    """

    kind: str
    wall: Wall
    left: float
    right: float
    bottom: float
    top: float
    depth: float = 0.0

    @property
    def is_door(self) -> bool:
        """Tell whether one goes through it, closed or open."""
        return self.kind != "window"

    @property
    def width(self) -> float:
        """Metres along the wall."""
        return self.right - self.left

    @property
    def middle(self) -> float:
        """Metres from the wall's left end to its middle."""
        return (self.left + self.right) / 2

    @property
    def height(self) -> float:
        """Metres from its lower to its upper edge."""
        return self.top - self.bottom

    def front(self, depth: float, margin: float = 0.0) -> Rectangle:
        """Return the part of the floor before it, in the room: its width and margins, `depth`."""
        corners = np.array(
            [(x, y, 0, 1) for x in (self.left - margin, self.right + margin) for y in (0, -depth)]
        )
        places = (corners @ self.wall.T_room_wall.T)[:, :2]
        (x_min, y_min), (x_max, y_max) = places.min(0), places.max(0)
        return float(x_min), float(y_min), float(x_max), float(y_max)


def wall_surface(
    wall: Wall, z_min: float, z_max: float, openings: Sequence[Opening], material: Material
) -> Mesh:
    """Return a wall from one height to another, with holes; metres of uv go on across them."""
    pieces = []
    edges = {0.0, wall.length}
    edges.update(x for opening in openings for x in (opening.left, opening.right))
    for left, right in pairwise(sorted(edges)):
        heights = [z_min, z_max]
        for opening in openings:
            if opening.left < (left + right) / 2 < opening.right:
                heights += [
                    np.clip(opening.bottom, z_min, z_max),
                    np.clip(opening.top, z_min, z_max),
                ]
        heights.sort()
        pieces += [
            _piece((left, right), (bottom, top), material)
            for bottom, top in zip(heights[::2], heights[1::2], strict=True)
            if top - bottom > 1e-6
        ]
    return join(pieces).moved(wall.T_room_wall)


def floor_surface(plan: FloorPlan, material: Material) -> Mesh:
    """Return the floor, at z = 0."""
    return join([_level(area, 0.0, material) for area in plan.rectangles])


def ceiling_surface(plan: FloorPlan, material: Material) -> Mesh:
    """Return the ceiling, looking down."""
    return join([_level(area, plan.height, material) for area in plan.rectangles])


def strips(
    wall: Wall,
    openings: Sequence[Opening],
    material: Material,
    *,
    bottom: float,
    size: tuple[float, float],
) -> Mesh | None:
    """Return a board along a wall, (thickness, height), or None where openings leave no room.

    It ends at each opening that reaches down to it, as a skirting board does at a door.
    """
    thickness, height = size
    blocking = [o for o in openings if o.bottom < bottom + height and o.top > bottom]
    blocking.sort(key=lambda opening: opening.left)
    ends = [0.0, *(x for o in blocking for x in (o.left - 0.07, o.right + 0.07)), wall.length]
    boards = [
        shapes.box((right - left, thickness, height), material, spacing=0.4, lift=bottom).moved(
            standing((left + right) / 2, -thickness / 2)
        )
        for left, right in zip(ends[::2], ends[1::2], strict=True)
        if right - left > 0.02
    ]
    return join(boards).moved(wall.T_room_wall) if boards else None


def _piece(x: tuple[float, float], z: tuple[float, float], material: Material) -> Mesh:
    panel = shapes.panel(
        (x[0], 0, z[0]), (x[1] - x[0], 0, 0), (0, 0, z[1] - z[0]), material, spacing=WALL_SPACING
    )
    return replace(panel, uv=panel.uv + np.array((x[0], -z[1]), np.float32))


def _level(area: Rectangle, z: float, material: Material) -> Mesh:
    """Return a level rectangle; it looks up at z = 0, down above."""
    x_min, y_min, x_max, y_max = area
    width, depth = x_max - x_min, y_max - y_min
    if z == 0:
        panel = shapes.panel(
            (x_min, y_min, 0), (width, 0, 0), (0, depth, 0), material, spacing=FLOOR_SPACING
        )
        return replace(panel, uv=panel.uv + np.array((x_min, -y_max), np.float32))
    return shapes.panel(
        (x_min, y_max, z), (width, 0, 0), (0, -depth, 0), material, spacing=CEILING_SPACING
    )
