"""Rays against triangles, by Embree."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from curiosight.rooms.mesh import Floats, Mesh

Item = TypeVar("Item")
Result = TypeVar("Result")


class Hits(NamedTuple):
    """Where rays meet the first triangle on their way.

    triangle: (N,) int32, -1 = nothing met. second, third: (N,) weights of its corners there.
    distance: (N,) in lengths of the ray's direction, huge where nothing is met.
    """

    triangle: npt.NDArray[np.int32]
    second: Floats
    third: Floats
    distance: Floats


class RayCaster:
    """Casts rays at a mesh.

    n_threads: how many calls of `map` run at a time; it never changes a result.
    """

    def __init__(self, mesh: Mesh, n_threads: int = 1) -> None:
        self.n_threads = n_threads
        self._scene = EmbreeScene(robust=True)  # no ray slips through between two triangles
        corners = mesh.vertices[mesh.triangles]
        self._normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._triangles = TriangleMesh(self._scene, mesh.vertices, mesh.triangles)
        nowhere = np.zeros((1, 3), np.float32)
        self._scene.run(nowhere, nowhere + 1)  # builds the tree: threads must find it built

    def hits(self, origins: Floats, directions: Floats) -> Hits:
        """Return what each ray meets first; (N, 3) origins and directions of any length."""
        found = self._scene.run(origins, directions, output=1)
        return Hits(found["primID"], found["u"], found["v"], found["tfar"])

    def is_behind(self, hits: Hits, directions: Floats) -> npt.NDArray[np.bool_]:
        """Tell which rays met a triangle from behind; False where they met nothing."""
        along = np.einsum("ij,ij->i", self._normals[hits.triangle], directions)
        is_behind: npt.NDArray[np.bool_] = (along > 0) & (hits.triangle >= 0)
        return is_behind

    def is_free(self, origins: Floats, directions: Floats, reach: Floats) -> npt.NDArray[np.bool_]:
        """Tell which rays meet nothing within (N,) `reach` lengths of their direction."""
        free: npt.NDArray[np.bool_] = (
            self._scene.run(origins, directions, dists=reach, query="OCCLUDED") < 0
        )
        return free

    def map(self, work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """Return what the work gives for each item, in order."""
        if self.n_threads == 1:
            return [work(item) for item in items]
        with ThreadPoolExecutor(self.n_threads) as threads:
            return list(threads.map(work, items))


def portions(n_items: int, size: int) -> list[slice]:
    """Cut a row of items into slices of at most `size`."""
    return [slice(start, min(start + size, n_items)) for start in range(0, n_items, size)]
