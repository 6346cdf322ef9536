"""Figures 2 to 5: what maps look like, how well they rank, and how one comes about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from curiosight.cli.evaluate_report import method_results
from curiosight.cli.figures_files import CannotDrawError, FigureFiles
from curiosight.experiments.comparing import Comparison
from curiosight.experiments.paper_figures.claims import Claim, claims_of_roc
from curiosight.experiments.paper_figures.evolution import Snapshot, Target
from curiosight.experiments.paper_figures.subject import Subject, example_row
from curiosight.viewing.comparison import WallRow, draw_roc, draw_wall
from curiosight.viewing.evolution import MapThen, evolution
from curiosight.viewing.examples import Example, examples


def draw_examples(subject: Subject, files: FigureFiles) -> None:
    """Draw figure 2: image, labels, map and truth of some test frames."""
    shown, rows = [], []
    for index in subject.shown:
        frame = subject.truth.dataset[index]
        if frame.problem is not None:
            continue
        told, saliency = subject.teacher.segment(frame), subject.saliency(frame)
        truth = subject.truth.dataset.ground_truth(index) if subject.has_truth else None
        shown.append(Example(frame.id, frame.rgb, told, saliency, truth))
        rows.append(example_row(frame.id, told.labels, saliency, truth))
    if not shown:
        raise CannotDrawError("no test frame can be used")
    files.save(2, lambda path: examples(shown, path, has_truth=subject.has_truth), rows)


def draw_roc_curves(subject: Subject, comparison: Comparison, files: FigureFiles) -> list[Claim]:
    """Draw figure 3: the ROC curves of all methods; return its claims."""
    tables = comparison.metrics()
    if not tables:
        raise CannotDrawError("no test frame can be used")
    results = [one for one in method_results(comparison, tables, {}) if len(one.roc)]
    if not results:
        raise CannotDrawError("no frame shows both something salient and something else")
    rows = (
        {"method": one.name, "auc": one.figures["roc_auc"], **_interval(one.intervals)}
        | {"false_positive_rate": float(x), "true_positive_rate": float(y)}
        for one in results
        for x, y in one.roc
    )
    files.save(3, lambda path: draw_roc(results, path), rows)
    return claims_of_roc(comparison, subject.config.run.seed)


def draw_maps(comparison: Comparison, files: FigureFiles) -> None:
    """Draw figure 4: the maps of all methods."""
    if not comparison.shown:
        raise CannotDrawError("no test frame can be used")
    threshold = comparison.threshold
    wall = [WallRow(one.id, one.rgb, one.truth, one.maps, threshold) for one in comparison.shown]
    ids = {one.id for one in comparison.shown}
    rows = (
        {"id": frame["id"], "method": name}
        | {key: frame["all"][key] for key in ("roc_auc", "best_f1", "error")}
        for name, table in comparison.metrics().items()
        for frame in table["per_frame"]
        if frame["id"] in ids
    )
    files.save(4, lambda path: draw_wall(wall, path), rows)


def draw_evolution(
    target: Target, shots: Sequence[Snapshot], *, has_truth: bool, files: FigureFiles
) -> None:
    """Draw figure 5: one view's map after more and more looks."""
    late = target.late
    maps = [MapThen(_after(shot.looks, shot.error), shot.saliency) for shot in shots]
    title = "truth" if has_truth else "what depth says"
    rows = (
        {
            "id": target.frame.id,
            "looks": shot.looks,
            "error": shot.error,
            "thing_first_seen_at_look": None if late is None else late.first_look,
            "saliency_on_thing": shot.on_late,
            "saliency_on_not_salient": shot.elsewhere,
        }
        for shot in shots
    )

    def draw(path: Path) -> None:
        mask = None if late is None else late.mask
        seen = "colour" if late is None else f"outlined: seen at look {late.first_look}"
        evolution(
            target.frame.rgb,
            target.labels,
            maps,
            path,
            outlined=mask,
            titles=(seen, title),
        )

    files.save(5, draw, rows)


def _interval(intervals: Mapping[str, tuple[float, float] | None]) -> dict[str, float | None]:
    low, high = intervals.get("roc_auc") or (None, None)
    return {"auc_low": low, "auc_high": high}


def _after(looks: int, error: float | None) -> str:
    told = "" if error is None else f", error {error:.2f}"
    return f"{looks} look{'s' * (looks > 1)}{told}"
