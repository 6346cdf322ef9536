"""Where live frames come from. The newest one wins: who asks late is not given the old ones."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from curiosight.frame import Frame
from curiosight.robot.newest import Newest

RATE_HZ = 30.0
# Times between two stamps that are replayed as they are; others are those of `rate_hz`.
LEAST_GAP_S, MOST_GAP_S = 1 / 120, 0.5
# Who has not asked for so long has paused; what was to come meanwhile never comes.
PAUSE_S = 0.5
N_AHEAD = 4
Item = TypeVar("Item")


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A frame as it came. index: of the view, where it is one of those that the source offers.

    taken_at: when, in seconds of the feed's clock.
    """

    frame: Frame
    index: int | None
    taken_at: float


class EndedError(Exception):
    """There will be no more frames, and nothing is wrong: a video is at its end, say."""


class Feed(Protocol):
    """A source of live frames: a camera, or what is replayed as if one saw it now."""

    @property
    def n_missed(self) -> int:
        """How many frames came and were overtaken by newer ones before they were asked for."""
        ...

    def newest(self, timeout_s: float) -> Shot | None:
        """Wait for a frame that was not given yet, and return the newest; None = none in time.

        One thread asks. Raises what went wrong with the source, `EndedError` at its end.
        """
        ...

    def close(self) -> None:
        """Let go of the source; may be called twice."""
        ...


class Indexed(Protocol):
    """Frames by number; a bad one has a `problem`."""

    def __getitem__(self, index: int, /) -> Frame: ...


class Replay:
    """Replay frames in an order, at their own pace where they have stamps, else at `rate_hz`.

    They are decoded a few ahead, in a thread of its own. Where that takes longer than the pace,
    a frame comes when it is decoded.

    frames: used by that thread only, from the first `newest` on. order: their numbers; it may
    depend on what happens meanwhile.
    """

    def __init__(
        self,
        frames: Indexed,
        order: Iterator[int],
        *,
        rate_hz: float = RATE_HZ,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not rate_hz > 0:
            raise ValueError(f"rate_hz: expected a positive number, got {rate_hz}")
        self.n_missed = 0
        self._frames, self._order = frames, order
        self._period_s = 1 / rate_hz
        self._clock, self._sleep = clock, sleep
        self._decoded: queue.Queue[Shot | BaseException] = queue.Queue(N_AHEAD)
        self._head: Shot | None = None
        self._last: Shot | None = None
        self._failure: BaseException | None = None
        self._is_closed = False
        # A daemon, so that an interrupted program does not wait for it.
        self._thread = threading.Thread(target=self._decode, name="replay", daemon=True)

    def newest(self, timeout_s: float) -> Shot | None:
        if self._thread.ident is None:
            self._thread.start()
        until = self._clock() + timeout_s
        head = self._next(timeout_s)
        if head is None:
            if self._failure is not None:
                raise self._failure
            return None
        now = self._clock()
        due = self._due(head)
        if due > now:
            self._sleep(min(due, until) - now)
            if due > self._clock():
                return None
        return self._take()

    def _take(self) -> Shot:
        """Take the first frame, or the last of those that are due by now."""
        now = self._clock()
        taken = self._shift(now)
        while (head := self._next(0)) is not None and self._due(head) <= now:
            taken = self._shift(now)
            self.n_missed += 1
        return taken

    def _shift(self, now: float) -> Shot:
        assert self._head is not None
        head, self._head = self._head, None
        due = self._due(head)
        at = now if now - due > PAUSE_S else due
        self._last = Shot(head.frame, head.index, at)
        return self._last

    def _due(self, shot: Shot) -> float:
        """Return when a frame comes: after the one before, and never before it is decoded."""
        if self._last is None:
            return shot.taken_at
        gap_s = self._period_s
        before, after = self._last.frame.stamp_ns, shot.frame.stamp_ns
        if before is not None and after is not None:
            stamped_s = abs(after - before) / 1e9  # backwards, too, it takes that long
            gap_s = stamped_s if LEAST_GAP_S <= stamped_s <= MOST_GAP_S else gap_s
        return max(self._last.taken_at + gap_s, shot.taken_at)

    def _next(self, timeout_s: float) -> Shot | None:
        """Return the next decoded frame, which stays; None = not yet."""
        if self._head is None and self._failure is None:
            try:
                found = self._decoded.get(timeout=timeout_s) if timeout_s else self._pop()
            except queue.Empty:
                return None
            if isinstance(found, BaseException):
                self._failure = found  # raised once what came before is given
                return None
            self._head = found
        return self._head

    def _pop(self) -> Shot | BaseException:
        return self._decoded.get_nowait()

    def _decode(self) -> None:
        try:
            for index in self._order:
                frame = self._frames[index]
                self._put(Shot(frame, index, self._clock()))
                if self._is_closed:
                    return
        except BaseException as error:  # whoever asks for the frame is told
            self._put(error)

    def _put(self, item: Shot | BaseException) -> None:
        while not self._is_closed:
            with suppress(queue.Full):
                self._decoded.put(item, timeout=0.1)
                return

    def close(self) -> None:
        """Stop decoding."""
        self._is_closed = True
        if self._thread.ident is not None:
            self._thread.join()


class Incoming(Generic[Item]):
    """What comes from elsewhere, as messages do: the newest is made a frame when it is asked for.

    make: in the thread that asks; None = no frame can be made of it.
    """

    def __init__(
        self,
        make: Callable[[Item], Frame | None],
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.n_missed = 0
        self._make, self._clock = make, clock
        self._newest = Newest[tuple[Item, float]]()

    def put(self, item: Item) -> None:
        """Take what has come now; any thread may call."""
        self.n_missed += self._newest.put((item, self._clock()))

    def newest(self, timeout_s: float) -> Shot | None:
        taken = self._newest.take(timeout_s)
        if taken is None:
            return None
        frame = self._make(taken[0])
        return None if frame is None else Shot(frame, None, taken[1])

    def close(self) -> None:
        """Nothing is held."""
