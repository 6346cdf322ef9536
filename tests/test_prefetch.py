"""Decoding ahead: the same frames, the stated memory, errors where they belong."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from curiosight.datasets import Prefetch
from curiosight.datasets.prefetch import frame_bytes
from curiosight.frame import Frame

FRAME_MB = 100 * 100 * 3 / 1e6


class Counting:
    """A dataset of grey frames that records which were decoded, and by which thread."""

    name = "counting"
    camera = None
    has_depth = False
    remarks = ()

    def __init__(self, n_frames: int = 20, failing: frozenset[int] = frozenset()) -> None:
        self.ids = tuple(str(index) for index in range(n_frames))
        self.poses = (None,) * n_frames
        self.decoded: list[int] = []
        self.threads: set[str] = set()
        self.failing = failing
        self.is_open = threading.Event()
        self.is_open.set()

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        self.is_open.wait(5)
        self.decoded.append(index)
        self.threads.add(threading.current_thread().name)
        if index in self.failing:
            raise RuntimeError(f"no frame {index}")
        return Frame(self.ids[index], np.full((100, 100, 3), index, np.uint8))

    def has_ground_truth(self, index: int) -> bool:
        return False

    def ground_truth(self, index: int) -> None:
        return None


def wait_for(is_so: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 5
    while not is_so():
        assert time.monotonic() < deadline, "nothing happened within 5 s"
        time.sleep(0.001)


def test_expected_frames_are_decoded_once_in_order_and_ahead() -> None:
    dataset = Counting()
    with Prefetch(dataset) as frames:
        frames.expect([7, 3, 5])
        wait_for(lambda: len(dataset.decoded) == 3)
        assert [int(frames[index].rgb[0, 0, 0]) for index in (7, 3, 5, 7)] == [7, 3, 5, 7]
    assert dataset.decoded == [7, 3, 5]
    assert dataset.threads == {"prefetch"}


def test_unexpected_frames_are_decoded_when_asked_for() -> None:
    dataset = Counting()
    with Prefetch(dataset) as frames:
        assert frames[4].id == "4"
        assert frames[-1].id == "19"
        assert len(frames) == 20
        with pytest.raises(IndexError):
            frames[20]
        with pytest.raises(IndexError):
            frames.expect([20])
    assert dataset.decoded == [4, 19]


def test_frame_under_way_is_waited_for() -> None:
    dataset = Counting()
    dataset.is_open.clear()
    with Prefetch(dataset) as frames:
        frames.expect([2])
        threading.Timer(0.05, dataset.is_open.set).start()
        assert frames[2].id == "2"
    assert dataset.decoded == [2]


def test_memory_is_bounded_and_decoding_ahead_pauses() -> None:
    dataset = Counting()
    with Prefetch(dataset, memory_mb=3.5 * FRAME_MB) as frames:
        frames.expect(range(10))
        wait_for(lambda: len(dataset.decoded) == 3)
        time.sleep(0.05)
        assert dataset.decoded == [0, 1, 2]
        for index in range(10):
            assert frames[index].id == str(index)
            kept = sum(map(frame_bytes, frames._cache.values()))
            assert kept <= 3.5 * FRAME_MB * 1e6
    assert sorted(dataset.decoded) == list(range(10))


def test_least_recently_used_frames_go_first() -> None:
    dataset = Counting()
    with Prefetch(dataset, memory_mb=2.5 * FRAME_MB) as frames:
        for index in (0, 1, 0, 2, 0, 1):
            frames[index]
    assert dataset.decoded == [0, 1, 2, 1]


def test_memory_smaller_than_a_frame_still_works() -> None:
    with Prefetch(Counting(), memory_mb=0.001) as frames:
        frames.expect([0, 1, 2])
        assert [frames[index].id for index in (0, 1, 2)] == ["0", "1", "2"]


def test_failure_ahead_surfaces_where_the_frame_is_used() -> None:
    dataset = Counting(failing=frozenset({1}))
    with Prefetch(dataset) as frames:
        frames.expect([0, 1, 2])
        wait_for(lambda: len(dataset.decoded) == 3)
        assert frames[0].id == "0"
        with pytest.raises(RuntimeError, match="no frame 1"):
            frames[1]
        assert frames[2].id == "2"


def test_frames_in_order_come_while_the_next_three_are_decoded() -> None:
    dataset = Counting()
    with Prefetch(dataset) as frames:
        in_order = frames.in_order([9, 4, 6, 2, 8])
        assert next(in_order).id == "9"
        # Nobody asks for these three: the thread decodes them, and no more than them.
        wait_for(lambda: len(dataset.decoded) == 4)
        time.sleep(0.02)
        assert dataset.decoded == [9, 4, 6, 2]
        assert [frame.id for frame in in_order] == ["4", "6", "2", "8"]
        assert not frames._cache
    assert dataset.decoded == [9, 4, 6, 2, 8]


def test_frames_in_order_may_be_none_or_repeat() -> None:
    dataset = Counting()
    with Prefetch(dataset) as frames:
        assert list(frames.in_order([])) == []
        assert [frame.id for frame in frames.in_order(iter([1, 1, 0, 1]), n_ahead=1)] == list(
            "1101"
        )
    assert dataset.decoded == [1, 0]


def test_close_ends_the_thread() -> None:
    frames = Prefetch(Counting())
    frames.expect(range(20))
    frames.close()
    assert "prefetch" not in {thread.name for thread in threading.enumerate()}
    frames.expect([3])
    assert frames[3].id == "3"


def test_memory_must_be_positive() -> None:
    with pytest.raises(ValueError, match="memory_mb: expected a positive number, got 0"):
        Prefetch(Counting(), memory_mb=0)
