"""Plates, boxes and prisms, each a mesh of one material; metres, z up.

Where nothing else is said, uv are metres along the surface and pictures stand upright: seen
from outside, u runs to the right and v downwards. With `fit` the whole texture covers the
face once: uv run from 0 to 1.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.rooms.mesh import Material, Mesh, join
from curiosight.rooms.surfaces import Points, ears, even_steps, grid, polygon, unit, upright

Face = tuple[Points, Points, Points]


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
    normal = np.cross(right, up)
    if not normal.any():
        raise ValueError(f"along, across: expected two directions, got {along!r} and {across!r}")
    width, height = float(np.linalg.norm(right)), float(np.linalg.norm(up))
    u, v = even_steps(width, spacing), even_steps(height, spacing)
    points = start + u[None, :, None] * right + v[:, None, None] * up
    normals = np.broadcast_to(unit(normal), points.shape)
    scale = (1.0, 1.0) if fit else (width, height)
    return grid(points, normals, upright(u * scale[0], (1 - v) * scale[1]), material)


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
        width, height = float(np.linalg.norm(along)), float(np.linalg.norm(across))
        u = _bevelled_steps(width, radius, n_bevel, spacing)
        v = _bevelled_steps(height, radius, n_bevel, spacing)
        corner = origin + u[None, :, None] * along + v[:, None, None] * across - centre
        core = np.clip(corner, radius - half, half - radius)
        normals = unit(corner - core)
        scale = (1.0, 1.0) if fit else (width, height)
        uv = upright(u * scale[0], (1 - v) * scale[1])
        meshes.append(grid(centre + core + radius * normals, normals, uv, material))
    return join(meshes)


def disc(
    radius: float, material: Material, *, n_around: int = 24, lift: float = 0.0, fit: bool = False
) -> Mesh:
    """Return a round plate of no thickness that looks up; uv as of the square around it."""
    angles = np.linspace(0, 2 * np.pi, n_around + 1)
    rings = np.linspace(radius, 0, max(2, round(radius / 0.03) + 1))
    circle = np.stack([np.cos(angles), np.sin(angles)], 1)
    plane = rings[:, None, None] * circle
    points = np.concatenate([plane, np.full((*plane.shape[:2], 1), lift)], 2)
    uv = (plane + radius) * [1, -1] + [0, 2 * radius]
    normals = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    return grid(points, normals, uv / (2 * radius) if fit else uv, material)


def extrude(
    outline: npt.ArrayLike, height: float, material: Material, *, lift: float = 0.0
) -> Mesh:
    """Return an upright prism; uv in metres.

    outline: (N, 2) x and y, counter-clockwise, simple, not closed.
    """
    corners = np.asarray(outline, np.float64)
    if _signed_area(corners) <= 0:
        raise ValueError("outline: expected corners counter-clockwise, got them clockwise")
    following = np.roll(corners, -1, axis=0)
    up = np.array([0, 0, height])
    sides = [
        panel((*start, lift), (*(end - start), 0.0), up, material)
        for start, end in zip(corners, following, strict=True)
    ]
    triangles = ears(corners)
    top = np.column_stack([corners, np.full(len(corners), lift + height)])
    lids = [polygon(top, triangles, material), polygon(top - up, triangles[:, ::-1], material)]
    return join([*sides, *lids])


def _signed_area(outline: Points) -> float:
    x, y = outline.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)


def _bevelled_steps(length: float, radius: float, n_bevel: int, spacing: float) -> Points:
    # Equal angles of the round edge, from the face's border at 45 degrees to where it is flat.
    edge = radius * (1 - np.tan(np.linspace(np.pi / 4, 0, n_bevel + 1)))
    flat = radius + (length - 2 * radius) * even_steps(length - 2 * radius, spacing)
    return np.unique(np.concatenate([edge, flat, length - edge]).round(9)) / length
