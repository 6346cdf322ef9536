"""Where pictures, notice boards, clocks, sockets and switches hang."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from curiosight.rooms.mesh import Mesh, standing
from curiosight.rooms.plan import FloorPlan, Wall
from curiosight.rooms.shell import hangings
from curiosight.rooms.shell.walls import Opening

# Metres of wall for one picture, and for one socket.
WALL_PER_PICTURE, WALL_PER_OUTLET = 1.7, 2.4
SOCKET_HEIGHT, SWITCH_HEIGHT = 0.32, 1.08


class WallSpace:
    """The stretches of one wall that are still free, metres from its left end."""

    def __init__(self, wall: Wall, openings: Sequence[Opening]) -> None:
        self.wall = wall
        self.openings = [opening for opening in openings if opening.wall is wall]
        self._taken = [(o.left - 0.4, o.right + 0.4) for o in self.openings]

    def take(self, width: float, rng: np.random.Generator) -> float | None:
        """Return the middle of a free stretch, now taken; None where none is wide enough."""
        edges = [(-1.0, 0.1), *sorted(self._taken), (self.wall.length - 0.1, np.inf)]
        gaps = [(a[1], b[0]) for a, b in pairwise(edges) if b[0] - a[1] >= width]
        if not gaps:
            return None
        left, right = gaps[rng.integers(len(gaps))]
        middle = float(rng.uniform(left + width / 2, right - width / 2))
        self._taken.append((middle - width / 2 - 0.08, middle + width / 2 + 0.08))
        return middle

    def is_solid(self, x: float) -> bool:
        """Tell whether there is wall at x, 8 cm to both sides, from floor to ceiling."""
        inside = 0.08 < x < self.wall.length - 0.08
        return inside and all(not o.left - 0.18 < x < o.right + 0.18 for o in self.openings)

    def at(self, mesh: Mesh, x: float, z: float) -> Mesh:
        """Return a mesh hung with its middle at x and z."""
        return mesh.moved(self.wall.T_room_wall @ standing(x, 0.0, z))


def hang(
    plan: FloorPlan, openings: Sequence[Opening], lowest: float, rng: np.random.Generator
) -> Iterator[tuple[str, Mesh]]:
    """Yield what hangs on the walls, with its name; lowest: metres, of a picture's lower edge."""
    spaces = [WallSpace(wall, openings) for wall in plan.walls]
    if rng.random() < 0.6:
        yield from _notice_board(spaces[rng.integers(len(spaces))], lowest, rng)
    if rng.random() < 0.7:
        yield from _clock(spaces[rng.integers(len(spaces))], rng)
    for space in spaces:
        yield from _pictures(space, lowest, rng)
        yield from _sockets(space, rng)
        yield from _switches(space, rng)


def _notice_board(
    space: WallSpace, lowest: float, rng: np.random.Generator
) -> Iterator[tuple[str, Mesh]]:
    width, height = float(rng.uniform(0.7, 1.2)), float(rng.uniform(0.5, 0.8))
    x = space.take(width, rng)
    if x is not None:
        mesh = hangings.notice_board_mesh(width, height, rng)
        yield "notice board", space.at(mesh, x, lowest + 0.15 + height / 2)


def _clock(space: WallSpace, rng: np.random.Generator) -> Iterator[tuple[str, Mesh]]:
    x = space.take(0.4, rng)
    if x is not None:
        yield "clock", space.at(hangings.clock_mesh(rng), x, float(rng.uniform(1.8, 2.0)))


def _pictures(
    space: WallSpace, lowest: float, rng: np.random.Generator
) -> Iterator[tuple[str, Mesh]]:
    for _ in range(int(rng.poisson(space.wall.length / WALL_PER_PICTURE))):
        width = float(rng.uniform(0.28, 0.95))
        height = float(np.clip(width * rng.uniform(0.65, 1.5), 0.28, 0.95))
        x = space.take(width, rng)
        if x is not None:
            z = lowest + float(rng.uniform(0.05, 0.4)) + height / 2
            yield "poster", space.at(hangings.picture_mesh(width, height, rng), x, z)


def _sockets(space: WallSpace, rng: np.random.Generator) -> Iterator[tuple[str, Mesh]]:
    for x in rng.uniform(0, space.wall.length, int(space.wall.length / WALL_PER_OUTLET)):
        if space.is_solid(float(x)):
            yield "outlet", space.at(hangings.outlet_mesh(rng), float(x), SOCKET_HEIGHT)


def _switches(space: WallSpace, rng: np.random.Generator) -> Iterator[tuple[str, Mesh]]:
    for door in (opening for opening in space.openings if opening.is_door):
        for x in (door.left - 0.2, door.right + 0.2):
            if space.is_solid(x):
                yield "switch", space.at(hangings.switch_mesh(rng), x, SWITCH_HEIGHT)
                break
