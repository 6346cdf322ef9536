"""curiosight demo: everything once, in a room that the program draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.explore import follow
from curiosight.cli.explore_examples import taught_examples
from curiosight.cli.explore_report import (
    LEFTOVERS,
    REPORT,
    draw_figures,
    exploration_report,
    took,
)
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import LEARNED_NOTHING_STATUS, tell_lessons, tell_places
from curiosight.cli.mean_error import mean_of
from curiosight.cli.talk import Talk, count, format_value
from curiosight.config import load_config
from curiosight.experiments.demonstrating import (
    BASELINE,
    WHERE,
    Demonstration,
    Tested,
    draw_demo_room,
)
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.examples import Example
from curiosight.viewing.examples import examples as draw_examples
from curiosight.viewing.live import announce_compilation
from curiosight.viewing.report import ExampleGroup, Report, ResultRow, Results, write_report

N_STEPS = 150
N_EXAMPLES = 4
_AFTER_MOVE = "figures/after_move.png"
_FILES = {"demo.json": "the same of the whole demo, with the scores after the move"}


def demo(
    seed: Annotated[
        int, typer.Option(help="Of the room and of all chance.", rich_help_panel=options.SETTINGS)
    ] = 7,
    steps: Annotated[
        int, typer.Option(help="How many times to look.", rich_help_panel=options.SETTINGS)
    ] = N_STEPS,
    preset: options.Preset = None,
    threads: options.Threads = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
) -> None:
    """Learn in a drawn room, then find its things again after they were moved.

    Needs no data and no camera. Writes what `explore` writes, demo.json, and report.html, which
    is the thing to open.
    """
    talk = Talk(quiet=quiet, as_json=json)
    changes = {"explorer.n_steps": steps, "run.seed": seed, "run.n_threads": threads}
    settings = load_config(preset, None, changes)
    command = ["curiosight", "demo", "--seed", str(seed), "--steps", str(steps)]
    command += [] if preset is None else ["--preset", preset]
    folder = OutputFolder(out, "demo", Path(f"room:{seed}"), overwrite=overwrite)
    with announce_compilation(talk.console):
        views = draw_demo_room(seed)
        talk.note(f"{views.path}: {views.remarks[0]}")
        talk.note("lighting it, before and after the move, and surveying it")
        run = Demonstration(settings, views, folder, leftovers=(*LEFTOVERS, _AFTER_MOVE))
        with CtrlC() as ctrl_c:
            follow(talk, run.exploration, ctrl_c)
            tested = [] if ctrl_c.is_pressed else _test(talk, run, ctrl_c)
            summary = run.finish()
            _write_report(talk, run, summary, tested, folder, command)
    explored = run.exploration
    tell_lessons(talk, explored.lessons, has_learned=explored.has_learned)
    times = explored.times()
    content = {**summary, "explored": {**summary["explored"], **times}, "out": str(folder.path)}
    talk.results("demo", _rows(summary, times, folder.path / REPORT), content)
    if ctrl_c.is_pressed:
        stopped = count(summary["explored"]["steps"], "step")
        if summary["views_after_move"]:
            stopped += f" and {count(summary['views_after_move'], 'test view')} after the move"
        talk.note(f"stopped after {stopped}; all is kept, figures are of these")
        raise typer.Exit(ctrl_c.status)
    if not explored.has_learned:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _test(talk: Talk, run: Demonstration, ctrl_c: CtrlC) -> list[Tested]:
    """Look around in the rearranged room; return some of what was seen."""
    n_views = len(run.rearranged)
    every = max(1, n_views // N_EXAMPLES)
    shown_views = []
    talk.note("the things are moved, some taken away, others brought")
    with talk.following("test", n_views) as shown:
        for number, tested in enumerate(ctrl_c.until_pressed(run.test_rearranged())):
            shown.advance()
            if number % every == every // 2:
                shown_views.append(tested)
    return shown_views


def _write_report(
    talk: Talk,
    run: Demonstration,
    summary: dict[str, Any],
    tested: Sequence[Tested],
    folder: OutputFolder,
    command: Sequence[str],
) -> None:
    """Draw the figures and the report, with some of the looks and tests as examples."""
    taught = taught_examples(run.exploration)
    moved = [_example_of(run, view) for view in tested]
    if talk.can_draw():
        draw_figures(run.exploration, folder, taught)
        if moved:
            draw_examples(moved, folder.file(_AFTER_MOVE))
    explored = {**summary["explored"], **run.exploration.times()}
    report = exploration_report(run.exploration, explored, taught, command)
    write_report(demo_report(report, summary, moved), folder.file(REPORT))


def _example_of(run: Demonstration, tested: Tested) -> Example:
    frame = tested.look.frame
    segmentation = run.exploration.teacher.segment(frame)
    return Example(frame.id, frame.rgb, segmentation, tested.saliency, tested.look.truth)


def demo_report(report: Report, summary: dict[str, Any], moved: Sequence[Example]) -> Report:
    """Tell what an exploration's report does not: how it went after the things were moved."""
    making = report.making and replace(report.making, files={**report.making.files, **_FILES})
    tested = [_results(summary)] if summary["views_after_move"] else []
    before = [replace(group, title=f"Before: {group.title.lower()}") for group in report.examples]
    after = ExampleGroup("After the things were moved: views never seen before", moved)
    return replace(
        report,
        title="A robot learns what stands about in a room",
        sentence=_sentence(summary),
        took=took(summary["seconds"]),
        results=[*tested, *report.results],
        examples=[after, *before],
        making=making,
    )


def _sentence(summary: dict[str, Any]) -> str:
    before, after = summary["overall_error_before_move"], summary["overall_error_after_move"]
    sentence = (
        "In a room that it drew itself, curiosight looked around "
        f"{summary['explored']['steps']} times, where it learned fastest. Its depth camera showed "
        "what an object is; from that it learned what objects look like here."
    )
    if after is None or before is None:
        return sentence
    return (
        f"{sentence} Then the things were moved. In {summary['views_after_move']} views it never "
        f"saw it finds them by colour alone, with an error of {after:.2f} (mean of the "
        f"{summary['frames_scored_after_move']} with anything to find); it was {before:.2f} "
        "before the move."
    )


def _results(summary: dict[str, Any]) -> Results:
    ours, baseline = summary["roc_auc_after_move"], summary["baseline_roc_auc_after_move"]
    rows = [
        ResultRow(where, (format_value(ours[part]), format_value(baseline[part])))
        for part, where in WHERE.items()
    ]
    title = "After the move: objects told from the rest (ROC AUC: 1 best, 0.5 blind)"
    return Results(title, ("curiosight", BASELINE), tuple(rows))


def _rows(summary: dict[str, Any], times: dict[str, Any], report: Path) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    explored = summary["explored"]
    rows: dict[str, Any] = {
        "overall error (1 - F1)": mean_of(
            explored["overall_error"],
            explored["pooled_error"],
            explored["frames_scored"],
            explored["frames_tested"],
            "view",
        ),
        "after things were moved": mean_of(
            summary["overall_error_after_move"],
            summary["pooled_error_after_move"],
            summary["frames_scored_after_move"],
            summary["views_after_move"],
            "view",
        ),
    }
    ours, baseline = summary["roc_auc_after_move"], summary["baseline_roc_auc_after_move"]
    for part, where in WHERE.items() if summary["views_after_move"] else ():
        beside = f"{format_value(ours[part])}, {BASELINE} {format_value(baseline[part])}"
        rows[f"ROC AUC, {where}"] = beside
    rows |= tell_places(explored["places"])
    for stage, spent in times["stages"].items():
        rows[f"{stage} (ms)"] = f"{spent['median_ms']:.1f}, p90 {spent['p90_ms']:.1f}"
    rows["seconds"] = f"{summary['seconds']:.0f}"
    rows["open"] = report
    return rows
