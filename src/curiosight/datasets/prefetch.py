"""Decode frames ahead of their use, in a background thread, within a stated memory."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterable, Iterator
from types import TracebackType
from typing import Self

from curiosight.datasets.dataset import Dataset
from curiosight.frame import Frame


class Prefetch:
    """Serve a dataset's frames, decoding those that are expected ahead of use.

    Keeps up to `memory_mb` of decoded colour and depth (at least one frame); the frames
    least recently used go first. The dataset itself is never used by two threads at once.
    Use as a context manager or call `close`.
    """

    def __init__(self, dataset: Dataset, *, memory_mb: float = 256) -> None:
        if not memory_mb > 0:
            raise ValueError(f"memory_mb: expected a positive number, got {memory_mb}")
        self.dataset = dataset
        self._capacity = int(memory_mb * 1e6)
        self._changed = threading.Condition()
        self._decoding = threading.Lock()
        self._cache: OrderedDict[int, Frame] = OrderedDict()
        self._n_bytes = 0
        self._expected: list[int] = []
        self._ahead: set[int] = set()  # decoded ahead and not used yet
        self._failures: dict[int, BaseException] = {}
        self._under_way: int | None = None
        self._is_closed = False
        self._thread: threading.Thread | None = None

    def __len__(self) -> int:
        return len(self.dataset)

    def expect(self, indices: Iterable[int]) -> None:
        """Say which frames will be asked for next, soonest first; replaces what was said before.

        Raises `IndexError` for frames that the dataset does not have.
        """
        expected = [range(len(self.dataset))[index] for index in indices]
        with self._changed:
            if self._is_closed:
                return
            self._expected = list(dict.fromkeys(expected))
            self._ahead.intersection_update(expected)
            if self._thread is None:
                # A daemon, so that an interrupted program does not wait for it.
                self._thread = threading.Thread(
                    target=self._decode_ahead, name="prefetch", daemon=True
                )
                self._thread.start()
            self._changed.notify_all()

    def __getitem__(self, index: int) -> Frame:
        """Return a frame: decoded already, under way, or decoded now.

        Raises what the dataset raised, also where that happened ahead of use.
        """
        index = range(len(self.dataset))[index]
        with self._changed:
            while self._under_way == index:
                self._changed.wait()
            self._forget_expectation(index)
            if index in self._failures:
                raise self._failures.pop(index)
            if index in self._cache:
                self._cache.move_to_end(index)
                return self._cache[index]
        with self._decoding:
            frame = self.dataset[index]
        with self._changed:
            self._keep(index, frame)
        return frame

    def in_order(self, indices: Iterable[int], *, n_ahead: int = 3) -> Iterator[Frame]:
        """Yield the frames asked for, in order; the next `n_ahead` are decoded meanwhile.

        A frame is let go of after its last turn. Raises `IndexError` as `expect` does.
        """
        in_turn = [range(len(self.dataset))[index] for index in indices]
        last_turn = {index: turn for turn, index in enumerate(in_turn, start=1)}
        for turn, index in enumerate(in_turn, start=1):
            frame = self[index]
            if turn == last_turn[index]:
                with self._changed:
                    self._drop(index)
            self.expect(in_turn[turn : turn + n_ahead])
            yield frame

    def close(self) -> None:
        """Stop decoding ahead and free the memory; frames can still be asked for."""
        with self._changed:
            self._is_closed = True
            self._expected = []
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join()
        with self._changed:
            self._cache.clear()
            self._ahead.clear()
            self._n_bytes = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _forget_expectation(self, index: int) -> None:
        self._ahead.discard(index)
        if index in self._expected:
            self._expected.remove(index)
        self._changed.notify_all()

    def _decode_ahead(self) -> None:
        while True:
            with self._changed:
                while not self._is_closed and self._next_expected() is None:
                    self._changed.wait()
                index = self._next_expected()
                if self._is_closed or index is None:
                    return
                self._under_way = index
            frame, failure = None, None
            try:
                with self._decoding:
                    frame = self.dataset[index]
            except BaseException as error:
                failure = error
            with self._changed:
                self._under_way = None
                if failure is not None:
                    self._failures[index] = failure
                elif frame is not None and not self._is_closed:
                    self._ahead.add(index)
                    self._keep(index, frame)
                self._changed.notify_all()

    def _next_expected(self) -> int | None:
        """Return the first expected frame that is still to decode; None while memory is full."""
        waiting = sum(frame_bytes(self._cache[index]) for index in self._ahead)
        largest = max(map(frame_bytes, self._cache.values()), default=0)
        if self._ahead and waiting + largest > self._capacity:
            return None
        missing = (
            index
            for index in self._expected
            if index not in self._cache and index not in self._failures
        )
        return next(missing, None)

    def _keep(self, index: int, frame: Frame) -> None:
        """Put a frame into the cache; of those over the limit, frames not yet used go last."""
        previous = self._cache.pop(index, None)
        self._n_bytes += frame_bytes(frame) - (frame_bytes(previous) if previous else 0)
        self._cache[index] = frame
        by_age = sorted(self._cache, key=lambda kept: kept in self._ahead)
        for oldest in by_age:
            if self._n_bytes <= self._capacity or len(self._cache) == 1:
                break
            if oldest != index:
                self._drop(oldest)

    def _drop(self, index: int) -> None:
        """Let go of a frame, if it is kept."""
        frame = self._cache.pop(index, None)
        self._n_bytes -= frame_bytes(frame) if frame else 0
        self._ahead.discard(index)


def frame_bytes(frame: Frame) -> int:
    """Return the memory of a frame's colour and depth."""
    return frame.rgb.nbytes + (0 if frame.depth is None else frame.depth.nbytes)
