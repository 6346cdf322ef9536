"""Draw what an exploration did: its figures, and the report that a person opens first."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

from curiosight.cli.explore_examples import unseen_examples
from curiosight.cli.forgetting import forgetting_tables
from curiosight.cli.lessons import lesson_problems
from curiosight.cli.talk import count, scores_are_too_good
from curiosight.cli.versions import versions
from curiosight.config import to_toml
from curiosight.errors import printable
from curiosight.experiments.exploring import DECISIONS, Exploration
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.steps import StepRow
from curiosight.explorer.from_above import seen_from_above
from curiosight.rooms import DrawnViews
from curiosight.viewing.examples import Example
from curiosight.viewing.examples import examples as draw_examples
from curiosight.viewing.figures import learning_curve, time_per_region
from curiosight.viewing.region_map import regions_from_above
from curiosight.viewing.report import (
    ExampleGroup,
    Footprint,
    Making,
    Report,
    ResultRow,
    Results,
    RoomMap,
)

UP = (0, 0, 1)  # of drawn rooms
# Of an earlier run, written again at the end of this one.
LEFTOVERS = (
    "report.html",
    "figures/learning_curve.png",
    "figures/time_per_region.png",
    "figures/regions.png",
    "figures/examples.png",
)
N_LOOKS = 10  # that the errors at first and at the end are means of
REPORT = "report.html"
_WAYS = {
    "chronological": "in the order of the recording",
    "random": "looking around at random",
    "random-region": "each region as likely as another",
    "sweep": "from region to region, the nearest first",
    "coverage": "always at the nearest view that it had not seen",
    "iac": "going where it learned fastest",
    "rl-iac": "going where it would learn fastest, ways counted",
    "error": "going where it was wrong",
    "novelty": "going where it had looked least",
    "uncertainty": "going where it was unsure",
    "forgetting": "going where it had not been for long",
    "progress-forgetting": "going where the error falls, or where it had not been for long",
    "progress-rate": "going where a second was expected to teach most",
}
_POSE_REGIONS = (
    "A region is a part of the floor, x counted from the left and y from below, and there a range "
    "of headings, counted counter-clockwise."
)
_STAGES = {
    "capture": "read the frame",
    "describe": "describe its colours",
    "segment": "teacher: label it from depth",
    "predict": "predict from colour",
    "learn": "learn",
    "test": "test",
}
_FILES = {
    "steps.csv": "every step: frame, region, errors, learning progress",
    "decisions.csv": "what was weighed each time a region was chosen, and why it was that one",
    "timings.csv": "milliseconds of every step",
    "summary.json": "the results, for programs",
    "timings.json": "what the clock told of it",
    "config.toml": "all settings",
    "command.json": "source and recordings, to go on with the run or to tell of it again",
    "model.npz": "the model, to map or evaluate with, or to go on from",
    "figures/": "the figures as PNG",
}


def exploration_report(
    run: Exploration, summary: dict[str, Any], taught: Sequence[Example], command: Sequence[str]
) -> Report:
    """Tell an exploration as a report.

    summary: what `Exploration.finish` returned, and the run's `times`.
    taught: examples that were learned from. command: that runs it again from this folder.
    """
    unseen = list(unseen_examples(run)) if not run.n_learned else []
    rows = run.rows
    return Report(
        title=f"A look around {Path(summary['source']).name}",
        sentence=_sentence(run, summary, rows),
        took=took(summary["seconds"]),
        results=[_results(run, summary, rows), *forgetting_tables(summary["forgetting"])],
        examples=[
            ExampleGroup("Views it never learned from", unseen),
            ExampleGroup("Views it learned from", taught),
        ],
        steps=rows,
        region_names=run.regions.names,
        decisions=run.last_decisions,
        region_note=_POSE_REGIONS if run.regions.kind.startswith("pose") else "",
        events=[event.sentence for event in run.so_far.events],
        room_map=_room_map(run, rows),
        making=_making(run, summary, command),
        problems=list(_problems(run, summary)),
        limits=list(_limits(run)),
    )


def draw_figures(run: Exploration, folder: OutputFolder, taught: Sequence[Example]) -> None:
    """Write the figures of an exploration as PNG; taught: examples that were learned from."""
    rows, names = run.rows, run.regions.names
    learning_curve(rows, folder.file("figures/learning_curve.png"))
    time_per_region(rows, names, folder.file("figures/time_per_region.png"))
    regions_from_above(
        run.dataset.poses,
        run.regions,
        _visited(run, rows),
        folder.file("figures/regions.png"),
        up=run.survey.up_world,
    )
    if taught:
        draw_examples(taught, folder.file("figures/examples.png"))


def _room_map(run: Exploration, rows: Sequence[StepRow]) -> RoomMap:
    """Return where the run looked; of a drawn room also what stands there."""
    visited = _visited(run, rows)
    if not isinstance(run.dataset, DrawnViews):
        views = seen_from_above(run.dataset.poses, run.survey.up_world)
        return RoomMap(views, run.regions.of_view, visited)
    standing = run.dataset.footprints
    footprints = [Footprint(one.name, one.polygon, is_object=one.is_object) for one in standing]
    return RoomMap(
        seen_from_above(run.dataset.poses, UP),
        run.regions.of_view,
        visited,
        outlines=run.dataset.outlines,
        footprints=footprints,
    )


def _visited(run: Exploration, rows: Sequence[StepRow]) -> list[int]:
    """Return the view of each step."""
    indices = {printable(id): index for index, id in enumerate(run.dataset.ids)}
    return [indices[row.id] for row in rows]


def _sentence(run: Exploration, summary: dict[str, Any], rows: Sequence[StepRow]) -> str:
    name = summary["strategy"]
    way = _WAYS.get(name.partition(":")[0], f"as {name} told it")
    sentence = (
        f"curiosight looked at {count(summary['steps'], 'frame')} in "
        f"{count(run.regions.n_regions, 'region')}, {way}, and learned from depth how objects "
        "look in colour."
    )
    if len(summary["places"]) > 1:
        n_views = ", ".join(map(str, summary["places"]))
        sentence += f" It told {count(len(summary['places']), 'place')} apart ({n_views} views)."
    errors = _known(rows, "overall_error")
    if not errors:
        return sentence
    tests = run.tests.held_out
    frames = count(tests.n_frames, "test frame")
    if tests.n_frames < tests.n_given:
        frames = f"the {tests.n_frames} of {tests.n_given} test frames with objects"
    unseen = "" if run.n_learned else " it never learned from"
    return (
        f"{sentence} On {frames}{unseen}, its error went from {errors[0]:.2f} after the first "
        f"look to {errors[-1]:.2f}."
    )


def took(seconds: float) -> str:
    """Say how long a run took."""
    text = f"{seconds / 60:.1f} minutes" if seconds >= 120 else f"{seconds:.0f} seconds"
    return f"It took {text}."


def _results(run: Exploration, summary: dict[str, Any], steps: Sequence[StepRow]) -> Results:
    rows = []
    if errors := _known(steps, "overall_error"):
        note = (
            f"against {'what depth says' if run.tests.truth.kind == 'teacher' else 'ground truth'}"
        )
        if n_left_out := len(run.tests.truth.indices) - run.tests.held_out.n_frames:
            note += f"; {count(n_left_out, 'other')} bad, or without anything salient in view"
        name = f"error, mean of {count(run.tests.held_out.n_frames, 'test frame')}"
        rows.append(ResultRow(name, (f"{errors[0]:.2f}", f"{errors[-1]:.2f}"), note))
        pooled = summary["pooled_error"]
        name = f"error, {count(run.tests.held_out.n_given, 'test frame')} pooled"
        note = "false alarms where nothing salient is in view count too"
        rows.append(ResultRow(name, ("", "" if pooled is None else f"{pooled:.2f}"), note))
    if errors := _known(steps, "error"):
        n_looks = max(1, min(N_LOOKS, len(errors) // 2))
        values = (f"{fmean(errors[:n_looks]):.2f}", f"{fmean(errors[-n_looks:]):.2f}")
        note = f"against what depth says, mean of {count(n_looks, 'look')}"
        rows.append(ResultRow("error of a look, before learning from it", values, note))
    return Results("Error, 0 is best and 1 is worst", ("at first", "at the end"), tuple(rows))


def _known(rows: Sequence[StepRow], column: str) -> list[float]:
    values = (getattr(row, column) for row in rows)
    return [value for value in values if value is not None]


def _making(run: Exploration, summary: dict[str, Any], command: Sequence[str]) -> Making:
    config = run.config
    facts = {
        "source": f"{summary['source']} ({summary['layout']}, {count(len(run.dataset), 'frame')})",
        "scene": f"{summary['scene']}, as the teacher took it",
        "strategy": config.explorer.strategy,
        "regions": f"{run.regions.n_regions} ({run.regions.kind})",
        "seed": str(config.run.seed),
        "preset": config.preset,
        "tested on": f"{run.tests.truth.kind}, {count(run.tests.held_out.n_given, 'frame')}",
        "looks that taught nothing about objects": run.lessons.in_short(),
        "versions": ", ".join(versions()),
    }
    if summary["metres"] or summary["degrees"]:
        facts["travel"] = f"{summary['metres']:.1f} m, {summary['degrees']:.0f}°"
    times_ms = {
        _STAGES.get(stage, stage): spent["median_ms"]
        for stage, spent in summary["stages"].items()
        if stage != "test" or run.tests.truth.indices
    }
    files = {name: what for name, what in _FILES.items() if name != DECISIONS or run.last_decisions}
    return Making(shlex.join(command), facts, to_toml(config), times_ms, files)


def _problems(run: Exploration, summary: dict[str, Any]) -> Iterator[str]:
    yield from run.problems.sentences(summary["distinct_frames"], "taught nothing")
    yield from run.tests.problems.sentences(len(run.tests.truth.indices), "could not be tested on")
    if run.n_learned:
        yield scores_are_too_good(run.n_learned, len(run.tests.truth.indices))
    yield from lesson_problems(run.lessons, has_learned=run.has_learned)


def _limits(run: Exploration) -> Iterator[str]:
    if run.tests.truth.kind == "teacher":
        yield (
            "There was no ground truth: the model was tested against what depth says of the test "
            "frames. Where that is wrong or silent, as beyond its range, this page cannot tell."
        )
    if run.tests.truth.kind == "nothing":
        yield (
            "No frames were kept for testing: errors are those of each frame before the model "
            "learned from it, against what depth says. The option --test-every 10 keeps some."
        )
    if run.config.learner.follow_edges:
        yield (
            "Errors are of superpixels, before maps follow the edges of the image: `curiosight "
            "evaluate` scores the maps themselves, and tells somewhat other errors."
        )
    if run.tests.held_out.n_given > run.tests.held_out.n_frames > 0:
        yield (
            "The mean error is of the test frames that show something salient; the others have no "
            "F1 (0/0), as with the paper's authors. What is marked in them counts in the pooled "
            "error."
        )
    if not any(pose is not None for pose in run.dataset.poses):
        yield "The recording has no poses, so there is no map."
    yield "It is one run with one seed; another seed gives somewhat other errors."
