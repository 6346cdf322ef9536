"""curiosight learn: the off-line model of a whole recording."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import (
    LEARNED_NOTHING_STATUS,
    tell_lessons,
    tell_places,
    tell_samples,
)
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config, to_toml
from curiosight.errors import DataError
from curiosight.experiments.exploring import MODEL, RESULTS
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.learning import OffLine
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source

# Of `Keeping`: all trees grow each time, the longer the more frames there are, so 1 % is asked for
# where 2 % of the time is the most.
FIT_S, FIT_SHARE = 0.15, 0.01


@reads_source
def learn(
    source: options.Source,
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    threads: options.Threads = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Learn a whole recording at once: the off-line model, the least error to expect.

    Every frame gives as many labelled pixels (learner.n_pixels; fewer in a very long recording);
    of all of them, or of those of each place, a uniformly random choice that fits the buffer
    (forest.max_samples) is kept.
    Frames with poses are looked at twice, the second time by what all of them have told.
    Writes config.toml, model.npz and summary.json. Ctrl-C, or a signal to end (SIGTERM, SIGHUP),
    ends it early: the model then knows the frames up to there. So does the model.npz that is
    written now and then meanwhile; summary.json comes only at the end. Exit status 1: nothing was
    learned.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(
        preset,
        config,
        {
            **reading,
            "run.seed": seed,
            "teacher.scene": scene,
            "teacher.up": up,
            "teacher.source": teacher,
            "run.n_threads": threads,
        },
    )
    folder = OutputFolder(out, "learn", source, overwrite=overwrite)
    dataset = open_source(source, reading=settings.reading)
    with announce_compilation(talk.console):
        keeping = Keeping(expected_s=FIT_S, max_share=FIT_SHARE)
        off_line = OffLine(settings, dataset)
        folder.remove(RESULTS)
        folder.write_text("config.toml", to_toml(settings))
        talk.introduce(source, dataset)
        with CtrlC() as ctrl_c:
            with talk.following("learn", off_line.n_looks) as shown:
                for _ in ctrl_c.until_pressed(off_line):
                    shown.advance()
                    _keep(off_line, keeping, folder)
            learner = off_line.fit()
            learner.save(folder.file(MODEL))
            summary = off_line.summary()
            folder.write_json("summary.json", summary)
    talk.warn_of(off_line.problems, summary["frames"], "taught nothing")
    tell_lessons(talk, off_line.lessons, has_learned=learner.is_trained)
    talk.results("learn", _rows(summary, folder), {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(summary['frames'], 'frame')}; the model of these is kept")
        raise typer.Exit(ctrl_c.status)
    if not learner.is_trained:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _keep(off_line: OffLine, keeping: Keeping, folder: OutputFolder) -> None:
    """Write the model of the frames so far if it is time to; the end would say if it fails."""
    if keeping.is_due():
        with keeping.writing(), suppress(DataError):
            off_line.so_far().save(folder.file(MODEL), is_packed=False)


def _rows(summary: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    places, drawn = summary["places"], summary["samples_drawn"]
    return {
        "frames": summary["frames"],
        "samples": tell_samples(summary["samples_kept"], places, drawn),
        **tell_places(places),
        "written to": folder.path,
    }
