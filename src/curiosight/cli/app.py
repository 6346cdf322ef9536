"""Run a command, and turn a user's mistake into one line."""

from __future__ import annotations

import errno
import logging
import re
import sys
import warnings
from typing import Annotated

import typer
from typer.exceptions import Exit, TyperException

from curiosight import __version__
from curiosight.cli.commands import Commands
from curiosight.cli.interrupt import name_interruption, unwinding
from curiosight.cli.streams import Output, settle_streams
from curiosight.errors import DataError, printable
from curiosight.experiments.sole_writer import letting_go

app = typer.Typer(
    cls=Commands,
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


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit.

    0, 1 = nothing was learned, or done, but standard output did not take the results, 2 = a
    mistake that one line explains, 130 = Ctrl-C, 143 = SIGTERM, 129 = SIGHUP.
    """
    out = settle_streams()
    # What libraries say, as we say it; Matplotlib can do without a folder for its fonts.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    warnings.formatwarning = lambda message, *_: f"warning: {printable(str(message))}\n"
    status = run(arguments)
    sys.stdout.flush()
    sys.exit(status or _status_of(out))


def run(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit status."""
    try:
        # A command returns nothing; typer turns its `Exit`, and Ctrl-C, into a number.
        with unwinding(), letting_go():
            status = app(arguments, prog_name="curiosight", standalone_mode=False) or 0
    except TyperException as mistake:
        text = mistake.format_message()  # empty where no arguments had the help shown
        return _refuse(f"{text} (see `curiosight --help`)") if text else 2
    except (DataError, ValueError) as mistake:
        return _refuse(str(mistake))
    except OSError as error:
        place = printable(str(error.filename or "the system"))
        return _refuse(f"{place}: {error.strerror}; check path and rights")
    except SystemExit as stop:  # a signal
        status = int(stop.code or 0)
    if (interruption := name_interruption(status)) is not None:
        print(f"curiosight: {interruption}", file=sys.stderr)
    return int(status)


def _refuse(text: str) -> int:
    line = re.sub(r"\s*\n\s*", " ", text.strip())
    print(f"curiosight: {printable(line)}", file=sys.stderr)
    return 2


def _status_of(out: Output | None) -> int:
    """Return 1 where results could not be printed; say why, unless their reader left."""
    if out is None or out.error is None:
        return 0
    if out.error.errno != errno.EPIPE:
        found = f"standard output cannot be written ({out.error.strerror})"
        print(f"curiosight: {found}; the results were not printed", file=sys.stderr)
    return 1
