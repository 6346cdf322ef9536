"""Put the commands together, and turn a user's mistake into one line."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer
from typer.exceptions import Exit, TyperException

from curiosight import __version__
from curiosight.cli import (
    bench,
    demo,
    evaluate,
    explore,
    export,
    info,
    learn,
    map,
    propose,
    render,
    saliency,
    score_teacher,
    segment,
)
from curiosight.cli.interrupt import name_interruption
from curiosight.errors import DataError

app = typer.Typer(
    help="Teach a camera to see the objects of its own rooms: depth shows what an object is, "
    "the program learns how such things look, and then finds them in colour alone.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _say_version(is_asked: bool) -> None:
    if is_asked:
        print(f"curiosight {__version__}")
        raise Exit(0)


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_say_version,
            is_eager=True,
            metavar="",
            help="Say the version and exit.",
        ),
    ] = False,
) -> None:
    """Take the options that stand before a command."""


app.command("demo")(demo.demo)
app.command("info")(info.info)
app.command("explore")(explore.explore)
app.command("learn")(learn.learn)
app.command("map")(map.map_)
app.command("saliency")(saliency.saliency)
app.command("evaluate")(evaluate.evaluate)
app.command("segment")(segment.segment)
app.command("propose")(propose.propose)
app.command("export")(export.export)
app.command("render")(render.render)
app.command("score-teacher")(score_teacher.score_teacher)
app.command("bench")(bench.bench)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit.

    0, 1 = nothing was learned, 2 = a mistake that one line explains, 130 = Ctrl-C, 143 = SIGTERM.
    """
    sys.exit(run(arguments))


def run(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit status."""
    try:
        # A command returns nothing; typer turns its `Exit`, and Ctrl-C, into a number.
        status = app(arguments, prog_name="curiosight", standalone_mode=False) or 0
        sys.stdout.flush()
    except TyperException as mistake:
        text = mistake.format_message()  # empty where no arguments had the help shown
        return _refuse(f"{text} (see `curiosight --help`)") if text else 2
    except (DataError, ValueError) as mistake:
        return _refuse(str(mistake))
    except BrokenPipeError:
        # Whoever read our output has seen enough; Python would complain once more at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        return _refuse(f"{error.filename or 'the system'}: {error.strerror}; check path and rights")
    except SystemExit as stop:  # a second signal
        status = int(stop.code or 0)
    if (interruption := name_interruption(status)) is not None:
        print(f"curiosight: {interruption}", file=sys.stderr)
    return int(status)


def _refuse(text: str) -> int:
    print("curiosight: " + " ".join(text.split()), file=sys.stderr)
    return 2
