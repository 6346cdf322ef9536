"""Turned bodies and rods, each a mesh of one material; metres, z up.

uv and `fit` are as in `shapes`.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from curiosight.rooms.mesh import Material, Mesh, join
from curiosight.rooms.surfaces import (
    Points,
    even_steps,
    grid,
    polygon,
    unit,
    upright,
    warped,
)

# A profile that turns by more than this has an edge there; less is a round body's facets.
CREASE = np.deg2rad(40.0)


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
    outline = np.asarray(profile, np.float64)
    if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 2 or outline[:, 0].min() < 0:
        raise ValueError(
            "profile: expected (N, 2) of radius >= 0 and height, N >= 2, "
            f"got {outline.shape} from {outline.min()}"
        )
    points = _refined(outline, spacing)
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
    for first, last in pairwise(ends):
        part = points[first : last + 1]
        normals = _profile_normals(part, sides[first:last])
        uv = upright(u, v[first : last + 1])
        runs.append(grid(_swept(part, angles), _swept(normals, angles), uv, material))
    return join(runs)


def cylinder(
    radius: float,
    height: float,
    material: Material,
    *,
    top_radius: float | None = None,
    n_around: int = 24,
    spacing: float = 0.05,
    lift: float = 0.0,
) -> Mesh:
    """Return a closed upright cylinder, or a cone frustum; uv in metres."""
    top = radius if top_radius is None else top_radius
    profile = [(0.0, lift), (radius, lift), (top, lift + height), (0.0, lift + height)]
    return lathe(profile, material, n_around=n_around, spacing=spacing, fit=False)


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
    spacing: float = 0.08,
    closed: bool = False,
) -> Mesh:
    """Return a round rod along a path, (N, 3); its flat ends are covered; uv in metres.

    radius: metres, one or one per point of the path.
    closed: the path, in a plane, returns to its start, as a ring does.
    """
    corners = np.asarray(path, np.float64)
    widths = np.broadcast_to(np.asarray(radius, np.float64), len(corners))
    course = np.column_stack([corners, widths])
    if closed:
        course = np.concatenate([course, course[:1]])
    course = _refined(course, spacing)
    points, radii = course[:, :3], course[:, 3]
    tangents, first, second = _carried_frames(points, closed)
    angles = np.linspace(0, 2 * np.pi, n_around + 1)
    cos, sin = np.cos(angles)[None, :, None], np.sin(angles)[None, :, None]
    outwards = cos * first[:, None] + sin * second[:, None]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    taper = np.gradient(radii, travelled)[:, None, None]
    surface = points[:, None] + radii[:, None, None] * outwards
    uv = upright(angles * radii.max(), travelled)
    side = grid(surface, unit(outwards - taper * tangents[:, None]), uv, material)
    if closed:
        return side
    fan = np.array([(0, i, i + 1) for i in range(1, n_around - 1)])
    start = polygon(surface[0, :-1], fan[:, ::-1], material)
    return join([side, start, polygon(surface[-1, :-1], fan, material)])


def ring(
    radius: float, thickness: float, material: Material, *, n_around: int = 24, n_rod: int = 8
) -> Mesh:
    """Return a torus about the z axis at z = 0; thickness: radius of its rod."""
    angles = np.arange(n_around) * 2 * np.pi / n_around
    path = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)
    return tube(path, thickness, material, n_around=n_rod, closed=True)


def _refined(profile: Points, spacing: float) -> Points:
    """Return (N, K) points with more of them between, none further apart than the spacing."""
    parts = [
        start + even_steps(float(np.linalg.norm(end - start)), spacing)[:-1, None] * (end - start)
        for start, end in pairwise(profile)
    ]
    return np.concatenate([*parts, profile[-1:]])


def _swept(profile: Points, angles: Points) -> Points:
    """Turn (N, 2) radius and height to (N, A, 3) points."""
    radius, height = profile[:, :1], np.broadcast_to(profile[:, 1:], (len(profile), len(angles)))
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), height], -1)


def _profile_normals(points: Points, sides: Points) -> Points:
    normals = np.concatenate([sides[:1], sides]) + np.concatenate([sides, sides[-1:]])
    # A smooth body is level at its poles.
    is_pole = (points[:, 0] < 1e-9) & (np.abs(normals[:, 1]) > np.abs(normals[:, 0]))
    normals[is_pole, 0] = 0.0
    return unit(normals)


def _carried_frames(points: Points, closed: bool) -> tuple[Points, Points, Points]:
    """Return tangents and two directions across them, (N, 3) each, without needless twist."""
    if closed:
        around = np.concatenate([points[-2:-1], points, points[1:2]])
        tangents = unit(around[2:] - around[:-2])
    else:
        tangents = unit(np.gradient(points, axis=0))
    first = np.empty_like(tangents)
    away = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    for i, tangent in enumerate(tangents):
        away = unit(away - (away @ tangent) * tangent)
        first[i] = away
    if closed:
        first[-1] = first[0]
    return tangents, first, np.cross(tangents, first)
