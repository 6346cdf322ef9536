"""Pictures of tiny rooms: what is where, how bright it is, and the same every time."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.frame import Camera
from curiosight.worlds.rooms.light_mesh import cut, uncut
from curiosight.worlds.rooms.light_rays import share_of_view
from curiosight.worlds.rooms.lighting import lit
from curiosight.worlds.rooms.mesh import Material, Mesh, join, standing
from curiosight.worlds.rooms.mipmaps import LINEAR_OF_SRGB, N_LEVELS, mipmaps, trilinear
from curiosight.worlds.rooms.renderer import Renderer, Rendering
from curiosight.worlds.rooms.scene import Light, Part, Role, Scene
from curiosight.worlds.rooms.shading import Rays, leaf, light_table, paint, polish, surfaces
from curiosight.worlds.rooms.shapes import box, ellipsoid, panel
from curiosight.worlds.rooms.tracing import RayCaster

CAMERA = Camera(64, 48, 60.0, 50.0, 31.5, 23.5)


def plain(grey: int | tuple[int, int, int], **looks: float) -> Material:
    """Return an even material of an sRGB code."""
    return Material(np.full((2, 2, 3), grey, np.uint8), **looks)


WHITE = plain(255)


def checks(size: float, **looks: float) -> Material:
    """Return a chessboard of black and white fields of `size` metres."""
    field = np.kron(np.eye(2), np.ones((8, 8)))[..., None] * np.full(3, 255)
    return Material(field.astype(np.uint8), tile=(2 * size, 2 * size), **looks)


def scene_of(*meshes: Mesh, lights: tuple[Light, ...] = ()) -> Scene:
    return Scene(tuple(Part("thing", Role.OBJECT, mesh) for mesh in meshes), lights)


def lamp(height: float, size: float = 0.4, radiance: float = 10.0) -> Light:
    """Return a square lamp above the origin that shines down."""
    along, across = np.array([0, size, 0]), np.array([size, 0, 0])
    return Light(np.array([0, 0, height]), along, across, np.full(3, radiance))


def ground(material: Material = WHITE, half: float = 2.0, spacing: float = 0.1) -> Mesh:
    side = 2 * half
    return panel((-half, -half, 0), (side, 0, 0), (0, side, 0), material, spacing=spacing)


def looking(eye: tuple[float, float, float], at: tuple[float, float, float]) -> np.ndarray:
    """Return T_world_camera of a camera held upright."""
    ahead = np.subtract(at, eye) / np.linalg.norm(np.subtract(at, eye))
    helper = (0, 0, 1) if abs(ahead[2]) < 0.99 else (0, 1, 0)
    right = np.cross(ahead, helper) / np.linalg.norm(np.cross(ahead, helper))
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(ahead, right), ahead, eye], 1)
    return pose


def from_above(scene: Scene, height: float = 2.0, at: tuple[float, float] = (0, 0)) -> Rendering:
    """Draw a scene from straight above a point of the ground."""
    return Renderer(scene).render(CAMERA, looking((*at, height), (*at, 0.0)))


def furnished() -> Scene:
    """Return a small scene with textures, gloss, curves, shadows and two lamps."""
    ball = ellipsoid((0.3, 0.3, 0.3), plain((200, 60, 40), gloss=0.8, sharpness=40.0))
    crate = box((0.5, 0.4, 0.6), checks(0.05, gloss=0.3, infrared=0.2), spacing=0.1)
    wall = panel((1.5, 1.5, 0), (-3, 0, 0), (0, 0, 2), plain((90, 140, 60)), spacing=0.2)
    screen = panel((-1.0, 1.4, 0.5), (0.6, 0, 0), (0, 0, 0.4), plain(120, emission=2.0))
    lights = (lamp(2.5), Light(np.array([-1.8, 0, 1]), np.eye(3)[1], np.eye(3)[2], np.ones(3)))
    things = (ball.moved(standing(-0.5, 0.2)), crate.moved(standing(0.5, 0.3, 0, 0.4)))
    return scene_of(ground(checks(0.2, gloss=0.2)), *things, wall, screen, lights=lights)


@pytest.fixture(scope="module")
def picture() -> Rendering:
    return Renderer(furnished()).render(CAMERA, looking((0.2, -2.5, 1.2), (0, 0.5, 0.3)))


def test_depth_runs_along_the_camera_s_z() -> None:
    pose = looking((0, 0, 2), (0, 1, 0))
    depth = Renderer(scene_of(ground())).render(CAMERA, pose).depth
    v, u = np.indices(depth.shape)
    rays = np.stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones_like(u)], -1)
    points = (rays * depth[..., None]) @ pose[:3, :3].T + pose[:3, 3]
    on_ground = np.isfinite(depth)
    assert on_ground.mean() > 0.5
    assert np.abs(points[on_ground, 2]).max() < 1e-5


def test_a_pixel_is_a_ray_through_its_centre() -> None:
    # From 1 m above, pixel [v, u] sees x = (u - cx) / fx: the panel begins at u = 41.
    left = (40.6 - CAMERA.cx) / CAMERA.fx
    strip = panel((left, -1, 0), (1, 0, 0), (0, 2, 0), WHITE)
    ids = from_above(scene_of(strip), height=1.0).ids
    assert (ids[:, :41] == 0).all()
    assert (ids[:, 41:] == 1).all()


def test_nothing_is_seen_where_nothing_is() -> None:
    seen = Renderer(scene_of(ground())).render(CAMERA, looking((0, 0, 1), (0, 0, 2)))
    assert np.isnan(seen.depth).all()
    for image in (seen.radiance, seen.ids, seen.cosine, seen.infrared):
        assert not image.any()
    assert (seen.depth.dtype, seen.ids.dtype) == (np.float32, np.int32)
    assert seen.radiance.shape == (*seen.depth.shape, 3)


def test_ids_and_infrared_are_the_nearest_part_s() -> None:
    table = box((0.4, 0.4, 0.5), plain(90, infrared=0.25))
    seen = from_above(scene_of(ground(), table))
    middle, corner = (24, 32), (0, 0)
    assert (seen.ids[middle], seen.ids[corner]) == (2, 1)
    assert (seen.infrared[middle], seen.infrared[corner]) == (0.25, 1.0)
    assert seen.depth[middle] == pytest.approx(1.5, abs=1e-6)


@pytest.mark.parametrize("is_turned", [False, True])
def test_cosine_is_the_same_from_behind(is_turned: bool) -> None:
    along, across = np.array([0, 4, 0]), np.array([4, 0, 0])
    if not is_turned:
        along, across = across, along
    seen = from_above(scene_of(panel((-2, -2, 0), along, across, WHITE)))
    v, u = np.indices(seen.cosine.shape)
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    np.testing.assert_allclose(seen.cosine, 1 / np.sqrt(1 + x**2 + y**2), atol=1e-6)


def test_ground_under_a_lamp_has_the_brightness_of_the_formula() -> None:
    mesh, light = ground(), lamp(1.6, size=0.1)
    baked = lit(mesh, (light,), RayCaster(mesh), seed=0)
    middle = np.linalg.norm(baked.mesh.vertices, axis=1).argmin()
    share = 0.1**2 / (np.pi * 1.6**2)
    np.testing.assert_allclose(baked.direct[middle], 10 * share, rtol=0.01)
    assert baked.unshadowed[middle] == 1


@pytest.mark.parametrize(
    ("point", "normal"),
    [((0, 0, 0), (0, 0, 1)), ((1, 1, 0.5), (0, 0.6, 0.8)), ((0.9, 0, 1.2), (-1, 0, 0))],
)
def test_share_of_view_agrees_with_random_rays(
    point: tuple[float, float, float], normal: tuple[float, float, float]
) -> None:
    light = lamp(1.5, size=1.0)
    rng = np.random.default_rng(0)
    places = light.centre + (rng.random((100_000, 2)) - 0.5) @ np.stack([light.along, light.across])
    towards = places - point
    squared = (towards**2).sum(1)
    cosines = np.maximum(towards @ normal, 0) * towards[:, 2]
    expected = (cosines / squared**2 / np.pi).mean()
    share = share_of_view(np.float32([point]), np.float32([normal]), light)
    assert share[0] == pytest.approx(expected, rel=0.03, abs=0.004)


def test_a_lamp_shines_to_one_side() -> None:
    above = panel((-1, -1, 2), (0, 2, 0), (2, 0, 0), WHITE)  # looks down, above the lamp
    renderer = Renderer(scene_of(above, lights=(lamp(1.0),)))
    assert not renderer.render(CAMERA, looking((0, 0, 1.5), (0, 0, 2))).radiance.any()


def test_shadows_are_dark_inside_and_soft_at_the_edge() -> None:
    board = box((0.5, 4, 0.02), WHITE, lift=0.4)
    mesh = join([ground(half=1.0, spacing=0.02), board])
    light = lit(mesh, (lamp(1.6),), RayCaster(mesh), seed=0)
    on_ground = (light.mesh.vertices[:, 2] == 0) & (np.abs(light.mesh.vertices[:, 1]) < 0.5)
    x = np.abs(light.mesh.vertices[:, 0])
    share = light.unshadowed
    assert share[on_ground & (x < 0.15)].max() < 0.02
    assert share[on_ground & (x > 0.6)].min() > 0.98
    edge = share[on_ground & (x > 0.31) & (x < 0.34)]
    assert ((edge > 0.1) & (edge < 0.9)).mean() > 0.8


def test_light_bounces_with_the_surface_s_colour() -> None:
    wall = panel((0.5, 1, 0), (0, -2, 0), (0, 0, 1), plain((230, 30, 30)))
    near = from_above(scene_of(ground(), wall, lights=(lamp(2.5),)), at=(0.2, 0)).radiance
    colour = near[24, 40]
    assert colour[0] > 1.02 * colour[1]


def test_contact_is_dark_and_the_covered_ground_does_not_leak_out() -> None:
    crate = box((0.5, 0.5, 0.5), plain(120))
    seen = from_above(scene_of(ground(), crate, lights=(lamp(2.5, size=1.5),)), at=(0.6, 0))
    row = seen.radiance[24].mean(-1)[seen.ids[24] == 1]
    beside, open_ground = row[:3].mean(), row[-15:].mean()
    assert 0.2 * open_ground < beside < 0.8 * open_ground


def test_a_shining_surface_needs_no_light() -> None:
    screen = panel((-1, -1, 0), (2, 0, 0), (0, 2, 0), plain(188, emission=3.0))
    radiance = from_above(scene_of(screen), height=1.0).radiance
    np.testing.assert_allclose(radiance, 3 * LINEAR_OF_SRGB[188], rtol=1e-5)


def test_a_polished_ground_mirrors_the_lamp_where_it_should() -> None:
    matt, glossy = plain(40), plain(40, gloss=1.0, sharpness=200.0)
    pose = looking((0, -1, 1), (0, 0, 0))  # the lamp at (0, 1, 1) is mirrored at the origin
    light = Light(np.array([0, 1, 1.0]), np.array([0, 0.2, 0]), np.array([0.2, 0, 0]), np.ones(3))
    drawn = [
        Renderer(scene_of(ground(material), lights=(light,))).render(CAMERA, pose).radiance
        for material in (matt, glossy)
    ]
    mirrored = (drawn[1] - drawn[0]).sum(-1)
    v, u = np.unravel_index(mirrored.argmax(), mirrored.shape)
    assert abs(v - CAMERA.cy) <= 2
    assert abs(u - CAMERA.cx) <= 2


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


def images(rendering: Rendering) -> list[bytes]:
    fields = ("radiance", "depth", "ids", "cosine", "infrared")
    return [getattr(rendering, name).tobytes() for name in fields]


def test_the_same_scene_gives_the_same_bytes_on_any_number_of_threads(picture: Rendering) -> None:
    pose = looking((0.2, -2.5, 1.2), (0, 0.5, 0.3))
    again = Renderer(furnished(), n_threads=3).render(CAMERA, pose)
    assert images(again) == images(picture)


def test_the_seed_turns_only_the_pattern_of_the_light(picture: Rendering) -> None:
    pose = looking((0.2, -2.5, 1.2), (0, 0.5, 0.3))
    other = Renderer(furnished(), seed=1).render(CAMERA, pose)
    assert images(other)[1:] == images(picture)[1:]
    assert images(other)[0] != images(picture)[0]
    assert np.abs(other.radiance - picture.radiance).mean() < 0.05 * picture.radiance.mean()


def test_a_picture_is_bounded_and_without_holes(picture: Rendering) -> None:
    assert set(np.unique(picture.ids)) >= {1, 2, 3, 4, 5}
    assert (np.isfinite(picture.depth) == (picture.ids > 0)).all()
    assert np.isfinite(picture.radiance).all()
    assert (picture.radiance >= 0).all()
    assert picture.cosine.max() <= 1 + 1e-6


def test_wrong_arguments_are_named() -> None:
    with pytest.raises(ValueError, match="n_threads: expected at least 1, got 0"):
        Renderer(scene_of(ground()), n_threads=0)
    with pytest.raises(ValueError, match="T_world_camera: expected a \\(4, 4\\) rotation"):
        Renderer(scene_of(ground())).render(CAMERA, np.full((4, 4), np.nan))
    with pytest.raises(ValueError, match="meshes"):
        Renderer(Scene((), ()))
