"""Light on the surfaces of a room, worked out once: from lamps and windows, and what comes back.

Light is a number for each colour: the brightness that it gives to white matt paper. It is kept
at the corners of triangles, which are cut where it changes quickly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.rooms.compiling import kernel
from curiosight.rooms.light_mesh import LightMesh, cut, uncut
from curiosight.rooms.light_rays import LightRays, scattered_light
from curiosight.rooms.mesh import Floats, Mesh
from curiosight.rooms.scene import Light
from curiosight.rooms.tracing import RayCaster

# Metres that a point of view is lifted off its surface, and drawn away from the face's edge,
# where another surface may touch.
LIFT, INSET = 2e-3, 8e-3
# A triangle is cut where the light of its corners differs by this share of their mean: first
# those with edges longer than so many metres, then, among their pieces, than so many.
STEP = 0.5
LONGEST_UNCUT = (0.08, 0.04)
# Vertices share their light where the cosine of the angle between their normals is above.
SMOOTH_COSINE = 0.8
N_SMOOTHINGS = 2


@dataclass(frozen=True, slots=True, eq=False)
class LitMesh:
    """A mesh, and the light at each of its vertices.

    direct: (P, 3) from the lights, with shadows. unshadowed: (P,) the share of it that is not
    in shadow. indirect: (P, 3) from other surfaces.
    """

    mesh: LightMesh
    direct: Floats
    unshadowed: Floats
    indirect: Floats


def lit(mesh: Mesh, lights: Sequence[Light], caster: RayCaster, seed: int) -> LitMesh:
    """Work out the light of a mesh; the seed turns the patterns of rays from point to point."""
    rays = LightRays(caster, lights, np.random.default_rng(seed))
    fine, newest = uncut(mesh), slice(0, len(mesh.triangles))
    points = points_of_view(fine, newest)
    direct = rays.direct(points, mesh.normals)
    scattered = scattered_light(mesh, direct[:, :3])
    light = np.column_stack([direct, rays.indirect(points, mesh.normals, scattered)])
    for longest_uncut in LONGEST_UNCUT:
        chosen = uneven(fine, newest, light, longest_uncut)
        if len(chosen) == 0:
            break
        n_known, newest = len(light), slice(len(fine.triangles), None)
        fine = cut(fine, chosen)
        points, normals = points_of_view(fine, newest)[n_known:], fine.normals[n_known:]
        more = [rays.direct(points, normals), rays.indirect(points, normals, scattered)]
        light = np.concatenate([light, np.column_stack(more)])
    neighbours = smooth_neighbours(fine)
    light = smooth(fill(light, is_buried(light), neighbours), neighbours)
    return LitMesh(fine, light[:, :3], light[:, 3], light[:, 4:7])


def points_of_view(mesh: LightMesh, chosen: slice) -> Floats:
    """Return (P, 3) points just above the vertices, a little towards their triangles' middle.

    chosen: the triangles that count.
    """
    triangles = mesh.triangles[chosen]
    corners, n_vertices = triangles.ravel(), len(mesh.vertices)
    middles = np.repeat(mesh.vertices[triangles].mean(1), 3, axis=0)
    n_middles = np.bincount(corners, minlength=n_vertices)
    sums = [np.bincount(corners, middles[:, axis], n_vertices) for axis in range(3)]
    inwards = np.stack(sums, 1) / np.maximum(n_middles, 1)[:, None] - mesh.vertices
    inwards[n_middles == 0] = 0
    inwards -= np.einsum("ij,ij->i", inwards, mesh.normals)[:, None] * mesh.normals
    length = np.maximum(np.linalg.norm(inwards, axis=1), 1e-9)
    inwards *= (np.minimum(INSET, length / 4) / length)[:, None]
    return (mesh.vertices + inwards + LIFT * mesh.normals).astype(np.float32)


def uneven(
    mesh: LightMesh, newest: slice, light: Floats, longest_uncut: float
) -> npt.NDArray[np.intp]:
    """Return the newest triangles with a longer edge across which light changes much."""
    triangles = mesh.triangles[newest]
    brightness = np.where(is_buried(light), 0, (light[:, :3] + light[:, 4:7]).mean(1))
    corners = brightness[triangles]
    step = STEP * (corners.mean(1) + brightness.mean() / 10)
    points = mesh.vertices[triangles]
    longest = np.linalg.norm(points - points[:, [1, 2, 0]], axis=2).max(1)
    is_uneven = (np.ptp(corners, axis=1) > step) & (longest > longest_uncut)
    return np.flatnonzero(is_uneven) + np.intp(newest.start)


def is_buried(light: Floats) -> npt.NDArray[np.bool_]:
    """Tell which vertices lie inside of a thing: most of what they see are backs."""
    is_inside: npt.NDArray[np.bool_] = light[:, 7] > 0.5
    return is_inside


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Of each of P vertices, others: those of vertex p are `others[starts[p] : starts[p + 1]]`."""

    starts: npt.NDArray[np.int64]
    others: npt.NDArray[np.int64]

    def count(self) -> Floats:
        """Return the (P,) number of each vertex's neighbours."""
        return np.diff(self.starts).astype(np.float32)

    def sums(self, light: Floats) -> Floats:
        """Return for each vertex the sum of its neighbours' rows of (P, n) light."""
        return _sums(np.ascontiguousarray(light), self.starts, self.others)


@kernel
def _sums(light: Floats, starts: npt.NDArray[np.int64], others: npt.NDArray[np.int64]) -> Floats:
    sums = np.zeros_like(light)
    for vertex in range(len(starts) - 1):
        for place in range(starts[vertex], starts[vertex + 1]):
            for column in range(light.shape[1]):
                sums[vertex, column] += light[others[place], column]
    return sums


def smooth_neighbours(mesh: LightMesh) -> Neighbours:
    """Return the vertices that an edge joins to each and whose normal is nearly the same."""
    one, other = mesh.leaves.ravel(), mesh.leaves[:, [1, 2, 0]].ravel()
    cosine = np.einsum("ij,ij->i", mesh.normals[one], mesh.normals[other])
    is_smooth = cosine > SMOOTH_COSINE
    one, other = one[is_smooth].astype(np.int64), other[is_smooth].astype(np.int64)
    n_vertices = len(mesh.vertices)
    # An edge of two triangles counts once.
    pairs = np.unique(np.concatenate([one * n_vertices + other, other * n_vertices + one]))
    vertex, others = np.divmod(pairs, n_vertices)
    return Neighbours(np.searchsorted(vertex, np.arange(n_vertices + 1)), others)


def fill(light: Floats, is_missing: npt.NDArray[np.bool_], neighbours: Neighbours) -> Floats:
    """Return the light with vertices inside of things lit like their neighbours outside.

    The triangles that stick out would else be dark to their middle.
    """
    is_known = (~is_missing).astype(np.float32)
    n_known = neighbours.sums(is_known[:, None])[:, 0]
    mean = neighbours.sums(light * is_known[:, None]) / np.maximum(n_known, 1)[:, None]
    return np.where((is_missing & (n_known > 0))[:, None], mean, light)


def smooth(light: Floats, neighbours: Neighbours) -> Floats:
    """Return the light with each vertex drawn halfway towards its neighbours, some times."""
    n_neighbours = neighbours.count()[:, None]
    for _ in range(N_SMOOTHINGS):
        mean = neighbours.sums(light) / np.maximum(n_neighbours, 1)
        light = np.where(n_neighbours > 0, (light + mean) / 2, light)
    return light.astype(np.float32)
