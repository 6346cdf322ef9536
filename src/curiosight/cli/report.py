"""curiosight report: the page and the figures of a run, from what its folder holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.explore_report import REPORT
from curiosight.cli.explore_run import reopened, tell_run
from curiosight.cli.resume import open_run, read_summary
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config
from curiosight.errors import DataError
from curiosight.experiments.exploring import CONFIG
from curiosight.experiments.snapshot import STATE
from curiosight.viewing.live import announce_compilation


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder that explore wrote.")],
    quiet: options.Quiet = False,
    json: options.Json = False,
) -> None:
    """Make report.html and figures/ of a run of explore again, from what is there.

    Also of a run that was killed: then up to where its state was last written, some seconds
    before. Its source must be where it was. Nothing else in the folder is changed.
    """
    talk = Talk(quiet=quiet, as_json=json)
    given, folder = open_run(run, "explore")
    if not (run / STATE).is_file():
        remedy = f"do it again: curiosight explore --resume {run}"
        raise DataError(run, "was ended before anything of it was kept", remedy)
    settings = load_config(None, run / CONFIG, {})
    with announce_compilation(talk.console):
        explored = reopened(settings, given, folder, "told")
        summary = explored.summary() if explored.is_under_way else read_summary(run)
        if summary is None:
            raise DataError(run, "holds no summary.json", "put it back")
        tell_run(talk, explored, summary)
    steps = summary["steps"]
    of = count(settings.explorer.n_steps, "step")
    content = {"steps": steps, "report": str(run / REPORT)}
    talk.results("report", {"steps": f"{steps} of {of}", "written to": run / REPORT}, content)
