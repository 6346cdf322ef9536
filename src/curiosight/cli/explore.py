"""curiosight explore: the loop on a recording."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.again import command_again
from curiosight.cli.explore_examples import example_of
from curiosight.cli.explore_report import LEFTOVERS, REPORT, draw_figures, exploration_report
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import (
    LEARNED_NOTHING_STATUS,
    tell_lessons,
    tell_places,
    tell_samples,
)
from curiosight.cli.mean_error import mean_of
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import Config, load_config
from curiosight.experiments.exploring import Exploration, load_run_model
from curiosight.experiments.output import OutputFolder
from curiosight.explore import Step
from curiosight.viewing.live import announce_compilation, describe_step
from curiosight.viewing.report import write_report
from curiosight.worlds.sources import open_source

N_EXAMPLES = 4
EXPLORING = "Exploring"
TESTING = "Testing"


@reads_source
def explore(
    source: options.Source,
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
            help="Go on with the model of an earlier run.",
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
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Explore a recording: look, predict, compare with depth, learn, choose where to look next.

    Writes report.html to look at first, config.toml, steps.csv, decisions.csv, timings.csv,
    model.npz, summary.json and figures/. Ctrl-C, or a signal to end (SIGTERM, SIGHUP), ends a
    run early and keeps all of it; model.npz is written every 50 looks or 30 s too, summary.json
    only at the end. Exit status 1: nothing was learned.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(
        preset,
        config,
        {
            **reading,
            "explorer.strategy": strategy,
            "explorer.n_steps": steps,
            "explorer.regions": regions,
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
    opened = partial(open_source, reading=settings.reading)
    dataset = opened(source, ground_truth=ground_truth if test is None else None)
    test_source = None if test is None else opened(test, ground_truth=ground_truth)
    continued = None if from_ is None else load_run_model(from_)
    with announce_compilation(talk.console):
        run = Exploration(
            settings,
            dataset,
            folder,
            test_source=test_source,
            continued=continued,
            leftovers=LEFTOVERS,
        )
        talk.introduce(source, dataset)
        _introduce(talk, run, test, settings)
        with CtrlC() as ctrl_c:
            examples = follow(talk, run, ctrl_c)
            summary = run.finish()
            taught = [example_of(run, step) for step in examples]
            draw_figures(run, folder, taught)
            given = {"test": test, "ground-truth": ground_truth, "from": from_}
            again = command_again("explore", [source], given)
            write_report(exploration_report(run, summary, taught, again), folder.file(REPORT))
    talk.warn_of(run.problems, summary["distinct_frames"], "taught nothing")
    _tell_tests(talk, run)
    tell_lessons(talk, run.lessons, has_learned=run.has_learned)
    talk.results("explore", _rows(summary, folder), {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(len(run.rows), 'step')}; run and model are kept")
        raise typer.Exit(ctrl_c.status)
    if not run.has_learned:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _tell_tests(talk: Talk, run: Exploration) -> None:
    """Tell what is wrong with the test frames; it is no warning where nobody asked for them."""
    n_tested = len(run.truth.indices)
    if run.is_test_asked:
        talk.warn_of_learned(run.n_learned, n_tested)
        talk.warn_of(run.test_problems, n_tested, "could not be tested on")
        return
    for sentence in run.test_problems.sentences(n_tested, "could not be tested on"):
        talk.note(sentence)


def _introduce(talk: Talk, run: Exploration, test: Path | None, settings: Config) -> None:
    """Say what the run starts from."""
    if test is not None:
        talk.introduce(test, run.truth.dataset)
    if run.config != settings:
        talk.note("the model goes on with its own features and forest, not with these settings'")
    talk.note(
        f"{count(run.regions.n_regions, 'region')} ({run.regions.kind}), scene: "
        f"{run.survey.scene}, tested on: {tested_on(run)}"
    )
    if run.unused_truth is not None:
        talk.warn(f"the ground truth cannot be tested against: {run.unused_truth}")
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
    tested = run.truth.dataset
    if run.truth.kind == "teacher" and any(map(tested.has_ground_truth, range(len(tested)))):
        talk.warn("the ground truth is not of the frames that are kept for testing: not used")
    n_left_out = len(run.truth.indices) - run.held_out.n_frames
    if n_left_out:
        talk.note(f"  without {count(n_left_out, 'test frame')}: bad, or nothing salient in view")


def follow(talk: Talk, run: Exploration, ctrl_c: CtrlC) -> list[Step]:
    """Run the loop to its end or to Ctrl-C; return some of its last steps."""
    n_steps = run.config.explorer.n_steps
    examples: list[Step] = []
    with talk.following("explore", n_steps) as shown:
        for step, row in ctrl_c.until_pressed(run):
            name = run.regions.names[row.region] if row.region >= 0 else None
            shown.advance(describe_step(row.error, name, row.overall_error))
            if step.observation.error is not None:
                examples = _keep_spread(examples, step, n_steps)
    return examples


def _keep_spread(examples: list[Step], step: Step, n_steps: int) -> list[Step]:
    """Keep the latest step of every quarter of the run, each frame once."""
    quarter = step.index * N_EXAMPLES // n_steps
    others = [kept for kept in examples if kept.index * N_EXAMPLES // n_steps != quarter]
    if any(kept.viewpoint.index == step.viewpoint.index for kept in others):
        return examples
    return [*others, step]


def tested_on(run: Exploration) -> str:
    """Say what a run is tested on, and how many frames of it."""
    if run.truth.kind == "nothing":
        return "nothing"
    return f"{run.truth.kind}, {count(len(run.truth.indices), 'frame')}"


def _rows(summary: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
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
    if summary["metres"] or summary["degrees"]:  # neither is known without poses
        rows["travel"] = f"{summary['metres']:.1f} m, {summary['degrees']:.0f} degrees"
    for stage, spent in summary["stages"].items():
        rows[f"{stage} (ms)"] = f"{spent['median_ms']:.1f}, p90 {spent['p90_ms']:.1f}"
    rows["written to"] = folder.path
    return rows


def _tested_on(summary: dict[str, Any]) -> str:
    n_learned = summary["test_frames_learned"]
    learned = f", {n_learned} of them learned from" if n_learned else ""
    return f"{summary['tested_on']}, {count(summary['frames_tested'], 'frame')}{learned}"
