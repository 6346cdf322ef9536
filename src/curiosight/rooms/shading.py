"""The colour of what the rays of a picture meet: texture, light, gloss."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.rooms.compiling import kernel
from curiosight.rooms.lighting import LitMesh
from curiosight.rooms.mesh import Floats, Mesh
from curiosight.rooms.mipmaps import Mipmaps, trilinear
from curiosight.rooms.scene import Light
from curiosight.rooms.tracing import Hits
from curiosight.rooms.vectors import Triple, dot, scaled

Indices = npt.NDArray[np.int32]

# Share of light that a polished surface mirrors when seen straight on.
BASE_REFLECTANCE = 0.04
# A pixel's footprint on a slanted surface is long: take this cosine at least.
SMALLEST_COSINE = 0.02
# A highlight that has faded to exp(-LARGEST_EXPONENT) of its peak is over.
LARGEST_EXPONENT = 12.0
# Columns of Surfaces.vertices and of Surfaces.materials.
UV, DIRECT, INDIRECT, UNSHADOWED, NORMAL = 0, 2, 5, 8, 9
TILE, EMISSION, GLOSS, SHARPNESS = 0, 2, 3, 4


class Surfaces(NamedTuple):
    """What a mesh is made of, as the kernels read it.

    triangles: (L, 3) vertices, and first_child (L,): see LightMesh. vertices: (P, 12) uv,
    direct light, indirect light, share of the direct light that is not in shadow, normal.
    Of each of the mesh's T own triangles: face_normals (T, 3) unit; material (T,);
    texel_density (T,), texels of the finest level per metre.
    materials: (M, 5) tile in u and v, emission, gloss, sharpness.
    """

    triangles: Indices
    first_child: Indices
    vertices: Floats
    face_normals: Floats
    material: Indices
    texel_density: Floats
    materials: Floats


class Rays(NamedTuple):
    """Rays of one picture: origin (3,); directions (N, 3), of length 1 along the camera's z.

    pixel_angle: width of a pixel at distance 1.
    """

    origin: Floats
    directions: Floats
    pixel_angle: float


def surfaces(mesh: Mesh, lit: LitMesh) -> Surfaces:
    """Gather what the kernels read of a mesh and its light."""
    corners, uv = mesh.vertices[mesh.triangles], mesh.uv[mesh.triangles]
    edges, uv_edges = corners[:, 1:] - corners[:, :1], uv[:, 1:] - uv[:, :1]
    normals = np.cross(edges[:, 0], edges[:, 1])
    area = np.maximum(np.linalg.norm(normals, axis=1), np.float32(1e-12))
    texels_per_uv = [np.prod(m.texture.shape[:2]) / np.prod(m.tile) for m in mesh.materials]
    n_texels = np.abs(np.linalg.det(uv_edges)) * np.array(texels_per_uv)[mesh.surface]
    materials = [(*m.tile, m.emission, m.gloss, m.sharpness) for m in mesh.materials]
    fine = lit.mesh
    columns = [fine.uv, lit.direct, lit.indirect, lit.unshadowed, fine.normals]
    return Surfaces(
        fine.triangles,
        fine.first_child,
        np.column_stack(columns).astype(np.float32),
        normals / area[:, None],
        mesh.surface,
        np.sqrt(n_texels / area).astype(np.float32),
        np.array(materials, np.float32),
    )


def light_table(lights: Sequence[Light]) -> Floats:
    """Return (N, 10) of each light: centre, unit normal, radiance, area."""
    rows = []
    for light in lights:
        normal = np.cross(light.along, light.across)
        area = float(np.linalg.norm(normal))
        rows.append([*light.centre, *(normal / area), *light.rgb, area])
    return np.array(rows, np.float32).reshape(-1, 10)


@kernel
def leaf(
    first_child: Indices, triangle: int, second: float, third: float
) -> tuple[int, float, float]:
    """Return the uncut triangle around a place in one, and the place's weights there."""
    while first_child[triangle] >= 0:
        triangle = first_child[triangle]
        if second + third < 0.5:
            second, third = 2 * second, 2 * third
        elif second > 0.5:
            triangle, second, third = triangle + 1, 2 * second - 1, 2 * third
        elif third > 0.5:
            triangle, second, third = triangle + 2, 2 * second, 2 * third - 1
        else:
            triangle, second, third = triangle + 3, 1 - 2 * second, 1 - 2 * third
    return triangle, second, third


@kernel
def interpolated(
    vertices: Floats, corners: tuple[int, int, int], second: float, third: float, column: int
) -> Triple:
    """Return three columns of the vertices' table at a place in a triangle."""
    a, b, c = corners
    first = 1 - second - third
    return (
        first * vertices[a, column] + second * vertices[b, column] + third * vertices[c, column],
        first * vertices[a, column + 1]
        + second * vertices[b, column + 1]
        + third * vertices[c, column + 1],
        first * vertices[a, column + 2]
        + second * vertices[b, column + 2]
        + third * vertices[c, column + 2],
    )


@kernel
def paint(
    hits: Hits,
    rays: Rays,
    surfaces: Surfaces,
    mipmaps: Mipmaps,
    radiance: Floats,
    cosine: Floats,
) -> None:
    """Fill (N, 3) `radiance` with matt colours, (N,) `cosine` with how straight each is seen.

    What no ray meets stays as it is.
    """
    # Arrays are taken out of their tuples first: Numba counts each use of one.
    triangles, first_child, vertices, normals, material_of, density, materials = surfaces
    triangle_of, second_of, third_of, distance_of = hits
    _, directions, pixel_angle = rays
    texels, places = mipmaps
    for ray in range(len(triangle_of)):
        hit = triangle_of[ray]
        if hit < 0:
            continue
        small, second, third = leaf(first_child, hit, second_of[ray], third_of[ray])
        corners = (triangles[small, 0], triangles[small, 1], triangles[small, 2])
        towards = scaled((directions[ray, 0], directions[ray, 1], directions[ray, 2]), 1.0)
        facing = abs(dot(towards, (normals[hit, 0], normals[hit, 1], normals[hit, 2])))
        material = material_of[hit]
        slant = sqrt(max(facing, SMALLEST_COSINE))
        n_texels = distance_of[ray] * pixel_angle * density[hit] / slant
        u, v, _ = interpolated(vertices, corners, second, third, UV)
        s, t = u / materials[material, TILE], v / materials[material, TILE + 1]
        colour = trilinear(texels, places[material], n_texels, s, t)
        direct = interpolated(vertices, corners, second, third, DIRECT)
        indirect = interpolated(vertices, corners, second, third, INDIRECT)
        for k in range(3):
            light = direct[k] + indirect[k] + materials[material, EMISSION]
            radiance[ray, k] = colour[k] * light
        cosine[ray] = facing


@kernel
def polish(hits: Hits, rays: Rays, surfaces: Surfaces, lights: Floats, radiance: Floats) -> None:
    """Add what glossy surfaces mirror: the lights, and faintly what light is around."""
    triangles, first_child, vertices, normals, material_of, _, materials = surfaces
    triangle_of, second_of, third_of, distance_of = hits
    origin, directions, _ = rays
    for ray in range(len(triangle_of)):
        hit = triangle_of[ray]
        gloss = materials[material_of[hit], GLOSS] if hit >= 0 else 0
        if gloss == 0:
            continue
        small, second, third = leaf(first_child, hit, second_of[ray], third_of[ray])
        corners = (triangles[small, 0], triangles[small, 1], triangles[small, 2])
        x, y, z = directions[ray, 0], directions[ray, 1], directions[ray, 2]
        is_behind = dot((x, y, z), (normals[hit, 0], normals[hit, 1], normals[hit, 2])) > 0
        smooth = interpolated(vertices, corners, second, third, NORMAL)
        normal = scaled(smooth, -1.0 if is_behind else 1.0)
        view = scaled((-x, -y, -z), 1.0)
        cosine = min(max(dot(normal, view), 0.0), 1.0)
        reflectance = BASE_REFLECTANCE + (1 - BASE_REFLECTANCE) * (1 - cosine) ** 5
        indirect = interpolated(vertices, corners, second, third, INDIRECT)
        for k in range(3):
            radiance[ray, k] += gloss * reflectance * indirect[k]
        unshadowed, _, _ = interpolated(vertices, corners, second, third, UNSHADOWED)
        far = distance_of[ray]
        point = (origin[0] + far * x, origin[1] + far * y, origin[2] + far * z)
        mirrored = (
            2 * cosine * normal[0] - view[0],
            2 * cosine * normal[1] - view[1],
            2 * cosine * normal[2] - view[2],
        )
        sharpness = materials[material_of[hit], SHARPNESS]
        for light in range(len(lights)):
            share = highlight(lights, light, point, normal, mirrored, sharpness)
            if share > 0:
                for k in range(3):
                    radiance[ray, k] += gloss * unshadowed * share * lights[light, 6 + k]


@kernel
def highlight(
    lights: Floats, light: int, point: Triple, normal: Triple, mirrored: Triple, sharpness: float
) -> float:
    """Return how much of a light's radiance a polished surface sends to the view (Phong).

    mirrored: unit direction that the view is mirrored to.
    """
    x, y, z = lights[light, 0], lights[light, 1], lights[light, 2]
    offset = (x - point[0], y - point[1], z - point[2])
    along, squared = dot(offset, mirrored), dot(offset, offset)
    faded = 1 - LARGEST_EXPONENT / sharpness
    if along <= 0 or (faded > 0 and along**2 < faded**2 * squared):
        return 0.0
    leaving = -dot(offset, (lights[light, 3], lights[light, 4], lights[light, 5]))
    arriving = dot(offset, normal)
    if leaving <= 0 or arriving <= 0:
        return 0.0
    area = lights[light, 9]
    seen = area * leaving * arriving / (squared * (np.pi * squared + area))
    peak = BASE_REFLECTANCE * (sharpness + 2) / 2
    return float(peak * (along / sqrt(squared)) ** sharpness * seen)
