"""curiosight learn: the off-line model of a whole recording."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import typer

from curiosight import __version__
from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import (
    LEARNED_NOTHING_STATUS,
    tell_forgetting,
    tell_lessons,
    tell_places,
    tell_samples,
)
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.resume import (
    check_alone,
    given_now,
    go_on_with,
    no_source,
    open_run,
    read_summary,
)
from curiosight.cli.talk import Talk, count
from curiosight.config import Config, load_config, to_toml
from curiosight.errors import DataError
from curiosight.experiments.command_file import GivenCommand
from curiosight.experiments.exploring import CONFIG, MAKING, MODEL, RESULTS, SUMMARY
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.learning import OffLine
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.snapshot import STATE
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source

# Of `Keeping`, 2 % of the time being the most for both. What it takes to go on is soon written; for
# the model all trees grow each time. Either takes the longer the more frames there are.
STATE_S, STATE_SHARE = 0.1, 0.005
FIT_S, FIT_SHARE = 0.6, 0.01


@reads_source
def learn(
    context: typer.Context,
    source: options.ResumableSource = None,
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    threads: options.Threads = None,
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
    """Learn a whole recording at once: the off-line model, the least error to expect.

    Every frame gives as many labelled pixels (learner.n_pixels; fewer in a very long recording);
    of all of them, or of those of each place, a uniformly random choice that fits the buffer
    (forest.max_samples) is kept.
    Frames with poses are looked at twice, the second time by what all of them have told.
    Of a home summary.json tells what is left of each room when the others have been learned, by
    models of the frames up to there.
    Writes config.toml, model.npz and summary.json. Ctrl-C, or a signal to end (SIGTERM, SIGHUP),
    ends it early: the model then knows the frames up to there. So does the model.npz that is
    written now and then meanwhile; summary.json comes only at the end. After a kill, --resume RUN
    goes on to the same bytes. Exit status 1: nothing was learned.
    """
    talk = Talk(quiet=quiet, as_json=json)
    if resume is not None:
        check_alone(context)
        _resume(talk, resume)
        return
    if source is None:
        raise no_source("learn")
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
    _learn(talk, settings, given_now("learn", source), folder, is_new=True)


def _resume(talk: Talk, path: Path) -> None:
    """Go on with a run, or say that it is finished."""
    given, folder = open_run(path, "learn")
    settings = load_config(None, path / CONFIG, {})
    summary = read_summary(path)
    if summary is None or (path / STATE).is_file():
        _learn(talk, settings, given, folder, is_new=False)
        return
    talk.note(f"{path}: the run is finished after {count(summary['frames'], 'frame')}")


def _learn(
    talk: Talk, settings: Config, given: GivenCommand, folder: OutputFolder, *, is_new: bool
) -> None:
    """Learn from the beginning or from where it was ended, and tell of it."""
    dataset = open_source(given.source, reading=settings.reading)
    with announce_compilation(talk.console):
        keeping = Keeping(expected_s=STATE_S, max_share=STATE_SHARE)
        saving = Keeping(expected_s=FIT_S, max_share=FIT_SHARE)
        off_line = OffLine(settings, dataset, version=__version__, is_tested=True)
        _begin(off_line, given, folder, is_new=is_new)
        talk.introduce(Path(given.source), dataset)
        with CtrlC() as ctrl_c:
            _follow(talk, off_line, ctrl_c, (keeping, saving), folder)
            if off_line.n_done < off_line.n_looks:
                off_line.keep(folder.file(STATE))
            learner = off_line.fit()
            learner.save(folder.file(MODEL))
            summary = off_line.summary()
            folder.write_json(SUMMARY, summary)
            if off_line.n_done == off_line.n_looks:
                folder.remove([STATE])
    talk.warn_of(off_line.problems, summary["frames"], "taught nothing")
    tell_lessons(talk, off_line.lessons, has_learned=learner.is_trained)
    talk.results("learn", _rows(summary, folder), {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        stopped, again = count(summary["frames"], "frame"), go_on_with("learn", folder.path)
        talk.note(f"stopped after {stopped}; the model of these is kept; {again}")
        raise typer.Exit(ctrl_c.status)
    if not learner.is_trained:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _begin(off_line: OffLine, given: GivenCommand, folder: OutputFolder, *, is_new: bool) -> None:
    """Make room for what will be written, or take up what was."""
    folder.hold()
    folder.remove_half_written()
    if not is_new and (folder.path / STATE).is_file():
        off_line.go_on(folder.path / STATE)
        folder.remove([SUMMARY])
        return
    folder.remove([*(MAKING if is_new else ()), *RESULTS])
    if is_new:
        folder.write_text(CONFIG, to_toml(off_line.config))
        given.write(folder)


def _follow(
    talk: Talk,
    off_line: OffLine,
    ctrl_c: CtrlC,
    when: tuple[Keeping, Keeping],
    folder: OutputFolder,
) -> None:
    """Look at all frames, or at those up to a signal; write now and then what is known.

    when: to write what it takes to go on, and the model.
    """
    keeping, saving = when
    if off_line.n_done:
        talk.note(f"goes on after {count(off_line.n_done, 'look')}")
    with talk.following("learn", off_line.n_looks) as shown:
        for _ in range(off_line.n_done):
            shown.advance()
        for _ in ctrl_c.until_pressed(off_line):
            shown.advance()
            if keeping.is_due():  # the end would say if it fails
                with keeping.writing(), suppress(DataError):
                    off_line.keep(folder.file(STATE))
            if saving.is_due():
                with saving.writing(), suppress(DataError):
                    off_line.so_far().save(folder.file(MODEL), is_packed=False)


def _rows(summary: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    places, drawn = summary["places"], summary["samples_drawn"]
    return {
        "frames": summary["frames"],
        "samples": tell_samples(summary["samples_kept"], places, drawn),
        **tell_places(places),
        **tell_forgetting(summary["forgetting"]),
        "written to": folder.path,
    }
