"""Cameras that are turned about their axis, and those that an arm holds over tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.explorer import make_regions
from curiosight.frame import Label
from curiosight.rooms.overhead import REACH, OverTables, looking_at
from curiosight.rooms.renderer import Renderer
from curiosight.rooms.room import Room, draw_room
from curiosight.rooms.scene import Role
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.views import RoomViews
from curiosight.worlds import check_world
from curiosight.worlds.room_world import RoomWorld

SETTINGS = RoomSettings(seed=5, views=6, sensor="perfect")


@pytest.fixture(scope="module")
def room() -> Room:
    return draw_room(SETTINGS)


@pytest.fixture(scope="module")
def renderer(room: Room) -> Renderer:
    return Renderer(room.scene, n_threads=2)


def views_of(room: Room, renderer: Renderer, **settings: object) -> RoomViews:
    """Return other views of the same room; what is drawn of it is shared."""
    views = RoomViews(replace(room, settings=replace(SETTINGS, **settings)))
    views.renderer = renderer
    return views


@pytest.fixture(scope="module")
def overhead(renderer: Renderer) -> RoomViews:
    views = RoomViews(draw_room(RoomSettings(seed=5, views=40, sensor="perfect", over="table")))
    views.renderer = renderer
    return views


@pytest.mark.parametrize("mount", [90.0, 180.0, 270.0, -37.5])
def test_a_mount_turns_poses_about_the_optical_axis(
    room: Room, renderer: Renderer, mount: float
) -> None:
    upright, turned = (views_of(room, renderer, mount=roll) for roll in (0.0, mount))
    cos, sin = np.cos(np.radians(mount)), np.sin(np.radians(mount))
    # Clockwise as seen from behind: x, to the right, goes towards y, which is down.
    T_upright_turned = np.eye(4)
    T_upright_turned[:2, :2] = [[cos, -sin], [sin, cos]]
    for before, after in zip(upright.poses, turned.poses, strict=True):
        np.testing.assert_allclose(after, before @ T_upright_turned, atol=1e-12)


@pytest.mark.parametrize(("mount", "n_quarters"), [(90.0, 1), (180.0, 2), (270.0, 3)])
def test_a_mount_turns_images_the_other_way(
    room: Room, renderer: Renderer, mount: float, n_quarters: int
) -> None:
    upright, turned = (views_of(room, renderer, mount=roll).look(0) for roll in (0.0, mount))
    # The middle square is in both; the principal point is in the middle of it.
    square = np.s_[40:440, 120:520]
    expected = np.rot90(upright.true_depth[square], n_quarters)
    assert np.mean(np.abs(turned.true_depth[square] - expected) < 0.01) > 0.99
    assert np.mean(np.rot90(upright.truth[square], n_quarters) == turned.truth[square]) > 0.99


def test_a_mount_turns_chosen_views_too(room: Room, renderer: Renderer) -> None:
    turned = views_of(room, renderer, mount=180.0)
    x, y = turned.free_space.draw_places(1, np.random.default_rng(0))[0]
    pose = turned.pose_at(x, y, 30)
    assert pose[2, 1] > 0.9  # the image's down is up


def test_sensors_of_one_room_see_the_same(room: Room, renderer: Renderer) -> None:
    perfect = views_of(room, renderer).look(1)
    for sensor, error, share in (("stereo", 0.02, 0.75), ("lidar", 0.03, 0.75)):
        look = views_of(room, renderer, sensor=sensor).look(1)
        np.testing.assert_array_equal(look.frame.rgb, perfect.frame.rgb)
        np.testing.assert_array_equal(look.truth, perfect.truth)
        depth = look.frame.depth
        assert depth is not None
        assert np.isfinite(depth).mean() > share
        assert np.nanmedian(np.abs(depth - perfect.true_depth)) < error


def test_cameras_over_tables_look_down_at_them(overhead: RoomViews) -> None:
    tables = overhead.free_space
    assert isinstance(tables, OverTables)
    tilts, heights = [], []
    for pose in overhead.poses:
        tilts.append(np.degrees(np.arcsin(-pose[2, 2])))
        on_table = []
        for table in tables.tables:
            height = pose[2, 3] - table.T_room_top[2, 3]
            target = pose[:3, 3] + pose[:3, 2] * height / -pose[2, 2]
            if table.distance(target[:2]) < 1e-9 and 0.5 <= height <= 1.2:
                on_table.append(height)
        heights += on_table[:1]
    assert len(heights) == 40
    assert 60 <= min(tilts) < 65 < 80 < max(tilts) <= 90
    assert max(heights) - min(heights) > 0.4


def test_cameras_over_tables_see_tables_and_things(overhead: RoomViews) -> None:
    parts = overhead.room.scene.parts
    is_support = np.array([False, *(part.role is Role.SUPPORT for part in parts)])
    shares, n_salient = [], 0
    for index in range(8):
        look = overhead.look(index)
        middle = look.ids[200:280, 280:360]
        shares.append(is_support[look.ids].mean())
        n_salient += np.count_nonzero(look.truth == Label.SALIENT)
        assert np.isfinite(look.true_depth).all()
        assert look.true_depth[200:280, 280:360].max() < 2.5
        assert (middle > 0).all()
    assert np.mean(shares) > 0.25
    assert n_salient > 8 * 640 * 480 * 0.02


def test_no_camera_is_in_anything(overhead: RoomViews) -> None:
    centres = np.array([pose[:3, 3] for pose in overhead.poses])
    assert overhead.room.plan.contains(centres[:, :2]).all()
    for part in overhead.room.scene.parts:
        low, high = part.mesh.vertices.min(0), part.mesh.vertices.max(0)
        assert not ((centres > low) & (centres < high)).all(1).any()


def test_height_and_tilt_over_a_table_can_be_chosen(room: Room, renderer: Renderer) -> None:
    views = views_of(room, renderer, over="table", height=0.7, tilt=90.0, mount=90.0, views=3)
    tables = views.free_space
    assert isinstance(tables, OverTables)
    for pose in views.poses:
        np.testing.assert_allclose(pose[:3, 2], [0, 0, -1], atol=1e-12)
        heights = [pose[2, 3] - table.T_room_top[2, 3] for table in tables.tables]
        assert np.abs(np.array(heights) - 0.7).min() < 1e-9
    target = tables.draw_places(1, np.random.default_rng(0))[0]
    np.testing.assert_allclose(views.pose_at(*target, 0.0)[:2, 3], target, atol=1e-9)
    with pytest.raises(ValueError, match=r"expected a place on a table to look at, got \(-1"):
        views.pose_at(-1, -1, 0)


def test_a_chosen_point_is_in_the_middle_of_the_image() -> None:
    pose = looking_at(np.array([1.0, 2.0, 0.7]), 130, height=0.8, tilt_deg=65, roll_deg=40)
    assert pose[2, 3] == pytest.approx(1.5)
    seen = np.linalg.inv(pose) @ [1.0, 2.0, 0.7, 1.0]
    np.testing.assert_allclose(seen[:2], 0, atol=1e-12)
    assert seen[2] == pytest.approx(0.8 / np.sin(np.radians(65)))


def test_the_arm_keeps_the_contract_of_a_world(overhead: RoomViews) -> None:
    regions = make_regions("pose:1x1x4", overhead.poses, overhead.ids, up=(0, 0, 1))
    with RoomWorld(overhead, regions.of_view) as world:
        check_world(world)
        start, goal = world.views[0], world.views[1]
        world.move_to(start)
        assert world.move_to(goal) > 0


def test_the_arm_reaches_over_tables_only(overhead: RoomViews) -> None:
    tables = overhead.free_space
    assert isinstance(tables, OverTables)
    place = tables.draw_places(1, np.random.default_rng(0))[0]
    assert tables.contains(place)
    assert tables.way(place, place + np.array([0.3, 0.4])) == pytest.approx(0.5)
    with pytest.raises(ValueError, match=f"over a table or at most {REACH} m beside it, got"):
        tables.check(np.array([-2.0, 0.5]))


def test_a_room_without_a_table_is_refused(room: Room) -> None:
    bare = replace(room, furniture=(), settings=RoomSettings(seed=5, over="table"))
    with pytest.raises(ValueError, match=r"over: expected a room with a table .*got room:5"):
        RoomViews(bare)


def test_low_and_high_cameras_stand_in_the_room(room: Room, renderer: Renderer) -> None:
    for height in (0.2, 2.0):
        for pose in views_of(room, renderer, height=height, tilt=60.0).poses:
            assert pose[2, 3] == pytest.approx(height, abs=0.05)
            assert np.degrees(np.arcsin(-pose[2, 2])) == pytest.approx(60, abs=3)
