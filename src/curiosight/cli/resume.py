"""Go on with a run: source and settings are those of its folder, and no others are taken."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import typer

from curiosight import __version__
from curiosight.cli.again import from_anywhere
from curiosight.errors import DataError
from curiosight.experiments.command_file import GivenCommand, GivenWatch
from curiosight.experiments.exploring import SUMMARY
from curiosight.experiments.output import OutputFolder
from curiosight.worlds.sources import is_camera, is_drawn

BESIDE = ("resume", "quiet", "json")


def given_now(command: str, source: Path, **paths: Path | None) -> GivenCommand:
    """Return what a command was given, as it can be given from anywhere."""
    known = {name: None if one is None else from_anywhere(one) for name, one in paths.items()}
    return GivenCommand(command, __version__, _named(source), **known)


def watch_now(
    source: Path, model: Path | None, *, is_learning: bool, seconds: float | None
) -> GivenWatch:
    """Return the same of a watch."""
    from_ = None if model is None else from_anywhere(model)
    named = _named(source)
    return GivenWatch("watch", __version__, named, from_=from_, learn=is_learning, seconds=seconds)


def _named(source: Path) -> str:
    return str(source) if is_drawn(source) or is_camera(source) else from_anywhere(source)


def check_alone(context: typer.Context, *beside: str) -> None:
    """Raise ValueError where more than the run to go on with was said on the command line.

    beside: options that are no settings of a run.
    """
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if name not in (*BESIDE, *beside) and source is not None and source.name == "COMMANDLINE":
            said = parameter.opts[0] if parameter.param_type_name == "option" else "SOURCE"
            raise ValueError(
                f"resume: expected no {said} beside it, as the run has its own; "
                "give --resume RUN alone"
            )


def no_source(command: str) -> ValueError:
    """Return what to raise where neither a source nor a run was said."""
    told = f"see `curiosight {command} --help`"
    return ValueError(f"SOURCE: expected one, or --resume RUN, got none ({told})")


def open_run(run: Path, command: str) -> tuple[GivenCommand, OutputFolder]:
    """Return what the run of a folder was given, and the folder to write on in."""
    given = GivenCommand.read(run, command)
    return given, OutputFolder(run, command, Path(given.source), goes_on=True)


def open_watch(run: Path) -> tuple[GivenWatch, OutputFolder]:
    """Return the same of a watch."""
    given = GivenWatch.read(run, "watch")
    return given, OutputFolder(run, "watch", Path(given.source), goes_on=True)


def go_on_with(command: str, run: Path) -> str:
    """Return what goes on with a run, as a sentence has it."""
    return f"go on with {shlex.join(['curiosight', command, '--resume', str(run)])}"


def read_summary(run: Path) -> dict[str, Any] | None:
    """Return the summary of a run, which it writes at its end; None where there is none."""
    path = run / SUMMARY
    try:
        summary = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror})", "check its rights") from error
    except (ValueError, RecursionError) as error:
        raise DataError(path, "is damaged", "remove it, and go on with --resume") from error
    if not isinstance(summary, dict):
        raise DataError(path, "is damaged", "remove it, and go on with --resume")
    return summary
