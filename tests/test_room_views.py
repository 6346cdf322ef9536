"""Whole rooms: what is seen in them, and moving through them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.datasets import check_dataset
from curiosight.errors import DataError
from curiosight.explorer import Chronological, make_regions
from curiosight.frame import Label, Viewpoint
from curiosight.rooms.room import Room, draw_room
from curiosight.rooms.scene import Role
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.viewpoints import camera_pose
from curiosight.rooms.views import RoomViews
from curiosight.worlds import check_world, open_source
from curiosight.worlds.room_world import RoomWorld

SETTINGS = RoomSettings(seed=5, views=24)
DOCS = Path(__file__).parent.parent / "docs/rooms.md"


@pytest.fixture(scope="module")
def room() -> Room:
    return draw_room(SETTINGS)


@pytest.fixture(scope="module")
def views(room: Room) -> RoomViews:
    return RoomViews(room)


@pytest.fixture(scope="module")
def moved() -> Room:
    return draw_room(replace(SETTINGS, rearrange=1))


def names(room: Room, role: Role) -> list[str]:
    return sorted(part.name for part in room.scene.parts if part.role is role)


def test_views_keep_the_contract_of_a_recording(views: RoomViews) -> None:
    check_dataset(views)
    assert views.ids[0] == "train-000"
    assert all(views.has_ground_truth(index) for index in range(len(views)))
    assert not views.free_space.contains(np.array([-1.0, -1.0]))


def test_the_python_of_the_documentation_runs() -> None:
    (code,) = re.findall(r"```python\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec(code, names)
    look = names["look"]
    assert look.frame.rgb.shape[:2] == look.truth.shape == look.true_depth.shape == look.ids.shape


def test_a_room_holds_objects_furniture_and_walls(room: Room) -> None:
    assert len(names(room, Role.OBJECT)) == len(room.things) >= 25
    assert {"floor", "wall", "ceiling", "window", "door"} <= {*names(room, Role.STRUCTURE)}
    assert names(room, Role.SUPPORT)
    assert 5 <= sum(thing.is_on_floor for thing in room.things) < len(room.things)


def test_a_look_shows_some_objects_and_knows_them(views: RoomViews) -> None:
    n_salient = 0
    for index in range(6):
        look = views.look(index)
        parts = views.room.scene.parts
        assert look.frame.rgb.std() > 20  # no grey fog, no black picture
        assert np.isfinite(look.true_depth).all()  # the room is closed
        assert look.ids.min() >= 1
        assert look.ids.max() <= len(parts)
        is_object = np.array([False, *(part.role is Role.OBJECT for part in parts)])[look.ids]
        assert (is_object | (look.truth != Label.SALIENT)).all()
        n_salient += np.count_nonzero(look.truth == Label.SALIENT)
    assert n_salient > 6 * 640 * 480 * 0.005


def test_depth_is_measured_along_z_to_where_the_room_is(views: RoomViews) -> None:
    look, pose = views.look(0), views.poses[0]
    camera = views.camera
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)], -1)
    points = rays * look.true_depth[..., None] @ pose[:3, :3].T + pose[:3, 3]
    low, high = views.room.plan.outline.min(0), views.room.plan.outline.max(0)
    # Window niches and door frames reach into the walls.
    assert (points[..., :2] > low - 0.6).all()
    assert (points[..., :2] < high + 0.6).all()
    number = [part.name for part in views.room.scene.parts].index("floor") + 1
    assert np.abs(points[..., 2][look.ids == number]).max() < 0.01


def test_a_kinect_sees_less_than_there_is(views: RoomViews) -> None:
    perfect = RoomViews(replace(views.room, settings=replace(SETTINGS, sensor="perfect")))
    perfect.renderer = views.renderer
    for index in range(3):
        seen, true = views[index].depth, views.true_depth(index)
        np.testing.assert_array_equal(perfect[index].depth, true)
        assert seen is not None
        is_seen = np.isfinite(seen)
        assert 0.3 < is_seen.mean() < 0.99
        # Frayed outlines of near things reach over what is far.
        assert is_seen[true > 4.7].sum() < 0.003 * is_seen.size
        assert np.median(np.abs(seen - true)[is_seen]) < 0.02


def test_the_same_source_gives_the_same_bytes(views: RoomViews) -> None:
    again = open_source("room:5,views=24")
    assert again.ids == views.ids
    for index in (3, 0):  # in any order
        frame, other = views[index], again[index]
        assert frame.rgb.tobytes() == other.rgb.tobytes()
        assert frame.depth.tobytes() == other.depth.tobytes()
        assert views.ground_truth(index).tobytes() == again.ground_truth(index).tobytes()


def test_another_seed_is_another_room(room: Room) -> None:
    other = draw_room(replace(SETTINGS, seed=6))
    assert not np.array_equal(room.plan.outline, other.plan.outline)


@pytest.mark.parametrize(("plan", "n_corners"), [("rect", 4), ("l", 6)])
def test_plans_can_be_chosen(plan: str, n_corners: int) -> None:
    assert len(draw_room(replace(SETTINGS, plan=plan)).plan.outline) == n_corners


def test_rearranging_keeps_the_room_and_moves_its_things(room: Room, moved: Room) -> None:
    np.testing.assert_array_equal(room.plan.outline, moved.plan.outline)
    for role in (Role.STRUCTURE, Role.SUPPORT):
        assert names(room, role) == names(moved, role)
    before = {thing.T_room_thing.tobytes() for thing in room.things}
    after = {thing.T_room_thing.tobytes() for thing in moved.things}
    assert not before & after
    again = room.rearranged(1)
    assert [thing.T_room_thing.tobytes() for thing in again.things] == [
        thing.T_room_thing.tobytes() for thing in moved.things
    ]
    back = again.rearranged(None)
    assert {thing.T_room_thing.tobytes() for thing in back.things} == before
    kept = {*names(room, Role.OBJECT)} & {*names(moved, Role.OBJECT)}
    assert len(kept) > len({*names(room, Role.OBJECT)}) / 2


def test_test_views_are_others_of_the_same_room(views: RoomViews) -> None:
    tests = views.test_views(5)
    assert tests.ids[0] == "test-000"
    assert len(tests) == 5
    assert tests.renderer is views.renderer
    places = {pose.tobytes() for pose in views.poses}
    assert not places & {pose.tobytes() for pose in tests.poses}
    assert str(tests.room.settings) == "room:5,views=5,split=test"


def test_other_lights_change_colours_only(views: RoomViews) -> None:
    darker = RoomViews(draw_room(replace(SETTINGS, lights=3)))
    ours, other = views.look(1), darker.look(1)
    np.testing.assert_array_equal(ours.ids, other.ids)
    assert np.abs(ours.frame.rgb.astype(int) - other.frame.rgb).mean() > 2


def test_height_and_tilt_are_the_cameras() -> None:
    low = RoomViews(draw_room(RoomSettings(seed=5, views=4, height=0.4, tilt=40)))
    for pose in low.poses:
        assert pose[2, 3] == pytest.approx(0.4, abs=0.05)
        assert np.degrees(np.arcsin(-pose[2, 2])) == pytest.approx(40, abs=3)


def test_a_missing_furniture_library_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"none\.sh3f: missing; give a furniture library"):
        draw_room(replace(SETTINGS, furniture=tmp_path / "none.sh3f"))


@pytest.fixture
def world(views: RoomViews):
    regions = make_regions("pose:1x1x4", views.poses, views.ids, up=(0, 0, 1))
    with RoomWorld(views, regions.of_view) as world:
        yield world


def test_the_robot_keeps_the_contract_of_a_world(world: RoomWorld) -> None:
    check_world(world)


def test_every_look_is_new(world: RoomWorld) -> None:
    world.move_to(world.views[2])
    first, second = world.capture(), world.capture()
    assert first.id == second.id == "train-002"
    assert first.rgb.tobytes() != second.rgb.tobytes()
    assert first.depth.tobytes() != second.depth.tobytes()


@pytest.mark.parametrize("looks_ahead", [True, False])
def test_looking_ahead_changes_nothing(
    views: RoomViews, world: RoomWorld, looks_ahead: bool
) -> None:
    strategy = Chronological(world.views)
    if looks_ahead:
        world.upcoming = strategy.upcoming
    for number in range(4):
        viewpoint = strategy.choose()
        world.move_to(viewpoint)
        frame = world.capture()
        with RoomWorld(views, np.zeros(len(views), int)) as other:
            other.move_to(viewpoint)
            for _ in range(number):
                other.capture()
            assert frame.rgb.tobytes() == other.capture().rgb.tobytes()


def test_a_move_costs_the_way_around_what_stands(world: RoomWorld) -> None:
    here, there = world.views[0], world.views[1]
    assert world.move_to(here) == 0.0
    straight = np.linalg.norm(here.T_world_camera[:2, 3] - there.T_world_camera[:2, 3])
    assert world.move_to(there) >= straight / 0.5
    assert world.move_to(there) == 0.0


def test_the_robot_goes_to_any_free_place_and_to_no_other(world: RoomWorld) -> None:
    space = world.room_views.free_space
    x, y = space.draw_places(1, np.random.default_rng(0))[0]
    world.move_to(Viewpoint(-1, 0, camera_pose(x, y, 30, height=1, tilt_deg=10)))
    assert world.capture().id == "look-0"
    with pytest.raises(ValueError, match=r"got \(-3\.00, 0\.50\): in a wall, in furniture"):
        world.move_to(Viewpoint(-1, 0, camera_pose(-3, 0.5, 0, height=1, tilt_deg=10)))
    with pytest.raises(ValueError, match="expected a pose, got None"):
        world.move_to(Viewpoint(-1, 0))


def test_nothing_is_seen_before_the_first_move(world: RoomWorld) -> None:
    with pytest.raises(ValueError, match="`move_to` before"):
        world.capture()


def test_regions_must_fit_the_views(views: RoomViews) -> None:
    with pytest.raises(ValueError, match="one for each of 24 views, got 3"):
        RoomWorld(views, np.zeros(3, int))
