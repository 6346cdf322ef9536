"""curiosight evaluate: how good saliency maps are."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, cast

import typer

from curiosight.cli import options
from curiosight.cli.again import command_again, from_anywhere
from curiosight.cli.evaluate_report import failures, write_report
from curiosight.cli.lessons import LEARNED_NOTHING_STATUS, tell_lessons
from curiosight.cli.mean_error import mean_of
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import NO_CLASSES, NOTHING_LEARNED, Talk
from curiosight.config import Config, load_config, to_toml
from curiosight.evaluation import PARTS, MapScores, SplitKind
from curiosight.experiments.comparing import Methods, choose_methods, is_network, split_names
from curiosight.experiments.depth_at_hand import DEPTH, FUSED, DepthAtHand
from curiosight.experiments.evaluating import CrossValidation, Evaluation
from curiosight.experiments.exploring import load_run_model
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.figures import reliability, roc
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source

# Of an earlier run, written again at the end of this one.
LEFTOVERS = (
    *("metrics.json", "roc.png", "reliability.png", "report.html", "times.json"),
    *("table.md", "table.tex"),
    *(
        f"figures/{name}.{e}"
        for name in ("roc", "precision_recall", "maps")
        for e in ("png", "svg")
    ),
)


@reads_source
def evaluate(
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="[RUN] SOURCE",
            help="A run and the recording to test it on; with --folds only the recording.",
        ),
    ],
    folds: Annotated[
        int | None,
        typer.Option(help="Learn all but one K-th, test on that, K times over.", metavar="K"),
    ] = None,
    split: Annotated[
        str | None,
        typer.Option(
            show_default="frames",
            help="With --folds: frames = at random (separate scenes), blocks = stretches "
            "(a moving camera).",
        ),
    ] = None,
    ground_truth: options.GroundTruth = None,
    baselines: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            show_default="none",
            help="Judge other methods on the same frames: all, or a list such as "
            "bms,gbvs,u2netp,depth,net.onnx (see `curiosight saliency --help`; depth = the "
            "teacher's labels, noise where they are unknown; u2netp and *.onnx need "
            "curiosight[onnx]).",
        ),
    ] = "",
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Score saliency against ground truth, or against the teacher where there is none.

    Writes metrics.json (pooled and per frame: ROC AUC, average precision, best F1, F1 at 0.5,
    overall error, how far probabilities hold; also where the teacher knew nothing and beyond its
    range; where there is depth, too, of maps fused with it and of what it says alone), roc.png,
    reliability.png and config.toml. With --baselines also the measures of salient-object
    detection, intervals and times of every method: report.html, table.md, table.tex, figures and
    times.json.
    With --folds exit status 1 says that no fold learned anything.
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
        },
    )
    if seed is not None and folds is None and not baselines:
        raise ValueError("seed: expected --folds or --baselines too, or nothing is left to chance")
    folder = OutputFolder(out, "evaluate", paths[-1], overwrite=overwrite)
    with announce_compilation(talk.console):
        methods = choose_methods(baselines) if baselines else None
        evaluation = _prepare(settings, paths, folds, split, ground_truth, methods)
        folder.remove(LEFTOVERS)
        folder.write_text("config.toml", to_toml(evaluation.config))
        talk.introduce(paths[-1], evaluation.truth.dataset)
        with talk.following("evaluate", len(evaluation)) as shown:
            for _ in evaluation:
                shown.advance()
    metrics = evaluation.metrics()
    folder.write_json("metrics.json", metrics)
    has_figures = talk.can_draw()
    if has_figures:
        _draw(evaluation.scores, evaluation.at_hand, folder)
    if evaluation.comparison is not None:
        given = {
            "folds": folds,
            "split": split,
            "ground-truth": ground_truth,
            "baselines": _from_anywhere(baselines),
        }
        command = command_again("evaluate", paths, given)
        write_report(
            evaluation, evaluation.comparison, metrics, folder, command, has_figures=has_figures
        )
        for failure in failures(evaluation.comparison):
            talk.warn(failure)
    talk.warn_of(evaluation.problems, len(evaluation.truth.dataset), "could not be used")
    talk.warn_of_learned(evaluation.n_learned, len(evaluation.truth.indices))
    has_learned = _tell_learned(talk, evaluation)
    if metrics["pooled"]["all"]["roc_auc"] is None:
        talk.warn(NO_CLASSES)
    rows = _rows(metrics)
    rows["written to"] = folder.path
    talk.results("evaluate", rows, {**metrics, "out": str(folder.path)})
    if not has_learned:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _tell_learned(talk: Talk, evaluation: Evaluation | CrossValidation) -> bool:
    """Tell where too little was learned; return whether anything was that was to be."""
    if isinstance(evaluation, Evaluation):
        if not evaluation.learner.is_trained:
            talk.warn(NOTHING_LEARNED)
        return evaluation.learner.is_trained
    n_folds, n_untrained = len(evaluation.folds), evaluation.n_untrained
    if 0 < n_untrained < n_folds:
        talk.warn(f"{n_untrained} of {n_folds} folds learned nothing, and score as if blind")
    has_learned = n_untrained < n_folds
    tell_lessons(talk, evaluation.off_line.lessons, has_learned=has_learned)
    return has_learned


def _prepare(
    config: Config,
    paths: list[Path],
    folds: int | None,
    split: str | None,
    ground_truth: Path | None,
    methods: Methods | None,
) -> Evaluation | CrossValidation:
    if folds is None:
        if split is not None:
            raise ValueError("split: expected --folds too, or nothing is split")
        if len(paths) != 2:
            raise ValueError("evaluate: expected RUN SOURCE, or SOURCE with --folds 5")
        run, source = paths
        model = load_run_model(run)
        dataset = open_source(source, ground_truth=ground_truth, reading=config.reading)
        return Evaluation(config, model, dataset, methods=methods)
    if len(paths) != 1:
        raise ValueError("evaluate: expected only SOURCE with --folds, for it trains itself")
    dataset = open_source(paths[0], ground_truth=ground_truth, reading=config.reading)
    kind = cast(SplitKind, split or "frames")
    return CrossValidation(config, dataset, n_folds=folds, split=kind, methods=methods)


def _from_anywhere(baselines: str) -> str:
    """Return names of baselines with absolute paths of networks."""
    names = split_names(baselines)
    return ",".join(from_anywhere(Path(name)) if is_network(name) else name for name in names)


def _figure(value: float | None) -> str:
    return "none" if value is None else f"{value:.3f}"


def _draw(scores: MapScores, at_hand: DepthAtHand, folder: OutputFolder) -> None:
    """Draw the curves of those parts of the pixels that show both classes, and of fused maps."""
    rankings = {part.replace("_", " "): scores.ranking(part) for part in PARTS}
    rankings["all, fused with depth"] = at_hand.scores[FUSED].ranking()
    drawn = {name: ranking for name, ranking in rankings.items() if ranking.roc_auc is not None}
    if drawn:
        roc(drawn, folder.file("roc.png"))
    curves = at_hand.curves()
    if curves:
        reliability(curves, folder.file("reliability.png"))


def _rows(metrics: dict[str, Any]) -> dict[str, Any]:
    """Return what a person wants to see of the metrics."""
    pooled = metrics["pooled"]
    rows = {
        "tested on": metrics["truth"],
        "frames": metrics["n_frames"],
        "overall error (1 - F1)": mean_of(
            metrics["overall_error"],
            metrics["pooled_error"],
            metrics["frames_scored"],
            metrics["n_frames"],
        ),
        "ROC AUC": pooled["all"]["roc_auc"],
        "average precision": pooled["all"]["average_precision"],
        "best F1": pooled["all"]["best_f1"],
        "F1 at 0.5": pooled["all"]["f1"],
    }
    for name, table in metrics["reliability"].items():
        rows[f"calibration error, {name}"] = table["expected_calibration_error"]
    for name, table in metrics.get("depth_at_hand", {}).items():
        title = {FUSED: "fused with depth", DEPTH: "depth alone"}[name]
        rows[f"overall error, {title}"] = table["overall_error"]
        rows[f"ROC AUC, {title}"] = table["roc_auc"]
        rows[f"F1 at 0.5, {title}"] = f"{_figure(table['f1'])}, best {_figure(table['best_f1'])}"
    for part in PARTS[1:]:
        rows[f"ROC AUC, {part.replace('_', ' ')}"] = pooled[part]["roc_auc"]
    for name, table in list(metrics.get("methods", {}).items())[1:]:
        rows[f"ROC AUC of {name}"] = table["pooled"]["all"]["roc_auc"]
    return rows
