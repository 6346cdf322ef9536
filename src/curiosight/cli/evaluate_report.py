"""Show how the learned map compares with other methods: tables, figures, and a report."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from curiosight.cli.talk import count
from curiosight.cli.versions import versions
from curiosight.evaluation import MethodScores
from curiosight.experiments.comparing import Comparison, Shown
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
    "metrics.json": "all figures, pooled and per frame, with intervals",
    "table.md, table.tex": "the table, for a text or a paper",
    "figures/": "the curves and the maps, as PNG and SVG",
    "times.json": "milliseconds an image of each method",
    "config.toml": "all settings",
}


def write_report(
    evaluation: Evaluation | CrossValidation,
    metrics: Mapping[str, Any],
    folder: OutputFolder,
    command: Sequence[str],
) -> None:
    """Write tables, figures, times and report.html of a comparison.

    metrics: what `evaluation.metrics()` returned. command: that makes it again.
    """
    comparison = evaluation.comparison
    assert comparison is not None
    times_ms = comparison.times_ms()
    methods = method_results(comparison, metrics["methods"], times_ms)
    wall = [_row(shown, comparison.threshold) for shown in comparison.shown]
    folder.write_json("times.json", times_ms)
    folder.write_text("table.md", markdown_table(methods))
    folder.write_text("table.tex", latex_table(methods))
    for ending in ("png", "svg"):
        draw_roc(methods, folder.file(f"figures/roc.{ending}"))
        draw_precision_recall(methods, folder.file(f"figures/precision_recall.{ending}"))
        if wall:
            draw_wall(wall, folder.file(f"figures/maps.{ending}"))
    report = ComparisonReport(
        title=f"Saliency on {metrics['source']}",
        sentence=_sentence(methods, comparison, metrics),
        methods=methods,
        wall=wall,
        facts=dict(_facts(evaluation, metrics)),
        command=shlex.join(command),
        problems=list(_problems(evaluation, comparison)),
        limits=list(_limits(metrics)),
        files=_FILES,
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
    return [
        _result(name, scores, tables[name], times_ms.get(name), comparison.ours)
        for name, scores in comparison.scores.items()
        if name in tables
    ]


def _result(
    name: str,
    scores: MethodScores,
    table: Mapping[str, Any],
    times_ms: Mapping[str, float] | None,
    ours: str,
) -> MethodResult:
    pooled = table["pooled"]
    figures = {key: pooled["all"][key] for key in _POOLED}
    figures |= {"overall_error": table["overall_error"], **table["objects"]}
    figures |= {f"roc_auc_{part}": numbers["roc_auc"] for part, numbers in pooled.items()}
    return MethodResult(
        name=name,
        is_ours=name == ours,
        figures={column.key: figures.get(column.key) for column in COLUMNS},
        intervals={
            c.key: table["intervals"][c.key] for c in COLUMNS if c.key in table["intervals"]
        },
        roc=scores.maps.ranking().roc,
        precision_recall=scores.precision_recall(),
        ms=None if times_ms is None else times_ms["median_ms"],
    )


def _shown_of(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return those that have a column."""
    return {column.key: figures[column.key] for column in COLUMNS if column.key in figures}


def _row(shown: Shown, threshold: float) -> WallRow:
    return WallRow(shown.id, shown.rgb, shown.truth, shown.maps, threshold)


def _sentence(
    methods: Sequence[MethodResult], comparison: Comparison, metrics: Mapping[str, Any]
) -> str:
    aucs = {method.name: method.figures["roc_auc"] for method in methods}
    known = {name: auc for name, auc in aucs.items() if auc is not None}
    frames = count(metrics["n_frames"], "frame")
    text = f"{count(len(methods), 'method')} on the same {frames}, against {metrics['truth']}."
    ours, others = known.pop(comparison.ours, None), known
    if ours is None or not others:
        return text
    best = max(others, key=lambda name: others[name])
    return (
        f"{text} The area under the ROC curve of the learned map is {ours:.3f}; "
        f"of the best of the others, {best}, {others[best]:.3f}."
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
    yield "preset", evaluation.config.preset
    yield "seed", str(evaluation.config.run.seed)
    yield "intervals", "95 %, bootstrap over frames"
    yield "versions", ", ".join(versions())


def _problems(evaluation: Evaluation | CrossValidation, comparison: Comparison) -> Iterator[str]:
    n_frames = len(evaluation.truth.dataset)
    yield from evaluation.problems.sentences(n_frames, "could not be used")
    yield from failures(comparison)
    if evaluation.n_learned:
        tested = count(len(evaluation.truth.indices), "test frame")
        yield f"{evaluation.n_learned} of {tested} were learned from: the scores are too good."


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
    yield (
        "The learned map has seen this room; the others have not, and cannot learn it. That is "
        "what is compared, not which method is best on any image."
    )
    yield (
        "F, E, S and weighted F stretch each map to reach from 0 to 1, as is usual; ROC, average "
        "precision and F1 take the frames together, so they also ask that a map's levels mean "
        "the same in every frame."
    )
    yield "Intervals tell how much other such frames would change a figure, not other rooms."
