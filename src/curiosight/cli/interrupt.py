"""A signal to stop ends a run between two frames, so that what was learned can still be written."""

from __future__ import annotations

import os
import signal
import stat
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import Any, Self, TypeVar

Item = TypeVar("Item")
INTERRUPTED = 130
# Ctrl-C; what service managers, containers and a shutdown send; a terminal or ssh that closes,
# which Windows does not have.
STOPPING = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
# A terminal that closes is told of by the kernel and by the shell: one wish, not two.
SAME_HANG_UP_S = 0.5


class CtrlC:
    """Take the first Ctrl-C, SIGTERM or SIGHUP as a wish to stop soon; the second ends at once.

    Use as a context manager. A signal that is ignored or handled already stays so: `nohup`
    ignores SIGHUP.

    status: the exit status that tells which signal it was, 128 + its number; 0 = none came.
    """

    def __init__(self) -> None:
        self.status = 0
        self._at = 0.0
        self._before: dict[int, Callable[[int, FrameType | None], Any] | int | None] = {}

    @property
    def is_pressed(self) -> bool:
        """Tell whether a signal has come."""
        return self.status > 0

    def until_pressed(self, items: Iterable[Item]) -> Iterator[Item]:
        """Yield from the items; after a signal only the one under way."""
        for item in items:
            yield item
            if self.is_pressed:
                return

    def __enter__(self) -> Self:
        for number in STOPPING:
            before = signal.getsignal(number)
            if before in _USUAL:
                self._before[number] = before
                signal.signal(number, self._press)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    def _press(self, number: int, frame: FrameType | None) -> None:
        if number != signal.SIGINT:
            _leave_lost_terminal()
        if not self.is_pressed:
            self.status = 128 + number
            self._at = time.monotonic()
        elif number == signal.SIGINT:
            raise KeyboardInterrupt
        elif number == signal.SIGTERM or time.monotonic() - self._at > SAME_HANG_UP_S:
            raise SystemExit(128 + number)


def _unwind(number: int, frame: FrameType | None) -> None:
    _leave_lost_terminal()
    raise SystemExit(128 + number)


_USUAL = (signal.default_int_handler, signal.SIG_DFL, _unwind)


@contextmanager
def unwinding() -> Iterator[None]:
    """Have SIGTERM and SIGHUP end what runs as Ctrl-C does: locks and workers are let go of.

    So it is wherever no `CtrlC` waits. A signal that is ignored or handled already stays so.
    """
    is_main = threading.current_thread() is threading.main_thread()
    usual = [n for n in STOPPING[1:] if is_main and signal.getsignal(n) is signal.SIG_DFL]
    for number in usual:
        signal.signal(number, _unwind)
    try:
        yield
    finally:
        for number in usual:
            signal.signal(number, signal.SIG_DFL)


def name_interruption(status: int) -> str | None:
    """Say which signal an exit status tells of; None where it tells of none."""
    if status == INTERRUPTED:
        return "interrupted"
    if status - 128 in STOPPING:
        return f"ended by {signal.Signals(status - 128).name}"
    return None


def _leave_lost_terminal() -> None:
    """Send to nowhere what goes to a terminal that is no more: writing to it would be an error."""
    for number in (1, 2):
        with suppress(OSError):
            is_device = stat.S_ISCHR(os.fstat(number).st_mode)
            if is_device and not os.isatty(number):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, number)
                os.close(nowhere)
