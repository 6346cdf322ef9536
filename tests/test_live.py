"""Progress is told in one line, on standard error, and compilation is announced once."""

from __future__ import annotations

import io
import subprocess
import sys

import numba
import pytest
from rich.console import Console

from curiosight.viewing.live import (
    COMPILING,
    FrameProgress,
    announce_compilation,
    describe_step,
    progress_console,
)


class Clock:
    """Seconds that pass when told to."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


def run_frames(console: Console, n_frames: int = 6) -> None:
    """Do frames of 4 s each."""
    clock = Clock()
    with FrameProgress(console, "map", n_frames, clock=clock) as progress:
        for number in range(n_frames):
            clock.now += 4
            progress.advance(f"[red] {number}")


def test_log_has_a_line_every_ten_seconds_and_one_at_the_end():
    text = io.StringIO()
    run_frames(Console(file=text, width=200))
    assert text.getvalue().splitlines() == [
        "map 3/6, 0.2 frames/s, 12 s left, [red] 2",
        "map 6/6, 0.2 frames/s, took 24 s, [red] 5",
    ]


@pytest.mark.parametrize("width", [80, 120])
def test_terminal_has_one_line_that_fits(width):
    text = io.StringIO()
    run_frames(Console(file=text, width=width, force_terminal=True, color_system=None))
    last = text.getvalue().replace("\x1b", "\r").split("\r")
    shown = [line for line in last if "6/6" in line][-1]
    assert "0.2 frames/s, took 24 s [red] 5" in shown


def test_long_times_are_told_in_minutes_and_hours():
    text = io.StringIO()
    run_frames(Console(file=text, width=200), n_frames=1000)
    lines = text.getvalue().splitlines()
    assert "1 h 06 min left" in lines[0]
    assert any("59 min 52 s left" in line for line in lines)
    assert ", 4 s left" in lines[-2]


def test_time_left_is_of_what_came_after_the_pace_was_forgotten():
    clock, text = Clock(), io.StringIO()
    with FrameProgress(Console(file=text, width=200), "do", 3, clock=clock) as progress:
        clock.now += 600  # of something else
        progress.forget_pace()
        clock.now += 4
        progress.advance()
    assert text.getvalue().splitlines()[0] == "do 1/3, 0.2 frames/s, 8 s left"


@pytest.mark.parametrize("is_quiet", [False, True])
def test_standard_output_stays_clean(capsys, is_quiet):
    run_frames(progress_console(is_quiet=is_quiet))
    captured = capsys.readouterr()
    assert captured.out == ""
    assert (captured.err == "") == is_quiet


def test_describe_step():
    assert describe_step(0.412, "slice 2", 0.35) == "error 0.41, overall 0.35, slice 2"
    assert describe_step(None) == "error –"


def test_compilation_is_announced_once_and_only_while_it_matters():
    console = Console(file=io.StringIO(), width=80)
    with announce_compilation(console):
        kernel = numba.njit(lambda x: x + 1)
        assert console.file.getvalue() == ""
        kernel(1)
        kernel(1.5)
    assert console.file.getvalue().splitlines() == [COMPILING]
    numba.njit(lambda x: x + 2)(1)
    assert console.file.getvalue().count(COMPILING) == 1


def test_kernels_from_the_cache_are_not_announced(tmp_path):
    script = tmp_path / "kernels.py"
    script.write_text(
        "import sys\n"
        "from rich.console import Console\n"
        "from curiosight.viewing.live import announce_compilation\n"
        "import numba\n"
        "@numba.njit(cache=True)\n"
        "def add(x):\n"
        "    return x + 1\n"
        "with announce_compilation(Console()):\n"
        "    add(1)\n"
        "assert 'matplotlib' not in sys.modules\n"
    )
    runs = [
        subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert runs == [COMPILING + "\n", ""]
