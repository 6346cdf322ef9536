"""Ctrl-C ends a run between two frames, so that what was learned can still be written."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator
from types import FrameType, TracebackType
from typing import Self, TypeVar

Item = TypeVar("Item")
INTERRUPTED = 130


class CtrlC:
    """Take the first Ctrl-C as a wish to stop soon; the second interrupts at once.

    Use as a context manager. Where Ctrl-C is ignored or handled already, that stays so.
    """

    def __init__(self) -> None:
        self.is_pressed = False
        self._is_watching = False

    def until_pressed(self, items: Iterable[Item]) -> Iterator[Item]:
        """Yield from the items; after Ctrl-C only the one under way."""
        for item in items:
            yield item
            if self.is_pressed:
                return

    def __enter__(self) -> Self:
        self._is_watching = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._is_watching:
            signal.signal(signal.SIGINT, self._press)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._is_watching:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _press(self, number: int, frame: FrameType | None) -> None:
        self.is_pressed = True
        signal.signal(signal.SIGINT, signal.default_int_handler)
