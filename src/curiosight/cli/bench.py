"""curiosight bench: how long the stages take on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config
from curiosight.errors import DataError
from curiosight.experiments.output import write_json_file
from curiosight.experiments.timing import STAGES, Timing
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source


@reads_source
def bench(
    source: options.Source,
    stage: Annotated[
        str, typer.Option(help="segment, describe, predict, learn, or all of them.")
    ] = "all",
    frames: Annotated[int, typer.Option(help="Frames to time, evenly spaced.", metavar="N")] = 40,
    scene: options.Scene = None,
    up: options.Up = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    json: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write the figures to a file, too; one that is there is replaced.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
    quiet: options.Quiet = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Time the stages of the method, frame by frame, on one thread.

    Kernels are compiled first; the learner's buffer is full; decoding does not count.
    Ctrl-C ends it early and shows what is measured.
    """
    talk = Talk(quiet=quiet)
    settings = load_config(preset, config, {**reading, "teacher.scene": scene, "teacher.up": up})
    if json is not None and not json.parent.is_dir():
        raise DataError(json.parent, "is not a folder", "make it, or choose another --json FILE")
    dataset = open_source(source, reading=settings.reading)
    with announce_compilation(talk.console):
        stages = STAGES if stage == "all" else (stage,)
        timing = Timing(settings, dataset, n_frames=frames, stages=stages)
        talk.introduce(source, dataset)
        with CtrlC() as ctrl_c, talk.following("bench", len(timing)) as shown:
            for _ in ctrl_c.until_pressed(timing):
                shown.advance()
    if ctrl_c.is_pressed and not timing.n_timed:
        raise typer.Exit(ctrl_c.status)
    figures = timing.figures()
    if json is not None:
        write_json_file(json, figures)
    talk.results("bench", _rows(figures), figures)
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(figures['frames'], 'frame')}")
        raise typer.Exit(ctrl_c.status)


def _rows(figures: dict[str, Any]) -> dict[str, Any]:
    """Return what a person wants to see of the figures."""
    rows: dict[str, Any] = {"preset": figures["preset"], "frames": figures["frames"]}
    rows["image"] = figures["image"]
    for stage, spent in figures["stages"].items():
        rows[f"{stage} (ms)"] = (
            f"{spent['median_ms']:.1f}, p90 {spent['p90_ms']:.1f}; "
            f"processor {spent['processor_median_ms']:.1f}"
        )
    rows["threads"] = figures["threads"]
    rows["processor"] = figures["processor"]
    return rows
