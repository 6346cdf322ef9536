"""What a room is made of: parts with a role, and lights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.mesh import Mesh

Vector = npt.NDArray[np.floating[Any]]


class Role(Enum):
    """What a part is to the paper's definition of an object (sec. II-A)."""

    OBJECT = "object"  # stands free on a table or the floor: salient
    SUPPORT = "support"  # furniture that carries things or is larger than objects: not salient
    STRUCTURE = "structure"  # floor, walls, and what is fixed to them: not salient
    UNDECIDED = "undecided"  # ignored, such as what stands in a shelf


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One thing of a room; its mesh is in the room's frame.

    name: its kind, such as "mug".
    """

    name: str
    role: Role
    mesh: Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A shining parallelogram: a lamp's face, a window.

    centre: (3,). along, across: (3,) its edges; it shines to the side of along × across.
    rgb: (3,) linear radiance; a white wall in full view of it has at most this brightness.
    """

    centre: Vector
    along: Vector
    across: Vector
    rgb: Vector

    def moved(self, T_to_light: Pose) -> Light:
        """Return the light after a rigid motion, (4, 4)."""
        rotation, shift = T_to_light[:3, :3], T_to_light[:3, 3]
        centre = rotation @ self.centre + shift
        return Light(centre, rotation @ self.along, rotation @ self.across, self.rgb)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """All that a camera can see; the number of a part in an image of ids is its place + 1.

    Frame: metres, z up, the floor at z = 0.
    """

    parts: tuple[Part, ...]
    lights: tuple[Light, ...]

    def moved(self, T_to_scene: Pose) -> Scene:
        """Return all of it after a rigid motion, (4, 4)."""
        parts = (replace(part, mesh=part.mesh.moved(T_to_scene)) for part in self.parts)
        return Scene(tuple(parts), tuple(light.moved(T_to_scene) for light in self.lights))
