"""Live frames: in their order and pace, the newest when asked late, and what goes wrong is told."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from curiosight.frame import Frame
from curiosight.robot.feed import Incoming, Replay, Shot
from curiosight.robot.newest import Newest
from curiosight.robot.routes import Drive, rounds


class Clock:
    """A clock that goes only when somebody sleeps."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class Frames:
    """Black frames; stamps: nanoseconds of each, None = none."""

    def __init__(self, stamps: list[int | None]) -> None:
        self.stamps = stamps

    def __getitem__(self, index: int) -> Frame:
        rgb = np.zeros((2, 2, 3), np.uint8)
        return Frame(str(index), rgb, stamp_ns=self.stamps[index])


def replay(clock: Clock, stamps: list[int | None], *, rate_hz: float = 10.0) -> Replay:
    order = iter(range(len(stamps)))
    return Replay(Frames(stamps), order, rate_hz=rate_hz, clock=clock, sleep=clock.sleep)


def take(feed: Replay) -> Shot:
    shot = feed.newest(5)
    assert shot is not None
    return shot


def wait_until_decoded(feed: Replay, n: int) -> None:
    """Wait, in real time, until so many frames wait to be taken."""
    for _ in range(500):
        if feed._decoded.qsize() + (feed._head is not None) >= n:
            return
        feed._thread.join(0.01)
    pytest.fail("nothing was decoded")


def test_rounds_begin_anew() -> None:
    assert list(islice(rounds(3), 7)) == [0, 1, 2, 0, 1, 2, 0]
    with pytest.raises(ValueError, match="n_frames: expected 1 or more, got 0"):
        rounds(0)


def test_drive_goes_to_its_goal_either_way_and_waits_there() -> None:
    drive = Drive(6)
    assert [next(drive) for _ in range(3)] == [0, 1, 2]
    drive.go_to(4)
    assert [next(drive) for _ in range(4)] == [3, 4, 4, 4]
    drive.go_to(1)
    assert [next(drive) for _ in range(5)] == [3, 2, 1, 1, 1]
    with pytest.raises(ValueError, match="number: expected 0 to 5, got 6"):
        drive.go_to(6)


def test_drive_without_a_goal_turns_at_the_ends() -> None:
    assert list(islice(Drive(3), 7)) == [0, 1, 2, 1, 0, 1, 2]
    assert list(islice(Drive(1), 3)) == [0, 0, 0]


def test_order_goes_on_from_a_frame() -> None:
    assert list(islice(rounds(3, 4), 4)) == [1, 2, 0, 1]
    drive = Drive(6)
    drive.stand_at(4)
    drive.go_to(2)
    assert list(islice(drive, 4)) == [3, 2, 2, 2]
    with pytest.raises(IndexError):
        drive.stand_at(6)


def test_frames_come_at_the_rate() -> None:
    clock = Clock()
    feed = replay(clock, [None] * 4)
    shots = [take(feed) for _ in range(4)]
    feed.close()
    assert [shot.index for shot in shots] == [0, 1, 2, 3]
    assert np.diff([shot.taken_at for shot in shots]) == pytest.approx([0.1, 0.1, 0.1])
    assert feed.n_missed == 0


def test_stamps_are_kept_where_they_are_of_a_camera() -> None:
    """40 ms are as stamped, also backwards; a gap of ten seconds and a stamp twice are not."""
    clock = Clock()
    stamps: list[int | None] = [0, 40_000_000, 10_040_000_000, 10_040_000_000, 10_000_000_000]
    feed = replay(clock, stamps)
    times = [take(feed).taken_at for _ in stamps]
    feed.close()
    assert np.diff(times) == pytest.approx([0.04, 0.1, 0.1, 0.04])


def test_newest_wins_where_one_asks_late() -> None:
    clock = Clock()
    feed = replay(clock, [None] * 6)
    first = take(feed)
    wait_until_decoded(feed, 4)
    clock.now = first.taken_at + 0.35
    late = take(feed)
    feed.close()
    assert late.index == 3
    assert late.taken_at == pytest.approx(first.taken_at + 0.3)
    assert feed.n_missed == 2


def test_what_would_have_come_in_a_pause_is_not_missed() -> None:
    clock = Clock()
    feed = replay(clock, [None] * 4)
    take(feed)
    wait_until_decoded(feed, 3)
    clock.now += 60
    after = take(feed)
    feed.close()
    assert (after.index, after.taken_at, feed.n_missed) == (1, clock.now, 0)


def test_frame_that_is_not_due_is_not_given() -> None:
    clock = Clock()
    feed = replay(clock, [None] * 3, rate_hz=1.0)
    take(feed)
    wait_until_decoded(feed, 2)
    assert feed.newest(0.25) is None
    assert clock.now == pytest.approx(100.25)
    assert take(feed).index == 1
    feed.close()


def test_what_goes_wrong_with_the_source_is_raised_where_it_is_asked_for() -> None:
    feed = Replay(Frames([None]), iter([0, 7]), clock=(clock := Clock()), sleep=clock.sleep)
    take(feed)
    with pytest.raises(IndexError):
        take(feed)
    feed.close()
    feed.close()


def test_rate_is_checked() -> None:
    with pytest.raises(ValueError, match="rate_hz: expected a positive number, got 0"):
        Replay(Frames([]), iter([]), rate_hz=0)


def test_newest_replaces_what_was_not_taken() -> None:
    place = Newest[int]()
    assert place.is_empty
    assert not place.put(1)
    assert place.put(2)
    assert place.take(0) == 2
    assert place.take(0) is None


def test_newest_of_what_comes_is_made_a_frame() -> None:
    clock = Clock()
    made: list[int] = []

    def make(item: int) -> Frame | None:
        made.append(item)
        return None if item < 0 else Frame(str(item), np.zeros((4, 4, 3), np.uint8))

    feed = Incoming(make, clock=clock)
    assert feed.newest(0) is None
    for item in (1, 2, 3):
        feed.put(item)
    came_at = clock.now
    clock.now += 1.0
    shot = feed.newest(0)
    assert shot is not None
    assert (shot.frame.id, shot.index, shot.taken_at) == ("3", None, came_at)
    assert feed.n_missed == 2
    assert made == [3]  # those that were overtaken are not decoded
    feed.put(-1)
    assert feed.newest(0) is None
    feed.close()
