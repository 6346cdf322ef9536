"""Run commands inside the test, and see what a user would see."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from curiosight.cli.app import run
from curiosight.viewing.live import COMPILING


@dataclass(frozen=True)
class Outcome:
    status: int
    out: str
    err: str


def call(capsys: pytest.CaptureFixture[str], *arguments: str | Path | int) -> Outcome:
    """Run `curiosight` with these arguments."""
    capsys.readouterr()
    status = run([str(argument) for argument in arguments])
    return Outcome(status, *capsys.readouterr())


def succeed(capsys: pytest.CaptureFixture[str], *arguments: str | Path | int) -> Outcome:
    """Run a command that must succeed."""
    outcome = call(capsys, *arguments)
    assert outcome.status == 0, outcome.err
    return outcome


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str | Path | int) -> str:
    """Run a command that must refuse with one plain line; return the line."""
    outcome = call(capsys, *arguments)
    # The first test on a machine may have to wait for the compiler.
    lines = [line for line in outcome.err.splitlines() if line != COMPILING]
    assert outcome.status == 2, outcome
    assert len(lines) == 1, lines
    assert lines[0].startswith("curiosight: ")
    assert outcome.out == ""
    return lines[0]


def files(folder: Path) -> set[str]:
    """Return the files of a folder, as relative paths, without its lock and lists of files."""
    found = (path for path in folder.rglob("*") if path.is_file())
    shown = (path for path in found if not path.name.startswith(".curiosight"))
    return {path.relative_to(folder).as_posix() for path in shown}


def without_times(out: Path) -> dict[str, bytes]:
    """Return the content of all files of a contest but those that tell times of the clock."""
    return {
        name: (out / name).read_bytes() for name in files(out) if not name.endswith("timings.json")
    }


def interrupt_at(
    monkeypatch: pytest.MonkeyPatch,
    owner: object,
    method: str,
    turn: int = 1,
    number: signal.Signals = signal.SIGINT,
) -> None:
    """Press Ctrl-C, or send another signal, when a method is called for the `turn`-th time."""
    original: Callable[..., object] = getattr(owner, method)
    turns = iter(range(1, 1_000_000))

    def pressed(*arguments: object, **options: object) -> object:
        if next(turns) == turn:
            signal.raise_signal(number)
        return original(*arguments, **options)

    monkeypatch.setattr(owner, method, pressed)
