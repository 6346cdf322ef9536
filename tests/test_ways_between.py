"""Ways between views: each found once, whoever asks."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from curiosight.errors import DataError
from curiosight.experiments.contest.prepared import new_table, save_array
from curiosight.experiments.contest.preparing import _even_out
from curiosight.experiments.ways import ways_between
from curiosight.frame import Viewpoint
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.rooms.free_space import FreeSpace
from curiosight.worlds.room_world import RoomWorld
from curiosight.worlds.sources import open_source
from curiosight.worlds.travel import straight_ways


@pytest.fixture(scope="module")
def views() -> DrawnViews:
    dataset = open_source("room:3,views=5")
    assert isinstance(dataset, DrawnViews)
    return dataset


def test_ways_in_a_room_are_found_once_a_view(
    views: DrawnViews, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts: list[tuple[float, ...]] = []
    found = FreeSpace.ways

    def counted(space: FreeSpace, start: np.ndarray, goals: np.ndarray) -> np.ndarray:
        starts.append(tuple(start))
        return found(space, start, goals)

    monkeypatch.setattr(FreeSpace, "ways", counted)
    between = ways_between(views, range(len(views)))
    assert between is not None
    table = np.stack([between[number] for number in range(len(between))])
    with RoomWorld(views, np.zeros(5, np.int64), indices=[1, 2, 4]) as world:
        for start in world.views:
            metres, degrees = world.ways(start, world.views)
            np.testing.assert_array_equal(metres, table[start.index, [1, 2, 4]])
            np.testing.assert_array_equal(degrees, straight_ways(start, world.views)[1])
    assert len(starts) == len(set(starts)) == 5
    np.testing.assert_allclose(table, table.T, rtol=1e-9)
    some = ways_between(views, [4, 1])
    assert some is not None
    np.testing.assert_array_equal(some[1], table[1, [4, 1]])


def test_ways_from_elsewhere_are_found_anew(views: DrawnViews) -> None:
    pose = views.poses[1].copy()
    with RoomWorld(views, np.zeros(5, np.int64)) as world:
        elsewhere = Viewpoint(0, 0, pose)  # the number of one view, the place of another
        metres, _ = world.ways(elsewhere, world.views)
    np.testing.assert_array_equal(metres, views.metres_from(1))


def test_ways_of_a_recording_are_straight_and_need_all_poses() -> None:
    poses: list[np.ndarray | None] = [np.eye(4) for _ in range(3)]
    poses[1][:3, 3] = (3, 4, 0)
    dataset = SimpleNamespace(poses=poses)
    between = ways_between(dataset, range(3))  # type: ignore[arg-type]
    assert between is not None
    np.testing.assert_allclose(between[0], [0, 5, 0])
    poses[2] = None
    assert ways_between(dataset, range(3)) is None  # type: ignore[arg-type]
    assert ways_between(dataset, []) is None  # type: ignore[arg-type]


def test_ways_are_as_long_there_as_back() -> None:
    metres = np.random.default_rng(0).uniform(1, 9, (7, 7))
    expected = (metres + metres.T) / 2
    _even_out(metres)
    np.testing.assert_array_equal(metres, expected)


def test_full_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def short(*_: object, **__: object) -> None:
        raise OSError("500 requested and 96 written")  # as NumPy says it, without a number

    with monkeypatch.context() as patch:
        patch.setattr(np, "save", short)
        with pytest.raises(DataError, match=r"No space left on device\); free some space"):
            save_array(tmp_path / "a.npy", np.zeros(9))

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full, raising=False)
    with pytest.raises(DataError, match="free some space"):
        new_table(tmp_path / "b.npy", 3)


def test_table_on_disk_is_read_back(tmp_path: Path) -> None:
    table = new_table(tmp_path / "b.npy", 2)
    table[0], table[1] = [1, 2], [3, 4]
    table.flush()  # type: ignore[attr-defined]
    np.testing.assert_array_equal(np.load(tmp_path / "b.npy"), [[1, 2], [3, 4]])
