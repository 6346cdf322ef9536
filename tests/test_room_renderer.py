"""Pictures of a room: which part is where, and how far."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.rooms.renderer import Renderer, Rendering
from curiosight.rooms.scene import Scene
from curiosight.rooms.shapes import box, panel
from small_scenes import (
    CAMERA,
    WHITE,
    from_above,
    furnished,
    ground,
    looking,
    plain,
    scene_of,
)


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
