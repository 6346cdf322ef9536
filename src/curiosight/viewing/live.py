"""What a person sees while a command runs: one line of progress, on standard error."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self

from numba.core import event
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn
from rich.table import Column

COMPILING = "Compiling kernels, once on this machine …"
_N_RECENT = 100  # frames the rate is taken from: the first ones wait for compilation


def progress_console(*, is_quiet: bool = False) -> Console:
    """Return the console of all that is no result: standard error, or nowhere if quiet."""
    return Console(stderr=True, quiet=is_quiet, highlight=False, emoji=False)


class FrameProgress:
    """Show how many frames are done, how fast, how long it will take, and a note.

    On a terminal one line that renews itself; elsewhere, in a log, a line every `every_s`
    seconds and one at the end. Use as a context manager.

    n_frames: how many there will be. unit: what one is called. clock: seconds, for tests.
    """

    def __init__(
        self,
        console: Console,
        title: str,
        n_frames: int,
        *,
        unit: str = "frame",
        every_s: float = 10.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._console = console
        self._unit = unit
        self._title = title
        self._n_frames = n_frames
        self._every_s = every_s
        self._clock = clock
        self._n_done = 0
        self._note = ""
        self._started = self._last_line = clock()
        self._recent = deque([self._started], maxlen=_N_RECENT)
        self._bar: Progress | None = None
        self._task = TaskID(0)

    def advance(self, note: str = "") -> None:
        """Count one more frame; note: what to say beside it."""
        self._n_done += 1
        self._recent.append(self._clock())
        self._note = note
        if self._bar is not None:
            self._bar.update(self._task, advance=1, pace=self._pace(), note=note)
        elif self._n_done < self._n_frames and self._is_line_due():
            self._print_line()

    def forget_pace(self) -> None:
        """Reckon the pace from now on: what was done so far is no measure of what comes."""
        self._recent = deque([self._clock()], maxlen=_N_RECENT)

    def __enter__(self) -> Self:
        self._started = self._last_line = self._clock()
        self.forget_pace()
        if self._console.is_terminal and not self._console.quiet:
            self._bar = _new_bar(self._console)
            self._task = self._bar.add_task(self._title, total=self._n_frames, pace="", note="")
            self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()
        elif self._n_done:
            self._print_line()

    def _is_line_due(self) -> bool:
        return self._clock() - self._last_line >= self._every_s

    def _print_line(self) -> None:
        self._last_line = self._clock()
        parts = (f"{self._title} {self._n_done}/{self._n_frames}", self._pace(), self._note)
        line = ", ".join(filter(None, parts))
        self._console.print(line, markup=False, soft_wrap=True)

    def _pace(self) -> str:
        """Return the rate of late and the time left; at the end the mean rate and the time."""
        is_over = self._n_done >= self._n_frames
        first = self._started if is_over else self._recent[0]
        n_frames = self._n_done if is_over else len(self._recent) - 1
        elapsed = self._clock() - first
        if not (n_frames and elapsed > 0):
            return ""
        rate = n_frames / elapsed
        left = (self._n_frames - self._n_done) / rate
        when = f"took {_duration(elapsed)}" if is_over else f"{_duration(left)} left"
        return f"{rate:.{1 if rate >= 0.1 else 3}f} {self._unit}s/s, {when}"


def describe_step(
    error: float | None, region_name: str | None = None, overall_error: float | None = None
) -> str:
    """Return the note of a step: "error 0.41, overall 0.35, x0 y1 heading 2".

    error: None = undefined, a dash; region_name, overall_error: None = left out.
    """
    parts = ["error –" if error is None else f"error {error:.2f}"]
    if overall_error is not None:
        parts.append(f"overall {overall_error:.2f}")
    if region_name is not None:
        parts.append(region_name)
    return ", ".join(parts)


@contextmanager
def announce_compilation(console: Console) -> Iterator[None]:
    """Say, once, that Numba compiles something while the context lasts.

    Kernels that come from Numba's cache are not compiled, and nothing is said.
    """
    with event.install_listener("numba:compile", _Announcer(console)):
        yield


class _Announcer(event.Listener):  # type: ignore[misc]  # numba has no types
    """Print at the first compilation that starts."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._is_said = False

    def on_start(self, event: Any) -> None:
        if not self._is_said:
            self._is_said = True
            self._console.print(COMPILING, markup=False)

    def on_end(self, event: Any) -> None:
        """Do nothing; a listener must have it."""


def _new_bar(console: Console) -> Progress:
    # markup=False: a region may be called [red].
    whole = Column(no_wrap=True)
    rest = Column(no_wrap=True, overflow="ellipsis", ratio=1)
    return Progress(
        TextColumn("{task.description}", markup=False, table_column=whole),
        BarColumn(bar_width=24 if console.width >= 110 else 8),
        TextColumn("{task.completed:.0f}/{task.total:.0f}", table_column=whole),
        TextColumn("{task.fields[pace]}", markup=False, table_column=whole),
        TextColumn("{task.fields[note]}", markup=False, style="dim", table_column=rest),
        console=console,
        expand=True,
    )


def _duration(seconds: float) -> str:
    """Return a time for people: 9 s, 2 min 05 s, 1 h 02 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, whole = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {whole:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
