"""curiosight bench: how long the stages take on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import INTERRUPTED, CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.soak import run_soak
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config
from curiosight.errors import DataError
from curiosight.experiments.output import write_json_file
from curiosight.experiments.racing import Race
from curiosight.experiments.timing import STAGES, Timing
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source


@reads_source
def bench(
    source: options.Source,
    stage: Annotated[
        str,
        typer.Option(
            help=f"{', '.join(STAGES)}, or all of them. segment_memory: with what other views "
            "showed; map: from RGB to saliency; step: one look of the loop, all it does."
        ),
    ] = "all",
    frames: Annotated[int, typer.Option(help="Frames to time, evenly spaced.", metavar="N")] = 40,
    against: Annotated[
        Path | None,
        typer.Option(
            metavar="PYTHON",
            help="Another build of curiosight, by the Python interpreter of its environment: "
            "both are timed in turns, and compared.",
        ),
    ] = None,
    rounds: Annotated[
        int, typer.Option(help="With --against: runs of each, of which the median counts.")
    ] = 5,
    soak: Annotated[
        int | None,
        typer.Option(
            metavar="LOOKS",
            help="Instead: explore small frames of the source for so many looks, in ever new "
            "space, and tell whether memory grows and what is written (500000 is a day at 5 Hz).",
        ),
    ] = None,
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

    Kernels are compiled first; memory and the learner's buffer are full; decoding does not count.
    Ctrl-C ends it early and shows what is measured.
    """
    talk = Talk(quiet=quiet)
    settings = load_config(preset, config, {**reading, "teacher.scene": scene, "teacher.up": up})
    if json is not None and not json.parent.is_dir():
        raise DataError(json.parent, "is not a folder", "make it, or choose another --json FILE")
    dataset = open_source(source, reading=settings.reading)
    if soak is not None:
        if against is not None or stage != "all":
            beside = f"--stage {stage}" if against is None else f"--against {against}"
            raise ValueError(f"soak: expected no --stage or --against with it, got {beside}")
        raise typer.Exit(run_soak(talk, settings, dataset, soak, json))
    if against is None:
        with announce_compilation(talk.console):
            stages = None if stage == "all" else (stage,)
            timing = Timing(settings, dataset, n_frames=frames, stages=stages)
            talk.introduce(source, dataset)
            figures, status = _time(timing, talk)
    else:
        given = {"stage": stage, "frames": frames, "preset": preset, "config": config}
        given |= {"scene": scene, "up": up}
        given |= {name.removeprefix("reading."): value for name, value in reading.items()}
        race = Race(against, [*_as_options(given), "--", str(source)], n_rounds=rounds)
        figures, status = _race(race, talk, lambda: talk.introduce(source, dataset))
    if json is not None:
        write_json_file(json, figures)
    for name, reason in figures["left_out"].items():
        talk.note(f"{name} is left out: {reason}")
    talk.results("bench", _rows(figures), figures)
    if status:
        n_rounds = figures.get("against", {}).get("rounds")
        done = count(figures["frames"], "frame") if against is None else count(n_rounds, "round")
        talk.note(f"stopped after {done}")
        raise typer.Exit(status)


def _time(timing: Timing, talk: Talk) -> tuple[dict[str, Any], int]:
    """Return the figures, and the exit status, 0 unless a signal ended it early."""
    with CtrlC() as ctrl_c, talk.following("bench", len(timing)) as shown:
        for _ in ctrl_c.until_pressed(timing):
            shown.advance()
    if ctrl_c.is_pressed and not timing.n_timed:
        raise typer.Exit(ctrl_c.status)
    return timing.figures(), ctrl_c.status


def _race(race: Race, talk: Talk, introduce: Callable[[], None]) -> tuple[dict[str, Any], int]:
    """Return the figures of both builds, and the exit status as `_time` does.

    introduce: says what is timed, once both builds can.
    """
    with CtrlC() as ctrl_c:
        for number, ratios in enumerate(ctrl_c.until_pressed(race), start=1):
            if number == 1:
                introduce()
            told = [f"{stage} {ratio:.2f}" for stage, ratio in ratios.items()]
            talk.note(f"round {number} of {race.n_rounds}: {', '.join(told) or 'nothing in both'}")
    if not race.rounds:
        raise typer.Exit(ctrl_c.status or INTERRUPTED)
    return race.figures(), ctrl_c.status


def _as_options(given: Mapping[str, Any]) -> list[str]:
    """Write arguments of this command as they are given on a command line; None = not given."""
    options = []
    for name, value in given.items():
        if value is not None and value is not False:
            option = f"--{name.replace('_', '-')}"
            options += [option] if value is True else [option, str(value)]
    return options


def _rows(figures: dict[str, Any]) -> dict[str, Any]:
    """Return what a person wants to see of the figures."""
    rows: dict[str, Any] = {"preset": figures["preset"], "frames": figures["frames"]}
    rows["image"] = figures["image"]
    against = figures.get("against")
    for stage, spent in figures["stages"].items():
        rows[f"{stage} (ms)"] = (
            f"{spent['median_ms']:.1f}, p90 {spent['p90_ms']:.1f}; "
            f"processor {spent['processor_median_ms']:.1f}"
            if against is None
            else _beside(against["stages"][stage])
        )
    if against is not None:
        rows["other"] = f"{against['package']}, {against['version']}"
        rows["rounds"] = against["rounds"]
    for name in ("samples", "places", "rows_a_tree", "trees_regrown_a_frame"):
        if name in figures:
            rows[name.replace("_", " ")] = str(figures[name])
    rows["threads"] = figures["threads"]
    rows["processor"] = figures["processor"]
    return rows


def _beside(stage: dict[str, Any]) -> str:
    """Write what a stage takes in this build and in the other."""
    this, other, ratios = stage["this"], stage["other"], stage["processor_ratios"]
    if not ratios:
        alone = f"processor {this['processor_median_ms']:.1f}, wall {this['median_ms']:.1f}"
        return f"–, {alone}; the other does not have it"
    return (
        f"{stage['processor_ratio']:.2f} of the other ({min(ratios):.2f}–{max(ratios):.2f}); "
        f"processor {this['processor_median_ms']:.1f} / {other['processor_median_ms']:.1f}, "
        f"wall {this['median_ms']:.1f} / {other['median_ms']:.1f}"
    )
