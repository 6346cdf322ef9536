"""curiosight explore: the loop on a recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.explore_report import REPORT
from curiosight.cli.explore_run import reopened, tell_run
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import (
    LEARNED_NOTHING_STATUS,
    tell_alarms,
    tell_forgetting,
    tell_lessons,
    tell_places,
    tell_samples,
)
from curiosight.cli.mean_error import mean_of
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
from curiosight.config import Config, load_config
from curiosight.experiments.command_file import GivenCommand
from curiosight.experiments.contest.settings import absolute_regions
from curiosight.experiments.exploring import CONFIG, Exploration, Mode, load_run_model
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.live import announce_compilation, describe_step

EXPLORING = "Exploring"
TESTING = "Testing"


@reads_source
def explore(
    context: typer.Context,
    source: options.ResumableSource = None,
    strategy: Annotated[
        str | None,
        typer.Option(
            help="iac = where it learns fastest; rl-iac = with the way counted; sweep, coverage = "
            "by short ways; random, random-region, chronological; error, novelty, uncertainty, "
            "forgetting; progress-forgetting; progress-rate; or package.module:Class of your own.",
            rich_help_panel=EXPLORING,
            show_default="iac",
        ),
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(
            help="How many frames to look at.", rich_help_panel=EXPLORING, show_default="200"
        ),
    ] = None,
    regions: Annotated[
        str | None,
        typer.Option(
            help="Where to look for progress: auto = rooms, by the ways between views, auto:4 = "
            "each by as many headings, growing = auto, split where progress differs inside, "
            "places = as the learner tells rooms apart, pose = 2x2 positions by 4 headings, "
            "pose:3x2x4 = another grid, time:5 = slices, or a file of `id,region` lines or the "
            "authors' region map.",
            rich_help_panel=EXPLORING,
            show_default="auto where there are rooms, else pose, without poses time:5",
        ),
    ] = None,
    from_: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="RUN",
            help="Go on with the model of an earlier run, and in the same rooms with its regions, "
            "their progress, and what its teacher remembers.",
            rich_help_panel=EXPLORING,
        ),
    ] = None,
    test_every: Annotated[
        int | None,
        typer.Option(
            metavar="J",
            help="Keep every J-th frame for testing: the overall error at every step.",
            show_default="those with ground truth",
            rich_help_panel=TESTING,
        ),
    ] = None,
    gap: Annotated[
        int | None,
        typer.Option(
            help="With --test-every: frames beside a test frame, on each side, to leave out.",
            rich_help_panel=TESTING,
            show_default="3",
        ),
    ] = None,
    test: Annotated[
        Path | None,
        typer.Option(metavar="SOURCE2", help="Test on another recording.", rich_help_panel=TESTING),
    ] = None,
    ground_truth: options.GroundTruth = None,
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
    """Explore a recording: look, predict, compare with depth, learn, choose where to look next.

    Writes report.html to look at first, config.toml, steps.csv, decisions.csv, timings.csv,
    model.npz, summary.json, timings.json and figures/. Ctrl-C, or a signal to end (SIGTERM,
    SIGHUP), ends a run early and keeps all of it; what was learned is written every 50 looks or
    30 s too. After a kill, --resume RUN goes on to the same bytes. Exit status 1: nothing was
    learned.
    """
    talk = Talk(quiet=quiet, as_json=json)
    if resume is not None:
        check_alone(context)
        _resume(talk, resume)
        return
    if source is None:
        raise no_source("explore")
    settings = load_config(
        preset,
        config,
        {
            **reading,
            "explorer.strategy": strategy,
            "explorer.n_steps": steps,
            "explorer.regions": None if regions is None else absolute_regions(regions),
            "test.every": test_every,
            "test.gap": gap,
            "run.seed": seed,
            "run.n_threads": threads,
            "teacher.scene": scene,
            "teacher.up": up,
            "teacher.source": teacher,
        },
    )
    if test is not None and test_every is not None:
        raise ValueError("test: expected --test or --test-every, got both")
    if gap is not None and not settings.test.every:
        raise ValueError("gap: expected --test-every too, or there is nothing to keep apart")
    if test is not None:
        settings = replace(settings, test=replace(settings.test, every=0))
    folder = OutputFolder(out, "explore", source, overwrite=overwrite)
    model = None if from_ is None else load_run_model(from_)
    given = given_now("explore", source, test=test, ground_truth=ground_truth, from_=model)
    _follow_to_its_end(talk, settings, given, folder, "new")


def _resume(talk: Talk, path: Path) -> None:
    """Go on with a run, or say that it is finished; its report is made if that is missing."""
    given, folder = open_run(path, "explore")
    settings = load_config(None, path / CONFIG, {})
    summary = read_summary(path)
    if summary is None or summary.get("steps", 0) < settings.explorer.n_steps:
        _follow_to_its_end(talk, settings, given, folder, "resumed")
        return
    if not (path / REPORT).is_file():
        with announce_compilation(talk.console):
            tell_run(talk, reopened(settings, given, folder, "told"), summary)
    talk.note(f"{path}: the run is finished after {count(summary['steps'], 'step')}")


def _follow_to_its_end(
    talk: Talk, settings: Config, given: GivenCommand, folder: OutputFolder, mode: Mode
) -> None:
    """Run the loop from its beginning or from where it was ended, and tell of it."""
    with announce_compilation(talk.console):
        run = reopened(settings, given, folder, mode)
        talk.introduce(Path(given.source), run.dataset)
        _introduce(talk, run, given, settings)
        with CtrlC() as ctrl_c:
            follow(talk, run, ctrl_c)
            summary = run.finish()
            tell_run(talk, run, summary)
    talk.warn_of(run.problems, summary["distinct_frames"], "taught nothing")
    _tell_tests(talk, run)
    _tell_keeping(talk, run)
    tell_lessons(talk, run.lessons, has_learned=run.has_learned)
    times = run.times()
    content = {**summary, **times, "out": str(folder.path)}
    talk.results("explore", _rows(summary, times, folder), content)
    if ctrl_c.is_pressed:
        stopped, again = count(summary["steps"], "step"), go_on_with("explore", folder.path)
        talk.note(f"stopped after {stopped}; run and model are kept; {again}")
        raise typer.Exit(ctrl_c.status)
    if not run.has_learned:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _tell_keeping(talk: Talk, run: Exploration) -> None:
    """Tell where going on with the run is, or was, not what it should be."""
    if run.unkept is not None:
        talk.warn(f"{run.unkept}: --resume would do the whole run again, to the same end")
    if run.is_other_than_before:
        talk.warn("steps that were done again came out otherwise: is the source another one?")


def _tell_tests(talk: Talk, run: Exploration) -> None:
    """Tell what is wrong with the test frames; it is no warning where nobody asked for them."""
    n_tested = len(run.tests.truth.indices)
    if run.tests.is_asked:
        talk.warn_of_learned(run.n_learned, n_tested)
        talk.warn_of(run.tests.problems, n_tested, "could not be tested on")
        return
    for sentence in run.tests.problems.sentences(n_tested, "could not be tested on"):
        talk.note(sentence)


def _introduce(talk: Talk, run: Exploration, given: GivenCommand, settings: Config) -> None:
    """Say what the run starts from."""
    if run.so_far.n_steps:
        talk.note(f"goes on after {count(run.so_far.n_steps, 'step')}")
    elif given.from_ is not None:
        talk.note("goes on with the samples, trees and places of that model")
    for note in run.continued.notes if run.continued is not None else ():
        talk.note(note)
    if given.test is not None:
        talk.introduce(Path(given.test), run.tests.truth.dataset)
    if run.config != settings:
        talk.note("the model goes on with its own features and forest, not with these settings'")
    talk.note(
        f"{count(run.regions.n_regions, 'region')} ({run.regions.kind}), scene: "
        f"{run.survey.scene}, tested on: {tested_on(run)}"
    )
    if run.tests.unused_truth is not None:
        talk.warn(f"the ground truth cannot be tested against: {run.tests.unused_truth}")
    n_within_reach = len(run.world.views)
    if run.is_tested_on_learned:
        talk.note(
            "these frames are learned from too, as too few others would be left: the scores are "
            "too good; --test-every 10 keeps some out of learning"
        )
    elif n_within_reach < len(run.dataset):
        talk.note(
            f"learns from {n_within_reach} of {len(run.dataset)} frames; the others are "
            "tested on, or too close to those"
        )
    tested = run.tests.truth.dataset
    if run.tests.truth.kind == "teacher" and any(map(tested.has_ground_truth, range(len(tested)))):
        talk.warn("the ground truth is not of the frames that are kept for testing: not used")
    n_left_out = len(run.tests.truth.indices) - run.tests.held_out.n_frames
    if n_left_out:
        talk.note(f"  without {count(n_left_out, 'test frame')}: bad, or nothing salient in view")


def follow(talk: Talk, run: Exploration, ctrl_c: CtrlC) -> None:
    """Run the loop to its end or to Ctrl-C."""
    with talk.following("explore", run.config.explorer.n_steps) as shown:
        for _ in range(run.so_far.n_steps):
            shown.advance()
        for _, row in ctrl_c.until_pressed(run):
            name = run.regions.names[row.region] if row.region >= 0 else None
            shown.advance(describe_step(row.error, name, row.overall_error))


def tested_on(run: Exploration) -> str:
    """Say what a run is tested on, and how many frames of it."""
    if run.tests.truth.kind == "nothing":
        return "nothing"
    return f"{run.tests.truth.kind}, {count(len(run.tests.truth.indices), 'frame')}"


def _rows(summary: dict[str, Any], times: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    rows = {
        "steps": summary["steps"],
        "overall error (1 - F1)": mean_of(
            summary["overall_error"],
            summary["pooled_error"],
            summary["frames_scored"],
            summary["frames_tested"],
        ),
        "tested on": _tested_on(summary),
        "samples": tell_samples(summary["samples"], summary["places"]),
        **tell_places(summary["places"]),
    }
    rows |= tell_forgetting(summary["forgetting"])
    if summary["n_alarms"]:
        rows["places that changed"] = tell_alarms(summary["alarms"], summary["n_alarms"])
    if summary["metres"] or summary["degrees"]:  # neither is known without poses
        rows["travel"] = f"{summary['metres']:.1f} m, {summary['degrees']:.0f} degrees"
    for stage, spent in times["stages"].items():
        rows[f"{stage} (ms)"] = f"{spent['median_ms']:.1f}, p90 {spent['p90_ms']:.1f}"
    rows["written to"] = folder.path
    return rows


def _tested_on(summary: dict[str, Any]) -> str:
    n_learned = summary["test_frames_learned"]
    learned = f", {n_learned} of them learned from" if n_learned else ""
    return f"{summary['tested_on']}, {count(summary['frames_tested'], 'frame')}{learned}"
