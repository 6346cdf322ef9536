"""What the kernels make of textures, light and gloss, against plain arrays."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.rooms.light_mesh import cut, uncut
from curiosight.rooms.lighting import lit
from curiosight.rooms.mesh import Material, join
from curiosight.rooms.mipmaps import LINEAR_OF_SRGB, N_LEVELS, mipmaps, trilinear
from curiosight.rooms.renderer import Renderer
from curiosight.rooms.shading import Rays, leaf, light_table, paint, polish, surfaces
from curiosight.rooms.shapes import panel
from curiosight.rooms.tracing import RayCaster
from small_scenes import (
    CAMERA,
    WHITE,
    checks,
    furnished,
    ground,
    looking,
    scene_of,
)


def test_far_texture_is_even() -> None:
    board = panel((-40, 20, -30), (80, 0, 0), (0, 0, 60), checks(0.05, emission=1.0), spacing=5)
    radiance = Renderer(scene_of(board)).render(CAMERA, looking((0, 0, 0), (0, 1, 0))).radiance
    np.testing.assert_allclose(radiance, 0.5, atol=0.01)


def test_mipmaps_keep_the_mean_light() -> None:
    rng = np.random.default_rng(0)
    maps = mipmaps([Material(rng.integers(0, 256, (64, 32, 3), np.uint8)), WHITE])
    means = []
    for start, width, height in maps.places[0]:
        means.append(LINEAR_OF_SRGB[maps.texels[start : start + width * height]].mean(0))
    assert [tuple(place[1:]) for place in maps.places[0]][:3] == [(32, 64), (16, 32), (8, 16)]
    assert maps.places.shape == (2, N_LEVELS, 3)
    np.testing.assert_allclose(means, np.tile(means[0], (N_LEVELS, 1)), atol=0.01)


def reference_colour(material: Material, n_texels: float, s: float, t: float) -> np.ndarray:
    """Look a texture up with whole arrays."""
    maps = mipmaps([material])
    level = np.clip(np.log2(n_texels), 0, N_LEVELS - 1)
    levels = (int(level), min(int(level) + 1, N_LEVELS - 1))
    colours = []
    for number in levels:
        start, width, height = maps.places[0, number]
        texture = LINEAR_OF_SRGB[maps.texels[start : start + width * height]]
        texture = texture.reshape(height, width, 3).astype(float)
        x, y = s * width - 0.5, t * height - 0.5
        columns = np.array([np.floor(x), np.floor(x) + 1]).astype(int)
        rows = np.array([np.floor(y), np.floor(y) + 1]).astype(int)
        four = texture[np.ix_(rows % height, columns % width)]
        shares = np.outer([1 - y % 1, y % 1], [1 - x % 1, x % 1])
        colours.append(np.einsum("ij,ijk->k", shares, four))
    return colours[0] + (level - levels[0]) * (colours[1] - colours[0])


def test_texture_lookup_agrees_with_arrays() -> None:
    rng = np.random.default_rng(1)
    material = Material(rng.integers(0, 256, (12, 20, 3), np.uint8))
    maps = mipmaps([material])
    for _ in range(200):
        n_texels = 2 ** rng.uniform(-1, N_LEVELS)
        s, t = rng.uniform(-3, 3, 2)
        found = trilinear(maps.texels, maps.places[0], n_texels, s, t)
        np.testing.assert_allclose(found, reference_colour(material, n_texels, s, t), atol=1e-5)


def test_cut_triangles_cover_their_parent() -> None:
    rng = np.random.default_rng(2)
    mesh = uncut(ground(spacing=1.0))
    mesh = cut(mesh, np.array([0, 3, 5]))
    mesh = cut(mesh, np.arange(len(mesh.triangles) - 8, len(mesh.triangles)))
    assert len(mesh.leaves) == 32 + 3 * 3 + 3 * 8
    for triangle in range(8):
        second, third = np.sort(rng.random(2))
        weights = np.array([1 - third, second, third - second])
        small, b, c = leaf(mesh.first_child, triangle, weights[1], weights[2])
        assert mesh.first_child[small] < 0
        assert min(b, c, 1 - b - c) >= 0
        point = weights @ mesh.vertices[mesh.triangles[triangle]]
        found = np.array([1 - b - c, b, c]) @ mesh.vertices[mesh.triangles[small]]
        np.testing.assert_allclose(found, point, atol=1e-6)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def test_shading_agrees_with_arrays() -> None:
    scene = furnished()
    mesh = join([part.mesh for part in scene.parts])
    caster = RayCaster(mesh)
    light = lit(mesh, scene.lights, caster, seed=0)
    rng = np.random.default_rng(3)
    origin = np.float32([0.2, -2.5, 1.2])
    directions = rng.normal((0, 1, -0.2), 0.4, (300, 3)).astype(np.float32)
    hits = caster.hits(np.broadcast_to(origin, directions.shape), directions)
    radiance, cosine = np.zeros((300, 3), np.float32), np.zeros(300, np.float32)
    rays, table = Rays(origin, directions, 0.002), light_table(scene.lights)
    look = surfaces(mesh, light)
    paint(hits, rays, look, mipmaps(mesh.materials), radiance, cosine)
    polish(hits, rays, look, table, radiance)
    is_hit = hits.triangle >= 0
    assert 100 < is_hit.sum() < 300
    assert not radiance[~is_hit].any()
    for ray in np.flatnonzero(is_hit):
        hit = hits.triangle[ray]
        small, b, c = leaf(look.first_child, hit, hits.second[ray], hits.third[ray])
        row = np.array([1 - b - c, b, c]) @ look.vertices[look.triangles[small]]
        material = mesh.materials[mesh.surface[hit]]
        corners = mesh.vertices[mesh.triangles[hit]].astype(float)
        face = unit(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
        view = unit(-directions[ray].astype(float))
        assert cosine[ray] == pytest.approx(abs(view @ face), abs=1e-5)
        width = hits.distance[ray] * 0.002 * look.texel_density[hit] / np.sqrt(abs(view @ face))
        s, t = row[:2] / material.tile
        expected = reference_colour(material, width, s, t) * (row[2:5] + row[5:8])
        expected += reference_colour(material, width, s, t) * material.emission
        normal = unit(row[9:12]) * np.sign(view @ face)
        grazing = 1 - np.clip(normal @ view, 0, 1)
        expected += material.gloss * (0.04 + 0.96 * grazing**5) * row[5:8]
        point = origin + hits.distance[ray] * directions[ray].astype(float)
        for lamp_row, source in zip(table.astype(float), scene.lights, strict=True):
            offset = source.centre - point
            towards = unit(offset)
            leaving, arriving = max(-towards @ lamp_row[3:6], 0), max(towards @ normal, 0)
            seen = lamp_row[9] * leaving * arriving / (np.pi * offset @ offset + lamp_row[9])
            mirrored = 2 * (normal @ view) * normal - view
            peak = max(towards @ mirrored, 0) ** material.sharpness
            peak *= 0.04 * (material.sharpness + 2) / 2
            expected += material.gloss * row[8] * peak * seen * source.rgb
        np.testing.assert_allclose(radiance[ray], expected, rtol=2e-3, atol=1e-4)
