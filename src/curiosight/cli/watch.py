"""curiosight watch: a source as it comes, mapped at its rate and learned from meanwhile."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.experiments.live_page import LivePage
from curiosight.robot.heaps import share_heaps
from curiosight.robot.page import HOST

WATCHING = "Watching"


@reads_source
def watch(
    context: typer.Context,
    source: options.ResumableSource = None,
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN",
            help="Begin with the model of a run: maps are made by it from the first frame on; and "
            "in the same rooms with its regions and their progress.",
            rich_help_panel=WATCHING,
        ),
    ] = None,
    learn: Annotated[
        bool,
        typer.Option(
            "--learn",
            metavar="",
            help="Learn from what depth says; with --model go on with that one.",
            rich_help_panel=WATCHING,
        ),
    ] = False,
    page: Annotated[
        int | None,
        typer.Option(
            metavar="PORT",
            help="Serve a live page at this port of this machine, 0 = any that is free.",
            rich_help_panel=WATCHING,
        ),
    ] = None,
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS",
            help="Serve it at this address of the machine: 0.0.0.0 = whoever reaches it may look, "
            "and press buttons.",
            rich_help_panel=WATCHING,
        ),
    ] = HOST,
    seconds: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            help="End so long after the first map.",
            rich_help_panel=WATCHING,
            show_default="at Ctrl-C",
        ),
    ] = None,
    mcap: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write a log of it, as Foxglove reads it: images, maps, poses, regions, why "
            "(needs curiosight[mcap]).",
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
    viz: Annotated[
        str | None,
        typer.Option(
            metavar="VIEWER",
            help="Show it in Rerun, too: open = start a viewer, or the address of one "
            "(needs curiosight[viz]).",
            rich_help_panel=WATCHING,
        ),
    ] = None,
    strategy: Annotated[
        str | None,
        typer.Option(
            help="What says where to go next, as of `explore`.",
            rich_help_panel=WATCHING,
            show_default="progress-rate, without poses iac",
        ),
    ] = None,
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    resume: options.Resume = None,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Watch a source live: map its newest frame, learn meanwhile, say where to go and why.

    A recording is replayed at its own pace, again and again; of a room or home a drive is drawn
    first, and the explorer drives. A camera is realsense:[SERIAL], oak:[ID] or camera:0, of colour
    alone. Writes config.toml, looks.csv, decisions.csv, summary.json and, with --learn, model.npz.
    Ctrl-C, or a signal to end (SIGTERM, SIGHUP), keeps all of it, and ends the log of --mcap. It is
    kept as it goes, too: after a kill --resume RUN goes on, and lacks one frame at most. Status
    1 = it was to learn, and nothing was learned.
    """
    if resume is None and source is None:
        from curiosight.cli.resume import no_source

        raise no_source("watch")
    if seconds is not None and not (isfinite(seconds) and seconds > 0):
        raise ValueError(f"seconds: expected more than 0, got {seconds:g}")
    if host != HOST and page is None:
        raise ValueError("host: expected --page PORT too, or there is no page to serve")
    if resume is None and model is None and not learn:
        raise ValueError("model: expected --model RUN, --learn, or both; got neither")
    share_heaps()
    with LivePage(page, host) as live:
        # At use: the page answers while all this is read.
        from curiosight.cli.resume import check_alone, watch_now
        from curiosight.cli.talk import Talk
        from curiosight.cli.watch_run import resume_watch, run_watch
        from curiosight.cli.watch_sinks import SinksAsked
        from curiosight.config import load_config
        from curiosight.experiments.output import OutputFolder

        talk = Talk(quiet=quiet, as_json=json)
        sinks = SinksAsked(talk, mcap, viz, overwrite=overwrite)
        if source is None or resume is not None:
            check_alone(context, "page", "host", "mcap", "viz")
            status = resume_watch(talk, live, resume or Path(), sinks)
        else:
            settings = load_config(
                preset,
                config,
                {
                    **reading,
                    "run.seed": seed,
                    "run.n_threads": 1,  # the other core is for maps
                    "teacher.scene": scene,
                    "teacher.up": up,
                    "teacher.source": teacher,
                },
            )
            folder = OutputFolder(out, "watch", source, overwrite=overwrite)
            given = watch_now(source, model, is_learning=learn, seconds=seconds)
            status = run_watch(talk, live, settings, given, folder, sinks, strategy)
    if status:
        raise typer.Exit(status)
