"""Rooms as they are named in a command."""

from __future__ import annotations

from pathlib import Path

import pytest

from curiosight.rooms.settings import RoomSettings, is_room, parse_room


def test_a_seed_alone_is_the_papers_robot() -> None:
    settings = parse_room("room:7")
    assert settings == RoomSettings(seed=7)
    assert (settings.height, settings.tilt, settings.sensor) == (1.0, 10.0, "kinect")


def test_every_option_is_read() -> None:
    source = (
        "room:3,plan=l,rearrange=5,lights=2,sensor=perfect,height=0.4,tilt=45,views=12,"
        "split=test,blur=yes,furniture=a b/lib.sh3f,mount=270,scene=floor"
    )
    assert parse_room(source) == RoomSettings(
        3,
        "l",
        5,
        2,
        "perfect",
        0.4,
        45.0,
        12,
        "test",
        True,
        Path("a b/lib.sh3f"),
        None,
        270.0,
        "floor",
    )


@pytest.mark.parametrize("sensor", ["kinect", "stereo", "lidar", "perfect"])
def test_every_sensor_is_known(sensor: str) -> None:
    assert parse_room(f"room:1,sensor={sensor}").sensor == sensor


def test_over_tables_height_and_tilt_are_each_views_own_unless_given() -> None:
    settings = parse_room("room:1,over=table")
    assert (settings.height, settings.tilt) == (None, None)
    settings = parse_room("room:1,over=table,height=1,tilt=90,mount=-45.5")
    assert (settings.height, settings.tilt, settings.mount) == (1.0, 90.0, -45.5)


@pytest.mark.parametrize(
    "source",
    [
        "room:0",
        "room:3,plan=l,rearrange=0",
        "room:1,sensor=perfect,tilt=12.5,blur=yes",
        "room:1,over=table",
        "room:1,sensor=lidar,height=1.0,tilt=75.0,over=table,mount=90.0",
    ],
)
def test_what_is_written_reads_back(source: str) -> None:
    assert str(parse_room(source)) == source


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        ("room:", "seed: expected a whole number, got ''"),
        ("room:x", "seed: expected a whole number, got 'x'"),
        ("room:-1", "seed: expected 0 or more, got -1"),
        ("room:1,plna=l", "got 'plna=l'; did you mean plan=?"),
        ("room:1,plan", "expected room:SEED,key=value with plan, .*; got 'plan'"),
        ("room:1,plan=round", "plan: expected rect or l, got round"),
        ("room:1,sensor=tof", "sensor: expected kinect or stereo or lidar or perfect, got tof"),
        ("room:1,over=floor", "over: expected table, got floor"),
        ("room:1,over=table,height=2", "height: expected 0.3 to 1.5 metres over a table, got 2.0"),
        ("room:1,over=table,tilt=10", "tilt: expected 45 to 90 degrees over a table, got 10.0"),
        ("room:1,mount=down", "mount: expected a number, got 'down'"),
        ("room:1,mount=400", "mount: expected -360 to 360 degrees, got 400.0"),
        ("room:1,mount=nan", "mount: expected -360 to 360 degrees, got nan"),
        ("room:1,split=val", "split: expected train or test, got val"),
        ("room:1,height=0.1", "height: expected 0.2 to 2.0 metres, got 0.1"),
        ("room:1,height=nan", "height: expected 0.2 to 2.0 metres, got nan"),
        ("room:1,tilt=91", "tilt: expected 0 to 90 degrees, got 91.0"),
        ("room:1,views=0", "views: expected 1 to 10000, got 0"),
        ("room:1,views=1e3", "views: expected a whole number, got '1e3'"),
        ("room:1,blur=maybe", "blur: expected yes or no, got 'maybe'"),
        ("room:1,rearrange=-2", "rearrange: expected 0 or more"),
        ("room:1,plan=l,plan=rect", "expected plan= once, got it twice"),
    ],
)
def test_bad_rooms_are_named(source: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        parse_room(source)


def test_folders_are_no_rooms(tmp_path: Path) -> None:
    assert is_room("room:7")
    assert is_room(Path("room:7,plan=l"))
    assert not is_room(tmp_path)
    assert not is_room("rooms/room:7")
