"""An exploration by what its command was given, and all that is drawn and told of it."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from curiosight.cli.again import command_again
from curiosight.cli.explore_examples import taught_examples
from curiosight.cli.explore_report import LEFTOVERS, REPORT, draw_figures, exploration_report
from curiosight.cli.talk import Talk
from curiosight.config import Config
from curiosight.experiments.command_file import GivenCommand
from curiosight.experiments.exploring import Exploration, Mode
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.report import write_report
from curiosight.worlds.sources import open_source


def reopened(
    settings: Config, given: GivenCommand, folder: OutputFolder, mode: Mode
) -> Exploration:
    """Return the exploration of a command; mode: see there."""
    opened = partial(open_source, reading=settings.reading)
    is_tested_apart = given.test is not None
    dataset = opened(given.source, ground_truth=None if is_tested_apart else given.ground_truth)
    test_source = None
    if given.test is not None:
        test_source = opened(given.test, ground_truth=given.ground_truth)
    return Exploration(
        settings,
        dataset,
        folder,
        test_source=test_source,
        continued=None if given.from_ is None else Path(given.from_),
        leftovers=LEFTOVERS,
        given=given,
        mode=mode,
    )


def tell_run(talk: Talk, run: Exploration, summary: dict[str, Any]) -> None:
    """Write figures and report, from what the folder holds.

    summary: of the run, as it is.
    """
    given, folder, taught = run.given, run.out, taught_examples(run)
    if talk.can_draw():
        draw_figures(run, folder, taught)
    named = {"test": given.test, "ground-truth": given.ground_truth, "from": given.from_}
    paths = {name: None if one is None else Path(one) for name, one in named.items()}
    again = command_again("explore", [Path(given.source)], paths)
    report = exploration_report(run, {**summary, **run.times()}, taught, again)
    write_report(report, folder.file(REPORT))
