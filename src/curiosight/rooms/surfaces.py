"""Surfaces through points, and maps that bend them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.mesh import Material, Mesh

Points = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.integer[Any]]

SMALLEST_AREA = 1e-12


def sheet(points: Points, material: Material) -> Mesh:
    """Return a bent surface through a grid of points, (R, C, 3), with smooth normals.

    It looks to the side of (along a row) × (to the next row). The texture covers it once,
    upright where rows go upwards.
    """
    normals = unit(np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0)))
    u, v = np.linspace(0, 1, points.shape[1]), np.linspace(1, 0, points.shape[0])
    return grid(points, normals, upright(u, v), material)


def grid(points: Points, normals: Points, uv: Points, material: Material) -> Mesh:
    """Return a surface through a grid: points and normals (R, C, 3), uv (R, C, 2).

    It looks to the side of (along a row) × (to the next row); triangles without area, as at
    a pole, are left out.
    """
    rows, columns = points.shape[:2]
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    return _mesh(
        points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), triangles, material
    )


def warped(mesh: Mesh, warp: Callable[[Points], Points]) -> Mesh:
    """Return the mesh after a smooth map of space, (V, 3) -> (V, 3), that keeps its creases."""
    points = mesh.vertices.astype(np.float64)
    step = 1e-5
    columns = [(warp(points + e) - warp(points - e)) / (2 * step) for e in step * np.eye(3)]
    a, b, c = columns
    # The cofactors carry normals; their sign follows the map's, so a mirror is noticed.
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], -1)
    orientation = np.sign(np.einsum("ni,ni->n", a, np.cross(b, c)))
    normals = np.einsum("nij,nj->ni", cofactors, mesh.normals) * orientation[:, None]
    triangles = mesh.triangles[:, ::-1] if orientation.sum() < 0 else mesh.triangles
    return Mesh(
        warp(points).astype(np.float32),
        unit(normals).astype(np.float32),
        mesh.uv,
        np.ascontiguousarray(triangles),
        mesh.surface,
        mesh.materials,
    )


def scaled(mesh: Mesh, factors: float | tuple[float, float, float]) -> Mesh:
    """Return the mesh stretched along x, y and z."""
    return warped(mesh, lambda points: points * np.asarray(factors))


def stretched(
    points: Points, x: Points | float = 1.0, y: Points | float = 1.0, z: Points | float = 1.0
) -> Points:
    """Return points, (V, 3), with each coordinate times a factor or its own factors, (V,)."""
    return np.stack([points[:, 0] * x, points[:, 1] * y, points[:, 2] * z], 1)


def arc(
    start: float,
    end: float,
    radii: tuple[float, float],
    centre: tuple[float, float] = (0.0, 0.0),
    n_points: int = 9,
) -> Points:
    """Return (N, 3) points of an ellipse in the x-z plane, from and to angles off x."""
    angles = np.linspace(start, end, n_points)
    x, z = centre[0] + radii[0] * np.cos(angles), centre[1] + radii[1] * np.sin(angles)
    return np.stack([x, np.zeros(n_points), z], 1)


def turned(axis: npt.ArrayLike, angle: float, at: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Pose:
    """Return the motion that turns by radians about an axis through 0, then shifts by `at`."""
    x, y, z = unit(np.asarray(axis, np.float64))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    pose[:3, 3] = at
    return pose


def polygon(corners: Points, triangles: Triangles, material: Material) -> Mesh:
    """Return a flat face: corners (N, 3), triangles (T, 3); uv are the corners' x and -y."""
    a, b, c = corners[triangles[0]]
    normals = np.broadcast_to(unit(np.cross(b - a, c - a)), corners.shape)
    return _mesh(corners, normals, corners[:, :2] * [1, -1], triangles, material)


def upright(u: Points, v: Points) -> Points:
    """Return the (R, C, 2) uv of a grid: v (R,) by its rows, u (C,) by its columns."""
    return np.stack(np.broadcast_arrays(u[None, :], v[:, None]), -1)


def unit(vectors: Points) -> Points:
    """Return vectors, (..., 3), at length one."""
    lengths: Points = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / lengths


def ears(outline: Points) -> Triangles:
    """Return the triangles of a simple counter-clockwise polygon, by clipping ears."""
    left = list(range(len(outline)))
    triangles = []
    while len(left) > 3:
        ear = next(i for i in range(len(left)) if _is_ear(outline, left, i))
        triangles.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return np.array([*triangles, left])


def _mesh(
    points: Points, normals: Points, uv: Points, triangles: Triangles, material: Material
) -> Mesh:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept = triangles[areas > SMALLEST_AREA].astype(np.int32)
    return Mesh(
        points.astype(np.float32),
        normals.astype(np.float32),
        uv.astype(np.float32),
        kept,
        np.zeros(len(kept), np.int32),
        (material,),
    )


def _is_ear(outline: Points, left: list[int], i: int) -> bool:
    corners = left[i - 1], left[i], left[(i + 1) % len(left)]
    a, b, c = outline[list(corners)]
    if _turn(a, b, c) <= 0:
        return False
    others = outline[[j for j in left if j not in corners]]
    inside = (_turn(a, b, others) >= 0) & (_turn(b, c, others) >= 0) & (_turn(c, a, others) >= 0)
    return not bool(inside.any())


def _turn(a: Points, b: Points, c: Points) -> Points:
    """Return twice the area of a, b, c: positive where they turn left; c is (2,) or (N, 2)."""
    turn: Points = (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])
    return turn


def even_steps(length: float, spacing: float) -> Points:
    """Return shares of a length from 0 to 1, none further apart than the spacing."""
    return np.linspace(0, 1, max(1, int(np.ceil(length / spacing - 1e-9))) + 1)
