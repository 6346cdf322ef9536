"""A mesh whose triangles are halved where light changes quickly, such as at contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.rooms.mesh import Floats, Mesh

Indices = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class LightMesh:
    """Triangles on top of a mesh's own, at whose corners light is known.

    vertices, normals: (P, 3). uv: (P, 2). triangles: (L, 3), the mesh's own first.
    first_child: (L,) the first of the four that a triangle was cut into, -1 = not cut: three
    with the parent's corners, in order, then the middle one, whose corners lie opposite.
    """

    vertices: Floats
    normals: Floats
    uv: Floats
    triangles: Indices
    first_child: Indices

    @property
    def leaves(self) -> Indices:
        """The (n, 3) triangles that were not cut."""
        return self.triangles[self.first_child < 0]


def uncut(mesh: Mesh) -> LightMesh:
    """Return a mesh as it is."""
    return LightMesh(
        mesh.vertices,
        mesh.normals,
        mesh.uv,
        mesh.triangles,
        np.full(len(mesh.triangles), -1, np.int32),
    )


def cut(mesh: LightMesh, chosen: npt.NDArray[np.integer]) -> LightMesh:
    """Return the mesh with the chosen triangles cut into four, at the middles of their edges."""
    n_vertices, n_triangles = len(mesh.vertices), len(mesh.triangles)
    corners = mesh.triangles[chosen]
    edges = np.sort(corners[:, [[1, 2], [2, 0], [0, 1]]], axis=2).astype(np.int64)
    keys, middle = np.unique(edges[..., 0] * n_vertices + edges[..., 1], return_inverse=True)
    one, other = np.divmod(keys, n_vertices)
    opposite = (middle.reshape(-1, 3) + n_vertices).astype(np.int32)  # the middle of each side
    a, b, c = corners.T
    bc, ca, ab = opposite.T
    children = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, bc, ca, ab], 1).reshape(-1, 3)
    first_child = np.concatenate([mesh.first_child, np.full(len(children), -1, np.int32)])
    first_child[chosen] = n_triangles + 4 * np.arange(len(chosen))
    normals = mesh.normals[one] + mesh.normals[other]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.float32(1e-9))
    return LightMesh(
        np.concatenate([mesh.vertices, (mesh.vertices[one] + mesh.vertices[other]) / 2]),
        np.concatenate([mesh.normals, normals]),
        np.concatenate([mesh.uv, (mesh.uv[one] + mesh.uv[other]) / 2]),
        np.concatenate([mesh.triangles, children]),
        first_child,
    )
