"""What a kind of thing is, and how its parts become one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from curiosight.rooms.mesh import Mesh, join, standing

Draw = Callable[[np.random.Generator], Mesh]

TABLE = frozenset({"table"})
FLOOR = frozenset({"floor"})
ANYWHERE = TABLE | FLOOR


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of thing that stands about in rooms.

    draw: returns one of them, varied in shape, size, colour and texture; it stands on z = 0,
        centred in x and y, its front towards -y.
    places: where it is put, of "table" and "floor".
    """

    name: str
    draw: Draw
    places: frozenset[str]


def assembled(parts: Sequence[Mesh]) -> Mesh:
    """Return one mesh of all parts, shifted to stand on z = 0, centred in x and y."""
    whole = join(parts)
    low, high = whole.bounds
    middle = (low + high) / 2
    return whole.moved(standing(-middle[0], -middle[1], -low[2]))


def at(mesh: Mesh, x: float, y: float, z: float = 0.0, heading: float = 0.0) -> Mesh:
    """Return the mesh turned by `heading` radians about z, then shifted."""
    return mesh.moved(standing(x, y, z, heading))
