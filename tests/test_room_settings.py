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
        "split=test,blur=yes,furniture=a b/lib.sh3f"
    )
    assert parse_room(source) == RoomSettings(
        3, "l", 5, 2, "perfect", 0.4, 45.0, 12, "test", True, Path("a b/lib.sh3f")
    )


@pytest.mark.parametrize(
    "source",
    ["room:0", "room:3,plan=l,rearrange=0", "room:1,sensor=perfect,tilt=12.5,blur=yes"],
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
        ("room:1,sensor=lidar", "sensor: expected kinect or perfect, got lidar"),
        ("room:1,split=val", "split: expected train or test, got val"),
        ("room:1,height=2", "height: expected 0.4 to 1.6 metres, got 2.0"),
        ("room:1,height=nan", "height: expected 0.4 to 1.6 metres, got nan"),
        ("room:1,tilt=60", "tilt: expected 0 to 45 degrees, got 60.0"),
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
