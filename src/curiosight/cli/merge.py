"""curiosight merge: one model of those of several robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.lessons import tell_places
from curiosight.cli.talk import Talk
from curiosight.experiments.merging import merge_runs
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.live import announce_compilation


def merge(
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN RUN…",
            help="Folders that explore or learn wrote, of robots in the same home, with the same "
            "settings.",
        ),
    ],
    threads: options.Threads = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
) -> None:
    """Merge the models of robots in the same home: each knows then what all have seen.

    Places are one by their poses, where these are of one world, or by what they look like. No
    more samples are kept than one model may have (forest.max_samples). Which RUN comes first does
    not matter: the result is the same, byte for byte. Writes model.npz, config.toml and
    summary.json.
    """
    talk = Talk(quiet=quiet, as_json=json)
    if len(runs) < 2:
        raise ValueError("merge: expected two runs or more, got one")
    if threads is not None and threads < 1:
        raise ValueError(f"threads: expected 1 or more, got {threads}")
    folder = OutputFolder(out, "merge", None, overwrite=overwrite)
    if any(folder.path.resolve() == run.resolve() for run in runs):
        raise ValueError(f"out: expected another folder than those of the runs, got {folder.path}")
    with announce_compilation(talk.console):
        summary = merge_runs(runs, folder, n_threads=threads)
    before = " and ".join(map(str, summary["samples_of_runs"]))
    rows = {"samples": f"{summary['samples']}, of {before}", **tell_places(summary["places"])}
    talk.results("merge", rows | {"written to": folder.path}, {**summary, "out": str(folder.path)})
