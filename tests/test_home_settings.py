"""Homes as they are named in a command, and their floor plans."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.rooms.home.change import Change
from curiosight.rooms.home.floor_plan import DOOR_WALL, HomePlan, draw_home_plan, in_world
from curiosight.rooms.home.purposes import SPARE_ROOM, STORE_ROOM, draw_purposes
from curiosight.rooms.home.settings import HomeSettings, is_home, parse_home
from curiosight.rooms.settings import parse_room


def test_a_seed_alone_is_eight_rooms_and_the_papers_robot() -> None:
    settings = parse_home("home:11")
    assert settings == HomeSettings(seed=11)
    assert (settings.rooms, settings.height, settings.tilt) == (8, 1.0, 10.0)
    assert is_home("home:11")
    assert not is_home("homes/home:11")


def test_every_option_is_read() -> None:
    settings = parse_home(
        "home:3,rooms=5,rearrange=5,lights=2,sensor=lidar,height=.5,tilt=45,views=12,split=test,"
        "blur=yes,mount=90,scene=floor,change=200:rearrange=2:lights=3:room=4,unlearnable=yes"
    )
    assert settings == HomeSettings(
        seed=3,
        rooms=5,
        rearrange=5,
        lights=2,
        sensor="lidar",
        height=0.5,
        tilt=45.0,
        views=12,
        split="test",
        blur=True,
        mount=90.0,
        scene="floor",
        change=Change(200, rearrange=2, lights=3, room=4),
        unlearnable=True,
    )


@pytest.mark.parametrize(
    "source",
    [
        "home:0",
        "home:3,rooms=2,rearrange=0,views=5",
        "home:1,change=200:lights=1,unlearnable=yes",
        "home:1,change=0:rearrange=2:room=7",
        "home:1,path=drive",
        "home:1,height=1.2,views=50,path=orbit",
    ],
)
def test_what_is_written_reads_back(source: str) -> None:
    assert str(parse_home(source)) == source


def test_a_hand_holds_a_camera_higher_than_a_robot() -> None:
    assert (parse_home("home:1,path=orbit").height, parse_home("home:1,path=orbit").tilt) == (
        1.4,
        None,
    )
    settings = parse_room("room:1,path=orbit,views=50")
    assert (settings.height, settings.tilt) == (1.4, None)
    assert str(settings) == "room:1,views=50,path=orbit"


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        ("home:", "seed: expected a whole number, got ''"),
        ("home:-1", "seed: expected 0 or more, got -1"),
        ("home:1,rooms=0", "rooms: expected 1 to 40, got 0"),
        ("home:1,views=0", "views: expected 1 to 12500 a room, got 0"),
        ("home:1,path=drive,views=100001", "views: expected 1 to 100000, got 100001"),
        ("home:1,plan=l", "expected home:SEED,key=value with rooms, .*; got 'plan=l'"),
        ("home:1,rearange=2", "did you mean rearrange=?"),
        ("home:1,sensor=tof", "sensor: expected kinect or stereo or lidar or perfect, got tof"),
        ("home:1,path=walk", "path: expected drive or orbit, got walk"),
        ("home:1,path=orbit,tilt=5", "tilt: expected none with path=orbit"),
        ("home:1,height=3", "height: expected 0.2 to 2.0 metres, got 3.0"),
        ("home:1,unlearnable=2", "unlearnable: expected yes or no, got '2'"),
        ("home:1,change=200", "change: expected LOOK:rearrange=SEED, .* got '200'"),
        ("home:1,change=-1:rearrange=2", "change: expected LOOK:rearrange=SEED"),
        ("home:1,change=9:move=2", "change: expected LOOK:rearrange=SEED"),
        ("home:1,change=9:rearrange=2:rearrange=3", "change: expected LOOK:rearrange=SEED"),
        ("home:1,change=9:rearrange=x", "change: expected LOOK:rearrange=SEED"),
        ("home:1,rooms=2,change=9:rearrange=1:room=2", "change: expected room=0 to 1, got 2"),
        ("room:1,path=orbit,over=table", "path: expected none with over=table, got orbit"),
        ("room:1,path=walk", "path: expected drive or orbit, got walk"),
    ],
)
def test_bad_homes_are_named(source: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        (parse_home if is_home(source) else parse_room)(source)


@pytest.fixture(params=[0, 1, 2])
def plan(request: pytest.FixtureRequest) -> HomePlan:
    return draw_home_plan(8, np.random.default_rng(request.param))


def test_rooms_lie_beside_each_other(plan: HomePlan) -> None:
    boxes = [(o.min(0), o.max(0)) for o in [*(lot.outline for lot in plan.lots)]]
    boxes.append((plan.corridor.outline.min(0), plan.corridor.outline.max(0)))
    for number, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:number]:
            apart = np.maximum(other_low - high, low - other_high).max()
            assert apart > DOOR_WALL - 1e-9


def test_each_doorway_is_the_same_hole_in_the_room_and_in_the_corridor(plan: HomePlan) -> None:
    for lot, hole in zip(plan.lots, plan.corridor_openings, strict=False):
        wall = hole.wall.T_room_wall
        ends = [wall[:2, 3] + x * wall[:2, 0] for x in (hole.left, hole.right)]
        outer = lot.door_area[np.abs(lot.door_area[:, 1]).argsort()[:2]]
        np.testing.assert_allclose(np.sort(outer[:, 0]), np.sort(np.array(ends)[:, 0]), atol=1e-9)
        np.testing.assert_allclose(outer[:, 1], np.array(ends)[:, 1], atol=1e-9)
        assert hole.top == lot.door.top


def test_windows_look_outside(plan: HomePlan) -> None:
    outlines = [lot.outline for lot in plan.lots]
    for number, lot in enumerate(plan.lots):
        for window in lot.openings[1:]:
            wall = window.wall.T_room_wall
            outside = wall[:2, 3] + window.middle * wall[:2, 0] + 0.4 * wall[:2, 1]
            x, y = in_world(lot.T_world_room, outside[None])[0]
            for other, outline in enumerate(outlines):
                low, high = outline.min(0), outline.max(0)
                is_in = low[0] < x < high[0] and low[1] < y < high[1]
                assert not is_in or other == number  # the notch of an L is outside, too


@pytest.mark.parametrize("n_rooms", [1, 3, 4, 8, 19])
def test_one_room_is_a_dump_and_one_nearly_empty(n_rooms: int) -> None:
    purposes = draw_purposes(n_rooms, np.random.default_rng(0))
    assert len(purposes) == n_rooms
    assert (STORE_ROOM in purposes) == (SPARE_ROOM in purposes) == (n_rooms >= 4)
    assert len({purpose.name for purpose in purposes}) == min(n_rooms, 8)


@pytest.mark.parametrize("n_empty", [0, 4, 8])
def test_as_many_rooms_are_nearly_empty_as_asked(n_empty: int) -> None:
    settings = parse_home(f"home:1,empty={n_empty}")
    assert str(settings) == f"home:1,empty={n_empty}"
    purposes = draw_purposes(8, np.random.default_rng(0), settings.empty)
    assert purposes.count(SPARE_ROOM) == n_empty
    assert len(purposes) == 8


def test_no_more_rooms_are_empty_than_there_are() -> None:
    with pytest.raises(ValueError, match=r"empty: expected 0 to 3, got 4"):
        parse_home("home:1,rooms=3,empty=4")
