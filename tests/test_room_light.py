"""Light on the surfaces of a room."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.rooms.light_rays import share_of_view
from curiosight.rooms.lighting import lit
from curiosight.rooms.mesh import join
from curiosight.rooms.mipmaps import LINEAR_OF_SRGB
from curiosight.rooms.renderer import Renderer
from curiosight.rooms.scene import Light
from curiosight.rooms.shapes import box, panel
from curiosight.rooms.tracing import RayCaster
from small_scenes import (
    CAMERA,
    WHITE,
    from_above,
    ground,
    lamp,
    looking,
    plain,
    scene_of,
)


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
