"""curiosight score-teacher: how right and how complete the teacher's labels are."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config, to_toml
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.scoring import Scoring, ScoringSettings
from curiosight.viewing.live import announce_compilation
from curiosight.viewing.mistakes import overlay_mistakes
from curiosight.worlds.sources import open_source

COUNTING = "What counts"


@reads_source
def score_teacher(
    source: options.Source,
    every: Annotated[
        int,
        typer.Option(
            help="Score every K-th frame with truth.", metavar="K", rich_help_panel=COUNTING
        ),
    ] = 1,
    border_px: Annotated[
        int,
        typer.Option(
            help="Recall leaves out objects that touch this frame of the image.",
            metavar="N",
            rich_help_panel=COUNTING,
        ),
    ] = 10,
    max_distance: Annotated[
        float | None,
        typer.Option(
            help="Leave out what is farther than this, in metres along z.",
            metavar="M",
            rich_help_panel=COUNTING,
            show_default="no limit",
        ),
    ] = None,
    worst: Annotated[int, typer.Option(help="Draw the N worst frames.", metavar="N")] = 12,
    ground_truth: options.GroundTruth = None,
    scene: options.Scene = None,
    up: options.Up = None,
    temporal: options.Temporal = False,
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
    """Score the teacher's labels, and its objects, against ground truth.

    Writes teacher.json (precision, recall, coverage, instances, why pixels were missed),
    frames.csv, config.toml and overlays/<id>.jpg of the worst frames.
    Ctrl-C ends it early and keeps what is scored.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(
        preset,
        config,
        {**reading, "teacher.scene": scene, "teacher.up": up, "teacher.source": teacher},
    )
    what_counts = ScoringSettings(every, border_px, max_distance, worst)
    folder = OutputFolder(out, "score-teacher", source, overwrite=overwrite)
    dataset = open_source(source, ground_truth=ground_truth, reading=settings.reading)
    with announce_compilation(talk.console):
        scoring = Scoring(settings, dataset, folder, what_counts, temporal=temporal)
        folder.write_text("config.toml", to_toml(settings))
        talk.introduce(source, dataset)
        with CtrlC() as ctrl_c, talk.following("score", len(scoring)) as shown:
            for _ in ctrl_c.until_pressed(scoring):
                shown.advance()
            figures = scoring.finish()
    for scored in scoring.scores.worst:
        folder.write_image(f"overlays/{scored.frame.id}.jpg", overlay_mistakes(scored))
    talk.warn_of(scoring.problems, scoring.n_tried, "told nothing")
    rows = _rows(figures)
    rows["written to"] = folder.path
    talk.results("score-teacher", rows, {**figures, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(figures['frames'], 'frame')}; these are kept")
        raise typer.Exit(ctrl_c.status)


def _rows(figures: dict[str, Any]) -> dict[str, Any]:
    """Return what a person wants to see of the figures."""
    pixels, instances = figures["pixels"], figures["instances"]
    rows = {
        "frames": figures["frames"],
        "precision of salient": pixels["precision"],
        "recall, objects not cut": pixels["recall"],
        "recall, all objects": pixels["recall_of_all"],
        "coverage": pixels["coverage"],
    }
    if instances is None:
        is_ours = str(figures["teacher"]).startswith("depth")
        rows["instances"] = "no instance truth" if is_ours else "not told apart by this teacher"
    else:
        for name in ("overlap", "boundary"):
            shares = [instances[f"{name}_{figure}"] for figure in ("precision", "recall", "f")]
            rows[f"{name} P / R / F"] = " / ".join(f"{100 * share:.1f}" for share in shares)
        rows["objects with F >= 0.75"] = f"{100 * instances['detected']:.1f} %"
    for reason, share in figures["missed_by_reason"].items():
        rows[f"missed: {reason}"] = f"{100 * share:.1f} %"
    return rows
