"""The colour of what the rays of a picture meet: texture, light, highlights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import floor, log2, sqrt
from typing import NamedTuple, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt
from numba import njit

from curiosight.worlds.rooms.lighting import LitMesh
from curiosight.worlds.rooms.mesh import Floats, Mesh
from curiosight.worlds.rooms.mipmaps import LINEAR_OF_SRGB, N_LEVELS, Mipmaps
from curiosight.worlds.rooms.scene import Light
from curiosight.worlds.rooms.tracing import Hits

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")
Triple = tuple[float, float, float]

# Share of light that a polished surface mirrors when seen straight on.
BASE_REFLECTANCE = 0.04
# A pixel's footprint on a slanted surface is long: take this cosine at least.
SMALLEST_COSINE = 0.02


class Surfaces(NamedTuple):
    """What a mesh is made of, as the kernel reads it.

    triangles: (L, 3) vertices, and first_child (L,): see LightMesh. vertices: (P, 12) normal,
    uv, direct light, indirect light, share of the direct light that is not in shadow.
    Of each of the mesh's T own triangles: face_normals (T, 3) unit; material (T,);
    texel_density (T,), texels of the finest level per metre.
    materials: (M, 5) tile in u and v, gloss, sharpness, emission.
    """

    triangles: npt.NDArray[np.int32]
    first_child: npt.NDArray[np.int32]
    vertices: Floats
    face_normals: Floats
    material: npt.NDArray[np.int32]
    texel_density: Floats
    materials: Floats


class Rays(NamedTuple):
    """Rays of one picture: origin (3,); directions (N, 3), of length 1 along the camera's z.

    pixel_angle: width of a pixel at distance 1.
    """

    origin: Floats
    directions: Floats
    pixel_angle: float


class Picture(NamedTuple):
    """What to fill: radiance (N, 3), and the cosine (N,) between ray and face normal."""

    radiance: Floats
    cosine: Floats


def surfaces(mesh: Mesh, lit: LitMesh) -> Surfaces:
    """Gather what the kernel reads of a mesh and its light."""
    corners, uv = mesh.vertices[mesh.triangles], mesh.uv[mesh.triangles]
    edges, uv_edges = corners[:, 1:] - corners[:, :1], uv[:, 1:] - uv[:, :1]
    normals = np.cross(edges[:, 0], edges[:, 1])
    area = np.maximum(np.linalg.norm(normals, axis=1), np.float32(1e-12))
    texels_per_uv = np.array(
        [np.prod(m.texture.shape[:2]) / np.prod(m.tile) for m in mesh.materials]
    )
    n_texels = np.abs(np.linalg.det(uv_edges)) * texels_per_uv[mesh.surface]
    columns = [(*m.tile, m.gloss, m.sharpness, m.emission) for m in mesh.materials]
    fine = lit.mesh
    return Surfaces(
        fine.triangles,
        fine.first_child,
        np.column_stack([fine.normals, fine.uv, lit.light]).astype(np.float32),
        normals / area[:, None],
        mesh.surface,
        np.sqrt(n_texels / area).astype(np.float32),
        np.array(columns, np.float32),
    )


def light_table(lights: Sequence[Light]) -> Floats:
    """Return (N, 10) of each light: centre, unit normal, radiance, area."""
    rows = []
    for light in lights:
        normal = np.cross(light.along, light.across)
        area = float(np.linalg.norm(normal))
        rows.append([*light.centre, *(normal / area), *light.rgb, area])
    return np.array(rows, np.float32).reshape(-1, 10)


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function; a division by zero gives infinity as in NumPy."""
    compiled: Callable[Parameters, Result] = njit(cache=True, nogil=True, error_model="numpy")(
        function
    )
    return compiled


@kernel
def bilinear(mipmaps: Mipmaps, material: int, level: int, s: float, t: float) -> Triple:
    """Return the linear colour at (s, t), in repeats of the texture, at one level."""
    width, height = mipmaps.width[material, level], mipmaps.height[material, level]
    x, y = (s - floor(s)) * width - 0.5, (t - floor(t)) * height - 0.5
    left, top = floor(x), floor(y)
    share_x, share_y = x - left, y - top
    red, green, blue = 0.0, 0.0, 0.0
    for down in range(2):
        row = top + down
        row = row + height if row < 0 else row - height if row >= height else row
        for right in range(2):
            column = left + right
            column = column + width if column < 0 else column - width if column >= width else column
            share = (share_y if down else 1 - share_y) * (share_x if right else 1 - share_x)
            texel = mipmaps.texels[mipmaps.start[material, level] + row * width + column]
            red += share * LINEAR_OF_SRGB[texel[0]]
            green += share * LINEAR_OF_SRGB[texel[1]]
            blue += share * LINEAR_OF_SRGB[texel[2]]
    return red, green, blue


@kernel
def trilinear(mipmaps: Mipmaps, material: int, n_texels: float, s: float, t: float) -> Triple:
    """Return the linear colour around (s, t) for a pixel that is `n_texels` wide there."""
    level = min(log2(max(n_texels, 1.0)), N_LEVELS - 1.0)
    finer = int(level)
    red, green, blue = bilinear(mipmaps, material, finer, s, t)
    mix = level - finer
    if mix > 0:
        r, g, b = bilinear(mipmaps, material, finer + 1, s, t)
        red, green, blue = red + mix * (r - red), green + mix * (g - green), blue + mix * (b - blue)
    return red, green, blue


@kernel
def leaf(surfaces: Surfaces, triangle: int, second: float, third: float) -> Triple:
    """Return the uncut triangle around a place in one, and the place's weights there."""
    while surfaces.first_child[triangle] >= 0:
        triangle = surfaces.first_child[triangle]
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
def dot(a: Triple, b: Triple) -> float:
    """Return the product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def scaled(vector: Triple, length: float) -> Triple:
    """Return the vector at another length."""
    factor = length / sqrt(dot(vector, vector))
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


@kernel
def highlight(light: Floats, point: Triple, normal: Triple, view: Triple, sharpness: float) -> float:
    """Return how much of a light's radiance a polished surface mirrors (Blinn and Phong)."""
    offset = (light[0] - point[0], light[1] - point[1], light[2] - point[2])
    towards = scaled(offset, 1.0)
    leaving = -dot(towards, (light[3], light[4], light[5]))
    arriving = dot(towards, normal)
    if leaving <= 0 or arriving <= 0:
        return 0.0
    half = scaled((towards[0] + view[0], towards[1] + view[1], towards[2] + view[2]), 1.0)
    seen = light[9] * leaving * arriving / (np.pi * dot(offset, offset) + light[9])
    peak = BASE_REFLECTANCE * (sharpness + 8) / 8
    return peak * max(dot(half, normal), 0.0) ** sharpness * seen


@kernel
def shade(
    hits: Hits, rays: Rays, surfaces: Surfaces, mipmaps: Mipmaps, lights: Floats, picture: Picture
) -> None:
    """Fill the picture where the rays hit something; it stays as it is elsewhere."""
    values = np.empty(surfaces.vertices.shape[1])
    for ray in range(len(hits.triangle)):
        triangle = hits.triangle[ray]
        if triangle < 0:
            continue
        small, second, third = leaf(surfaces, triangle, hits.second[ray], hits.third[ray])
        a, b, c = surfaces.triangles[small]
        for k in range(len(values)):
            values[k] = (
                (1 - second - third) * surfaces.vertices[a, k]
                + second * surfaces.vertices[b, k]
                + third * surfaces.vertices[c, k]
            )
        x, y, z = rays.directions[ray]
        view = scaled((-x, -y, -z), 1.0)
        nx, ny, nz = surfaces.face_normals[triangle]
        facing = dot(view, (nx, ny, nz))
        picture.cosine[ray] = abs(facing)
        material = surfaces.material[triangle]
        tile_u, tile_v, gloss, sharpness, emission = surfaces.materials[material]
        distance = hits.distance[ray]
        slant = sqrt(max(abs(facing), SMALLEST_COSINE))
        n_texels = distance * rays.pixel_angle * surfaces.texel_density[triangle] / slant
        colour = trilinear(mipmaps, material, n_texels, values[3] / tile_u, values[4] / tile_v)
        for k in range(3):
            picture.radiance[ray, k] = colour[k] * (values[5 + k] + values[8 + k] + emission)
        if gloss == 0:
            continue
        normal = scaled((values[0], values[1], values[2]), 1.0 if facing > 0 else -1.0)
        grazing = 1 - min(max(dot(normal, view), 0.0), 1.0)
        mirrored = gloss * (BASE_REFLECTANCE + (1 - BASE_REFLECTANCE) * grazing**5)
        for k in range(3):
            picture.radiance[ray, k] += mirrored * values[8 + k]
        point = (
            rays.origin[0] + distance * x, rays.origin[1] + distance * y, rays.origin[2] + distance * z
        )
        for light in lights:
            strength = gloss * values[11] * highlight(light, point, normal, view, sharpness)
            for k in range(3):
                picture.radiance[ray, k] += strength * light[6 + k]
