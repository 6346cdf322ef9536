"""Make a thing to stand in a room of a model from a furniture library."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.sweet_home.wavefront import Model, ModelError

Array = npt.NDArray[Any]

# Faces that meet at less than this are one smooth surface.
CREASE_DEG = 40.0
# Of a vertex with more faces (the middle of a fan) only so many are smoothed with each other.
MAX_NEIGHBOURS = 64
MAX_EDGE_METRES = 0.12
MAX_CUT_TRIANGLES = 25_000
MAX_TEXTURE_PLACE = 1000.0
MIN_AREA = 1e-12  # m², twice the triangle's
# Each face looks in so many directions, from so far above itself.
N_LOOKS = 16
OFFSET_METRES = 1e-4
# The libraries have y up and the front at +z.
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def model_mesh(
    model: Model, materials: Sequence[Material], size: tuple[float, float, float], rotation: Array
) -> Mesh:
    """Return the model in metres, z up, its front to -y, standing on z = 0 in the middle.

    materials: those of `model.materials`. size: width, depth and height that it gets.
    rotation: (3, 3) that the library turns its model by first.

    Faces that are there twice, one for each side, are kept once, and all are turned outwards.
    Normals are made anew, smooth where faces meet flatly, as the files' are often missing. Long
    triangles are cut, for the light that is worked out at their corners.
    """
    triangles = model.corners
    points = _placed(model.positions @ (UPRIGHT @ rotation).T, triangles[..., 0], size)
    places = np.vstack([model.texture_places, [[0.0, 0.0]]])  # the last is that of -1
    corners = np.concatenate([points[triangles[..., 0]], places[triangles[..., 1]]], axis=2)
    corners[..., 3:] = np.clip(corners[..., 3:], -MAX_TEXTURE_PLACE, MAX_TEXTURE_PLACE)
    kept = _kept_once(corners)
    if not len(kept):
        raise ModelError("no face has an area")
    corners, surface = _cut(_turned_outwards(corners[kept]), model.material[kept])
    return _shared_vertices(corners, surface, tuple(materials))


def _placed(points: Array, used: Array, size: tuple[float, float, float]) -> Array:
    """Scale and shift points so that the used ones fill a box that stands at the origin."""
    low, high = points[used].min((0, 1)), points[used].max((0, 1))
    extent = high - low
    if not (extent > 0).any():
        raise ModelError("all vertices are at one place")
    scale = np.where(extent > 1e-6 * extent.max(), size / np.maximum(extent, 1e-300), 1.0)
    base = np.append((low + high)[:2] / 2, low[2])
    placed: Array = (points - base) * scale
    return placed


def _cross(corners: Array) -> Array:
    """Return (T, 3) normals as long as twice the area."""
    origin = corners[:, 0, :3]
    normals: Array = np.cross(corners[:, 1, :3] - origin, corners[:, 2, :3] - origin)
    return normals


def _kept_once(corners: Array) -> Array:
    """Return the numbers of the triangles that have an area, of those in one place the first."""
    has_area = np.flatnonzero(np.linalg.norm(_cross(corners), axis=1) > MIN_AREA)
    vertices = np.sort(_places_shared(corners[has_area]), axis=1)
    _, first = np.unique(vertices, axis=0, return_index=True)
    kept: Array = has_area[np.sort(first)]
    return kept


def _places_shared(corners: Array) -> Array:
    """Return (T, 3) numbers of the corners, the same for the same place to 0.01 mm."""
    points = corners[..., :3].reshape(-1, 3).round(5)
    _, numbers = np.unique(points, axis=0, return_inverse=True)
    places: Array = numbers.reshape(-1, 3)
    return places


def _turned_outwards(corners: Array) -> Array:
    """Turn the triangles that see clearly less of the outside in front than behind."""
    caster = EmbreeScene(robust=True)
    TriangleMesh(caster, corners[..., :3].astype(np.float32))
    normals = _cross(corners)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    centres = corners[..., :3].mean(1)
    n_seen = np.zeros((2, len(corners)), int)
    for direction in _all_around(N_LOOKS):
        is_front = normals @ direction > 0
        offset = np.where(is_front, OFFSET_METRES, -OFFSET_METRES)[:, None] * normals
        origins = (centres + offset).astype(np.float32)
        directions = np.broadcast_to(direction, origins.shape).astype(np.float32)
        is_free = caster.run(origins, directions) < 0
        n_seen[0] += is_free & is_front
        n_seen[1] += is_free & ~is_front
    is_inside_out = n_seen[1] > 2 * n_seen[0] + 1
    return np.where(is_inside_out[:, None, None], corners[:, ::-1], corners)


def _all_around(n_directions: int) -> Array:
    """Return (N, 3) unit vectors, spread evenly over the sphere by the golden angle."""
    step = np.arange(n_directions) + 0.5
    z = 1 - 2 * step / n_directions
    angle = np.pi * (1 + np.sqrt(5)) * step
    radius = np.sqrt(1 - z**2)
    directions: Array = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    return directions


def _cut(corners: Array, surface: Array) -> tuple[Array, Array]:
    """Halve triangles at their longest edge until no edge is longer than `MAX_EDGE_METRES`.

    Edges are halved at the same point from both sides, so no crack opens.
    """
    while True:
        edges = np.linalg.norm((np.roll(corners, -1, axis=1) - corners)[..., :3], axis=2)
        long = np.flatnonzero(edges.max(1, initial=0) > MAX_EDGE_METRES)
        if not len(long) or len(corners) + len(long) > MAX_CUT_TRIANGLES:
            return corners, surface
        turn = (edges[long].argmax(1)[:, None] + np.arange(3)) % 3
        turned = np.take_along_axis(corners[long], turn[..., None], axis=1)
        start, end, opposite = turned.swapaxes(0, 1)
        middle = (start + end) / 2
        corners[long] = np.stack([start, middle, opposite], axis=1)
        corners = np.concatenate([corners, np.stack([middle, end, opposite], axis=1)])
        surface = np.concatenate([surface, surface[long]])


def _shared_vertices(corners: Array, surface: Array, materials: tuple[Material, ...]) -> Mesh:
    """Return a mesh in which corners that agree in everything are one vertex."""
    rows = np.concatenate([corners, _smooth_normals(corners)], axis=2)
    rows = rows.reshape(-1, 8).astype(np.float32)
    _, first, vertex = np.unique(rows.round(4), axis=0, return_index=True, return_inverse=True)
    return Mesh(
        rows[first, :3],
        rows[first, 5:],
        rows[first, 3:5],
        vertex.reshape(-1, 3).astype(np.int32),
        surface,
        materials,
    )


def _smooth_normals(corners: Array) -> Array:
    """Return (T, 3, 3) unit normals at the corners: the mean of the faces around, by area.

    Faces that meet at more than `CREASE_DEG` do not count.
    """
    by_area = _cross(corners)
    unit = by_area / np.linalg.norm(by_area, axis=1, keepdims=True)
    vertex = _places_shared(corners).ravel()
    order = np.argsort(vertex, kind="stable")
    vertex, face = vertex[order], order // 3
    sums = by_area[face]
    for shift in range(1, MAX_NEIGHBOURS):
        one = np.flatnonzero(vertex[:-shift] == vertex[shift:])
        if not len(one):
            break
        other = one + shift
        cosine = (unit[face[one]] * unit[face[other]]).sum(1)
        is_smooth = cosine > np.cos(np.deg2rad(CREASE_DEG))
        one, other = one[is_smooth], other[is_smooth]
        sums[one] += by_area[face[other]]
        sums[other] += by_area[face[one]]
    normals = np.empty_like(sums)
    normals[order] = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    return normals.reshape(-1, 3, 3)
