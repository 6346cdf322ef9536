"""Simple bodies and surfaces, each a mesh of one material; metres, z up.

Where nothing else is said, uv are metres along the surface and pictures stand upright: seen
from outside, u runs to the right and v downwards. With `fit` the whole texture covers the
face once: uv run from 0 to 1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.worlds.rooms.mesh import Floats, Material, Mesh, join

Points = npt.NDArray[np.floating[Any]]
Face = tuple[Points, Points, Points]

# A profile that turns by more than this has an edge there; less is a round body's facets.
CREASE = np.deg2rad(40.0)


def panel(
    origin: npt.ArrayLike,
    along: npt.ArrayLike,
    across: npt.ArrayLike,
    material: Material,
    *,
    spacing: float = 0.08,
    fit: bool = False,
) -> Mesh:
    """Return a parallelogram that looks to the side of along × across, all (3,).

    u counts from `origin`, v from the edge at origin + across: with `along` to the viewer's
    right and `across` upwards a picture stands upright.
    spacing: greatest distance of its vertices.
    """
    start, right, up = (np.asarray(vector, np.float64) for vector in (origin, along, across))
    width, height = np.linalg.norm(right), np.linalg.norm(up)
    u, v = _steps(width, spacing), _steps(height, spacing)
    points = start + u[None, :, None] * right + v[:, None, None] * up
    normal = np.cross(right, up)
    normals = np.broadcast_to(normal / np.linalg.norm(normal), points.shape)
    scale = (1.0, 1.0) if fit else (width, height)
    return grid(points, normals, _upright(u * scale[0], (1 - v) * scale[1]), material)


def box_faces(size: tuple[float, float, float], lift: float = 0.0) -> tuple[Face, ...]:
    """Return origin, along and across of a box's front, back, right, left, top and bottom.

    size: (width, depth, height) along x, y, z; the front looks to -y. It stands on z = `lift`.
    """
    x, y, z = np.diag(np.asarray(size, np.float64))
    low = -(x + y) / 2 + [0, 0, lift]
    return (
        (low, x, z),
        (low + x + y, -x, z),
        (low + x, y, z),
        (low + y, -y, z),
        (low + z, x, y),
        (low + y, x, -y),
    )


def box(
    size: tuple[float, float, float],
    material: Material,
    *,
    spacing: float = 0.08,
    fit: bool = False,
    lift: float = 0.0,
) -> Mesh:
    """Return a box (width, depth, height) that stands on z = `lift`, centred in x and y."""
    return join(
        [panel(*face, material, spacing=spacing, fit=fit) for face in box_faces(size, lift)]
    )


def rounded_box(
    size: tuple[float, float, float],
    radius: float,
    material: Material,
    *,
    n_bevel: int = 2,
    spacing: float = 0.08,
    fit: bool = False,
    lift: float = 0.0,
) -> Mesh:
    """Return a box with round edges of `n_bevel` facets to 45 degrees, else as `box`."""
    if not 0 < 2 * radius <= min(size) * (1 + 1e-9):
        raise ValueError(f"radius: expected above 0 and at most half of {size}, got {radius}")
    half = np.asarray(size, np.float64) / 2
    centre = np.array([0, 0, lift + half[2]])
    meshes = []
    for origin, along, across in box_faces(size, lift):
        width, height = np.linalg.norm(along), np.linalg.norm(across)
        u = _bevelled_steps(width, radius, n_bevel, spacing)
        v = _bevelled_steps(height, radius, n_bevel, spacing)
        corner = origin + u[None, :, None] * along + v[:, None, None] * across - centre
        core = np.clip(corner, radius - half, half - radius)
        normals = _unit(corner - core)
        scale = (1.0, 1.0) if fit else (width, height)
        uv = _upright(u * scale[0], (1 - v) * scale[1])
        meshes.append(grid(centre + core + radius * normals, normals, uv, material))
    return join(meshes)


def lathe(
    profile: npt.ArrayLike,
    material: Material,
    *,
    n_around: int = 32,
    spacing: float = 0.05,
    fit: bool = True,
) -> Mesh:
    """Return the body that a profile sweeps round the z axis.

    profile: (N, 2) radius and height, from the bottom to the top with the outside on its
        right hand: up the outside of a cup, over the brim, down the inside.
    fit: u goes once around, v from the profile's end to its start by its length; else metres,
        u at the widest place.

    The surface is smooth but for creases where the profile turns by more than 40 degrees.
    """
    points = _refined(np.asarray(profile, np.float64), spacing)
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    sides = np.stack([steps[:, 1], -steps[:, 0]], 1) / lengths[:, None]
    remaining = lengths.sum() - np.concatenate([[0.0], np.cumsum(lengths)])
    turns = np.einsum("ni,ni->n", sides[:-1], sides[1:]) < np.cos(CREASE)
    ends = [0, *(np.flatnonzero(turns) + 1), len(sides)]
    angles = np.linspace(0, 2 * np.pi, n_around + 1)
    u = angles / (2 * np.pi) if fit else angles * points[:, 0].max()
    v = remaining / lengths.sum() if fit else remaining
    runs = []
    for first, last in zip(ends[:-1], ends[1:], strict=True):
        part = points[first : last + 1]
        normals = _profile_normals(part, sides[first:last])
        uv = _upright(u, v[first : last + 1])
        runs.append(grid(_swept(part, angles), _swept(normals, angles), uv, material))
    return join(runs)


def cylinder(
    radius: float,
    height: float,
    material: Material,
    *,
    top_radius: float | None = None,
    n_around: int = 24,
    lift: float = 0.0,
) -> Mesh:
    """Return a closed upright cylinder, or a cone frustum; uv in metres."""
    top = radius if top_radius is None else top_radius
    profile = [(0.0, lift), (radius, lift), (top, lift + height), (0.0, lift + height)]
    return lathe(profile, material, n_around=n_around, fit=False)


def ellipsoid(
    radii: tuple[float, float, float],
    material: Material,
    *,
    n_around: int = 24,
    lift: float = 0.0,
) -> Mesh:
    """Return an ellipsoid that stands on z = `lift`; the texture covers it once."""
    latitudes = np.linspace(-np.pi / 2, np.pi / 2, n_around // 2 + 1)
    radius = np.cos(latitudes)
    radius[[0, -1]] = 0.0
    profile = np.stack([radius, np.sin(latitudes)], 1)
    ball = lathe(profile, material, n_around=n_around, spacing=np.inf)
    return warped(ball, lambda points: points * radii + [0, 0, radii[2] + lift])


def tube(
    path: npt.ArrayLike,
    radius: float | npt.ArrayLike,
    material: Material,
    *,
    n_around: int = 10,
    closed: bool = False,
) -> Mesh:
    """Return a round rod along a path, (N, 3); its flat ends are covered; uv in metres.

    radius: metres, one or one per point of the path.
    closed: the path returns to its start, as a ring does.
    """
    points = np.asarray(path, np.float64)
    if closed:
        points = np.concatenate([points, points[:1]])
    radii = np.broadcast_to(np.asarray(radius, np.float64), len(points))
    tangents, first, second = _carried_frames(points, closed)
    angles = np.linspace(0, 2 * np.pi, n_around + 1)
    cos, sin = np.cos(angles)[None, :, None], np.sin(angles)[None, :, None]
    outwards = cos * first[:, None] + sin * second[:, None]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    taper = np.gradient(radii, travelled)[:, None, None]
    surface = points[:, None] + radii[:, None, None] * outwards
    uv = _upright(angles * radii.max(), travelled)
    side = grid(surface, _unit(outwards - taper * tangents[:, None]), uv, material)
    if closed:
        return side
    return join([side, _cap(surface[0], -tangents[0], material), _cap(surface[-1], tangents[-1], material)])


def ring(radius: float, thickness: float, material: Material, *, n_around: int = 24) -> Mesh:
    """Return a torus about the z axis at z = 0; thickness: radius of its rod."""
    angles = np.arange(n_around) * 2 * np.pi / n_around
    path = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)
    return tube(path, thickness, material, n_around=8, closed=True)


def disc(
    radius: float, material: Material, *, n_around: int = 24, lift: float = 0.0, fit: bool = False
) -> Mesh:
    """Return a round plate of no thickness that looks up; uv as of the square around it."""
    plate = lathe([(radius, lift), (0.0, lift)], material, n_around=n_around)
    return _flat_uv(plate, radius, fit)


def extrude(
    outline: npt.ArrayLike, height: float, material: Material, *, lift: float = 0.0
) -> Mesh:
    """Return an upright prism; uv in metres.

    outline: (N, 2) x and y, counter-clockwise, simple, not closed.
    """
    corners = np.asarray(outline, np.float64)
    following = np.roll(corners, -1, axis=0)
    up = np.array([0, 0, height])
    sides = [
        panel((*start, lift), (*(end - start), 0.0), up, material)
        for start, end in zip(corners, following, strict=True)
    ]
    ears = _ears(corners)
    top = np.column_stack([corners, np.full(len(corners), lift + height)])
    lids = [_flat(top, ears, material), _flat(top - up, ears[:, ::-1], material)]
    return join([*sides, *lids])


def sheet(points: Points, material: Material) -> Mesh:
    """Return a bent surface through a grid of points, (R, C, 3), with smooth normals.

    It looks to the side of (along a row) × (to the next row). The texture covers it once,
    upright where rows go upwards.
    """
    normals = _unit(np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0)))
    u, v = np.linspace(0, 1, points.shape[1]), np.linspace(1, 0, points.shape[0])
    return grid(points, normals, _upright(u, v), material)


def grid(points: Points, normals: Points, uv: Points, material: Material) -> Mesh:
    """Return a surface through a grid: points and normals (R, C, 3), uv (R, C, 2).

    It looks to the side of (along a row) × (to the next row); triangles without area, as at
    a pole, are left out.
    """
    rows, columns = points.shape[:2]
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    return _mesh(points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), triangles, material)


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
        _unit(normals).astype(np.float32),
        mesh.uv,
        np.ascontiguousarray(triangles),
        mesh.surface,
        mesh.materials,
    )


def turned(axis: npt.ArrayLike, angle: float, at: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Pose:
    """Return the motion that turns by radians about an axis through 0, then shifts by `at`."""
    x, y, z = _unit(np.asarray(axis, np.float64))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    pose[:3, 3] = at
    return pose


def _mesh(points: Points, normals: Points, uv: Points, triangles: Points, material: Material) -> Mesh:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept = triangles[areas > 1e-12].astype(np.int32)
    return Mesh(
        points.astype(np.float32),
        normals.astype(np.float32),
        uv.astype(np.float32),
        kept,
        np.zeros(len(kept), np.int32),
        (material,),
    )
