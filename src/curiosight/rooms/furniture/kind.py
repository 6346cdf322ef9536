"""A piece of furniture, and its place in a room."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.plan import Rectangle
from curiosight.rooms.scene import Part, Role


@dataclass(frozen=True, slots=True)
class Top:
    """A level rectangle on which things may stand, metres in the furniture's frame."""

    height: float
    area: Rectangle


@dataclass(frozen=True, slots=True, eq=False)
class Furniture:
    """A piece of furniture in its own frame: on z = 0, centred in x and y, its back at +y.

    size: (width, depth, height). tops: where things may stand. against_wall: else it stands
    free. contents: what it holds, neither object nor furniture; None = it holds nothing.
    """

    name: str
    mesh: Mesh
    size: tuple[float, float, float]
    tops: tuple[Top, ...] = ()
    against_wall: bool = True
    contents: Mesh | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A piece of furniture where it stands."""

    furniture: Furniture
    T_room_furniture: Pose

    def parts(self, role: Role) -> tuple[Part, ...]:
        """Return its parts in the room, the first of which has the role."""
        own = self.furniture
        parts = [Part(own.name, role, own.mesh.moved(self.T_room_furniture))]
        if own.contents is not None:
            contents = own.contents.moved(self.T_room_furniture)
            parts.append(Part(f"{own.name} contents", Role.UNDECIDED, contents))
        return tuple(parts)

    def carries(self, place: npt.NDArray[np.floating[Any]]) -> bool:
        """Tell whether what stands at a place (3,) of the room is on one of its tops."""
        x, y, z = (place - self.T_room_furniture[:3, 3]) @ self.T_room_furniture[:3, :3]
        return any(
            top.area[0] <= x <= top.area[2]
            and top.area[1] <= y <= top.area[3]
            and abs(z - top.height) < 0.01
            for top in self.furniture.tops
        )

    @property
    def tops(self) -> tuple[tuple[Pose, Rectangle], ...]:
        """Its tops: (4, 4) pose whose z is the height, and rectangle in that frame, each."""
        lifts = [np.eye(4) for _ in self.furniture.tops]
        for lift, top in zip(lifts, self.furniture.tops, strict=True):
            lift[2, 3] = top.height
        return tuple(
            (self.T_room_furniture @ lift, top.area)
            for lift, top in zip(lifts, self.furniture.tops, strict=True)
        )

    @property
    def footprint(self) -> npt.NDArray[np.float64]:
        """The (4, 2) corners of the floor that it covers, counter-clockwise, in the room."""
        half = np.array(self.furniture.size[:2]) / 2
        corners = half * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        rotation, shift = self.T_room_furniture[:2, :2], self.T_room_furniture[:2, 3]
        return np.asarray(corners @ rotation.T + shift, np.float64)


def centred(width: float, depth: float, margin: float = 0.0) -> Rectangle:
    """Return a rectangle around 0, without a margin on all sides."""
    x, y = width / 2 - margin, depth / 2 - margin
    return -x, -y, x, y
