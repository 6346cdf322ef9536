"""Show how the learned map compares with other methods: tables, figures, and a report."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from curiosight.cli.lessons import lesson_problems
from curiosight.cli.talk import NO_CLASSES, NOTHING_LEARNED, count, scores_are_too_good
from curiosight.cli.versions import versions
from curiosight.evaluation import MethodScores
from curiosight.experiments.comparing import DEPTH, Comparison, Shown
from curiosight.experiments.evaluating import CrossValidation, Evaluation
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.comparison import (
    COLUMNS,
    ComparisonReport,
    MethodResult,
    WallRow,
    draw_precision_recall,
    draw_roc,
    draw_wall,
    latex_table,
    markdown_table,
    write_comparison,
)

# Where a column's figure is found in a method's table.
_POOLED = ("roc_auc", "average_precision", "best_f1", "f1")
_FILES = {
    "roc.png": "the learned map's curves, by what depth could say",
    "reliability.png": "how far probabilities hold",
    "metrics.json": "all figures, pooled and per frame, with intervals",
    "table.md, table.tex": "the table, for a text or a paper",
    "figures/": "the curves and the maps, as PNG and SVG",
    "times.json": "milliseconds an image of each method",
    "config.toml": "all settings",
}
_NOT_DRAWN = ("metrics.json", "table.md, table.tex", "times.json", "config.toml")


def write_report(
    evaluation: Evaluation | CrossValidation,
    comparison: Comparison,
    metrics: Mapping[str, Any],
    folder: OutputFolder,
    command: Sequence[str],
    *,
    has_figures: bool,
) -> None:
    """Write tables, figures, times and report.html of an evaluation's comparison.

    metrics: what `evaluation.metrics()` returned. command: that makes it again. has_figures:
    whether the curves and the maps are drawn as files, too.
    """
    times_ms = comparison.times_ms()
    methods = method_results(comparison, metrics["methods"], times_ms)
    wall = [_row(shown, comparison.threshold) for shown in comparison.shown]
    folder.write_json("times.json", times_ms)
    folder.write_text("table.md", markdown_table(methods))
    folder.write_text("table.tex", latex_table(methods))
    for ending in ("png", "svg") if has_figures else ():
        draw_roc(methods, folder.file(f"figures/roc.{ending}"))
        draw_precision_recall(methods, folder.file(f"figures/precision_recall.{ending}"))
        if wall:
            draw_wall(wall, folder.file(f"figures/maps.{ending}"))
    report = ComparisonReport(
        title=f"Saliency on {metrics['source']}",
        sentence=_sentence(comparison.ours, metrics),
        methods=methods,
        wall=wall,
        facts=dict(_facts(evaluation, metrics)),
        command=shlex.join(command),
        problems=list(_problems(evaluation, comparison, metrics)),
        limits=list(_limits(metrics)),
        files=_FILES if has_figures else {name: _FILES[name] for name in _NOT_DRAWN},
        reliability=evaluation.at_hand.curves(),
    )
    write_comparison(report, folder.file("report.html"))


def method_results(
    comparison: Comparison,
    tables: Mapping[str, Any],
    times_ms: Mapping[str, Mapping[str, float]],
) -> list[MethodResult]:
    """Return what each method reached, ours first.

    tables, times_ms: what `comparison.metrics()` and `.times_ms()` returned.
    """
    n_frames = tables[comparison.ours]["n_frames"]
    results = []
    for name, scores in comparison.scores.items():
        if name in tables:
            n_own = tables[name]["n_frames"]
            title = name if n_own == n_frames else f"{name} ({n_own} of {n_frames} frames)"
            is_ours = name == comparison.ours
            results.append(_result(title, is_ours, scores, tables[name], times_ms.get(name)))
    return results


def _result(
    name: str,
    is_ours: bool,
    scores: MethodScores,
    table: Mapping[str, Any],
    times_ms: Mapping[str, float] | None,
) -> MethodResult:
    pooled = table["pooled"]
    figures = {key: pooled["all"][key] for key in _POOLED}
    figures |= {"overall_error": table["overall_error"], **table["objects"]}
    figures |= {f"roc_auc_{part}": numbers["roc_auc"] for part, numbers in pooled.items()}
    return MethodResult(
        name=name,
        is_ours=is_ours,
        figures=_shown_of(figures),
        intervals=_shown_of(table["intervals"]),
        roc=scores.maps.ranking().roc,
        precision_recall=scores.precision_recall(),
        ms=None if times_ms is None else times_ms["median_ms"],
    )


def _shown_of(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return those that have a column."""
    return {column.key: figures[column.key] for column in COLUMNS if column.key in figures}


def _row(shown: Shown, threshold: float) -> WallRow:
    return WallRow(shown.id, shown.rgb, shown.truth, shown.maps, threshold)


def _sentence(ours: str, metrics: Mapping[str, Any]) -> str:
    tables = metrics["methods"]
    frames = count(metrics["n_frames"], "frame")
    truth = "what depth says" if metrics["truth"] == "teacher" else metrics["truth"]
    text = f"{count(len(tables), 'method')} on the same {frames}, against {truth}."
    aucs = {
        name: table["pooled"]["all"]["roc_auc"]
        for name, table in tables.items()
        if table["n_frames"] == metrics["n_frames"]
    }
    if aucs.pop(ours) is None or not aucs:
        return text
    best = max(aucs, key=lambda name: aucs[name])
    return (
        f"{text} The area under the ROC curve of the learned map is "
        f"{metrics['pooled']['all']['roc_auc']:.3f}; "
        f"of the best of the others, {best}, {aucs[best]:.3f}."
    )


def _facts(
    evaluation: Evaluation | CrossValidation, metrics: Mapping[str, Any]
) -> Iterator[tuple[str, str]]:
    yield "source", str(metrics["source"])
    yield "tested on", f"{metrics['truth']}, {count(metrics['n_frames'], 'frame')}"
    if "model" in metrics:
        yield "model", str(metrics["model"])
    else:
        yield "split", f"{metrics['folds']} folds of {metrics['split']}"
    if isinstance(evaluation, CrossValidation):
        lessons = evaluation.off_line.lessons
        yield "looks that taught nothing about objects", lessons.in_short()
    yield "preset", evaluation.config.preset
    yield "seed", str(evaluation.config.run.seed)
    yield "intervals", "95 %, bootstrap over frames"
    yield "versions", ", ".join(versions())


def _problems(
    evaluation: Evaluation | CrossValidation, comparison: Comparison, metrics: Mapping[str, Any]
) -> Iterator[str]:
    n_frames = len(evaluation.truth.dataset)
    yield from evaluation.problems.sentences(n_frames, "could not be used")
    yield from failures(comparison)
    if isinstance(evaluation, CrossValidation):
        has_learned = evaluation.n_untrained < len(evaluation.folds)
        yield from lesson_problems(evaluation.off_line.lessons, has_learned=has_learned)
    elif not evaluation.learner.is_trained:
        yield NOTHING_LEARNED
    if metrics["pooled"]["all"]["roc_auc"] is None:
        yield NO_CLASSES
    if evaluation.n_learned:
        yield scores_are_too_good(evaluation.n_learned, len(evaluation.truth.indices))


def failures(comparison: Comparison) -> Iterator[str]:
    """Yield a sentence for each method that could not map every frame."""
    for method, why, n_frames in comparison.failures:
        yield f"{method}: no map of {count(n_frames, 'frame')}: {why}"


def _limits(metrics: Mapping[str, Any]) -> Iterator[str]:
    if metrics["truth"] == "teacher":
        yield (
            "There was no ground truth: every method was tested against what depth says. Where "
            "that is wrong or silent, this page cannot tell."
        )
    if metrics["frames_scored"] < metrics["n_frames"]:
        yield (
            f"Overall error is the mean over the {metrics['frames_scored']} of "
            f"{count(metrics['n_frames'], 'frame')} that show something salient; the others have "
            "no F1 (0/0), as with the paper's authors. ROC, average precision and F1 count all."
        )
    if DEPTH in metrics["methods"]:
        yield (
            "“depth” is what the teacher says of these very frames, noise where it says nothing, "
            "with what it knows of the whole recording: more than the others are shown."
        )
    yield (
        "The learned map was taught by depth where it learned; the others were taught nothing "
        "there. That is what is compared, not which method is best on any image."
    )
    yield (
        "Fβ, E, S, weighted F and MAE stretch each map to reach from 0 to 1, as is usual; ROC, "
        "average precision and F1 take the frames together, so they also ask that a map's levels "
        "mean the same in every frame."
    )
    yield "Intervals tell how much other such frames would change a figure, not other rooms."
