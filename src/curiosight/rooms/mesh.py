"""Triangles and what they are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose

Floats = npt.NDArray[np.float32]
Texture = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """How a surface looks, and how it answers a depth sensor.

    texture: (h, w, 3) uint8 sRGB; row 0 is at v = 0, rows go with v. It repeats.
    tile: lengths in u and v that one repeat covers, in the unit of the mesh's uv.
    gloss: strength of highlights, 0 = matt, 1 = polished. sharpness: their Phong exponent.
    emission: light of its own, in multiples of the texture.
    infrared: share of a depth sensor's light that comes back, 1 = all; black plastic about
        0.1, glass and polished metal less: the sensor gets no reading there.
    """

    texture: Texture
    tile: tuple[float, float] = (1.0, 1.0)
    gloss: float = 0.0
    sharpness: float = 20.0
    emission: float = 0.0
    infrared: float = 1.0

    def __post_init__(self) -> None:
        texture = self.texture
        if texture.ndim != 3 or texture.shape[2] != 3 or texture.dtype != np.uint8:
            raise ValueError(
                f"texture: expected (h, w, 3) uint8, got {texture.shape} {texture.dtype}"
            )
        if min(self.tile) <= 0:
            raise ValueError(f"tile: expected positive lengths, got {self.tile}")


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A surface of triangles; metres, z up.

    vertices: (V, 3). normals: (V, 3) unit, outwards. uv: (V, 2) place in the texture.
    triangles: (T, 3) int32 vertices, counter-clockwise from outside.
    surface: (T,) int32 number of each triangle's material.

    Light is worked out at the vertices: large flat faces need some in between.
    """

    vertices: Floats
    normals: Floats
    uv: Floats
    triangles: npt.NDArray[np.int32]
    surface: npt.NDArray[np.int32]
    materials: tuple[Material, ...]

    def moved(self, T_to_mesh: Pose) -> Mesh:
        """Return the mesh after a rigid motion, (4, 4)."""
        rotation, translation = T_to_mesh[:3, :3], T_to_mesh[:3, 3]
        return replace(
            self,
            vertices=(self.vertices @ rotation.T + translation).astype(np.float32),
            normals=(self.normals @ rotation.T).astype(np.float32),
        )

    @property
    def bounds(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The lowest and the highest corner, (3,) each."""
        points = self.vertices.astype(np.float64)
        return points.min(0), points.max(0)

    @property
    def diagonal(self) -> float:
        """Metres across the upright box around it."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))


def join(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of several; a material that they share is kept once."""
    if not meshes:
        raise ValueError("meshes: expected at least one, got none")
    materials: list[Material] = []
    number_of: dict[int, int] = {}
    triangles, surfaces = [], []
    n_vertices = 0
    for mesh in meshes:
        for material in mesh.materials:
            if id(material) not in number_of:
                number_of[id(material)] = len(materials)
                materials.append(material)
        numbers = np.array([number_of[id(material)] for material in mesh.materials], np.int32)
        triangles.append(mesh.triangles + np.int32(n_vertices))
        surfaces.append(numbers[mesh.surface])
        n_vertices += len(mesh.vertices)
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.uv for mesh in meshes]),
        np.concatenate(triangles),
        np.concatenate(surfaces),
        tuple(materials),
    )


def standing(x: float, y: float, z: float = 0.0, heading: float = 0.0) -> Pose:
    """Return the motion that turns by `heading` radians about z, then shifts to a place."""
    cos, sin = np.cos(heading), np.sin(heading)
    pose = np.eye(4)
    pose[:2, :2] = [[cos, -sin], [sin, cos]]
    pose[:3, 3] = x, y, z
    return pose
