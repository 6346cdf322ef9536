"""Help is quick, complete, and says all that is written."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from inspect import cleandoc
from typing import Any

import pytest
import typer

from command import refusal, succeed
from curiosight.cli import commands
from curiosight.cli.app import app

Capsys = pytest.CaptureFixture[str]
HEAVY = ("numpy", "numba", "cv2", "scipy", "matplotlib", "embreex", "curiosight.config")
FRAMES = re.compile(r"[\s│╭╮╰╯─]+")


@pytest.mark.parametrize("flag", ["--help", "--version"])
def test_help_imports_nothing_heavy_and_comes_at_once(flag: str) -> None:
    program = (
        "import sys\nfrom curiosight_command import main\ntry:\n    main()\n"
        f"finally:\n    print([m for m in {HEAVY} if m in sys.modules], file=sys.stderr)"
    )
    spent = []
    for _ in range(3):
        started = time.monotonic()
        command = [sys.executable, "-c", program, flag]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        spent.append(time.monotonic() - started)
        assert "curiosight" in done.stdout
        assert done.stderr == "[]\n"
    assert min(spent) < 1.0, "0.1 to 0.3 s on a machine at rest"


@pytest.mark.parametrize("name", commands.COMMANDS)
def test_listed_line_is_the_first_of_the_commands_own_help(name: str) -> None:
    command = commands.load_command(name)
    assert command.name == name
    first, *_ = cleandoc(command.help).split("\n\n")
    assert first.replace("\n", " ") == commands.COMMANDS[name]


def test_all_commands_are_listed(capsys: Capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    shown = succeed(capsys, "--help").out
    for name, line in commands.COMMANDS.items():
        assert re.search(rf"│ {name} +{re.escape(line)} ", shown)


def texts(command: Any) -> list[str]:
    """Return everything that a command's help should say."""
    own = [parameter.help for parameter in command.params]
    return [text for text in (command.help, *own) if text]


def squeezed(text: str) -> str:
    return FRAMES.sub("", text)


@pytest.mark.parametrize("name", [None, *commands.COMMANDS])
def test_help_shows_every_text_whole(
    name: str | None, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "3000")  # nothing is wrapped
    command = typer.main.get_command(app) if name is None else commands.load_command(name)
    shown = squeezed(succeed(capsys, *filter(None, [name]), "--help").out)
    for text in texts(command):
        assert squeezed(text) in shown


def test_brackets_are_shown_as_they_are(capsys: Capsys) -> None:
    def odd(
        red: str = typer.Option("", help="needs curiosight[onnx] [/] [bold]x[/bold] \\[y]"),
    ) -> None:
        """Take [a, b] or room:SEED[,key=value…]; [link=x]y[/link] too."""

    alone = typer.Typer(add_completion=False)
    alone.command(cls=commands.Command)(odd)
    alone(["--help"], standalone_mode=False, prog_name="odd")
    shown = squeezed(capsys.readouterr().out)
    assert squeezed("needs curiosight[onnx] [/] [bold]x[/bold] \\[y]") in shown
    assert squeezed(odd.__doc__ or "") in shown


def test_a_wrong_name_is_met_with_a_near_one(capsys: Capsys) -> None:
    assert "'score-teacher'" in refusal(capsys, "score-teachers")
