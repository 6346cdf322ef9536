"""curiosight propose: boxes around objects, ranked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config, to_toml
from curiosight.experiments.exploring import load_run_model
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.proposing import Proposing
from curiosight.learner.learner import SaliencyLearner
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source


@reads_source
def propose(
    source: options.Source,
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN",
            help="A run that has learned: rank by how salient the boxes look, not by area.",
        ),
    ] = None,
    top: Annotated[int, typer.Option(help="How many boxes a frame.", metavar="K")] = 20,
    every: Annotated[int, typer.Option(help="Take every K-th frame.", metavar="K")] = 1,
    scene: options.Scene = None,
    up: options.Up = None,
    temporal: options.Temporal = False,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Propose boxes: depth draws them, and a model ranks them.

    Writes proposals.json (COCO: images, annotations with bbox, run-length mask, and score where a
    model is given; the best first) and config.toml. Ctrl-C ends it early and keeps what is found.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(preset, config, {**reading, "teacher.scene": scene, "teacher.up": up})
    learner = None if model is None else SaliencyLearner.load(load_run_model(model))
    is_blind = learner is not None and not learner.is_trained
    folder = OutputFolder(out, "propose", source, overwrite=overwrite)
    dataset = open_source(source, reading=settings.reading)
    with announce_compilation(talk.console):
        ranking = None if is_blind else learner
        proposing = Proposing(settings, dataset, ranking, top=top, every=every, temporal=temporal)
        folder.write_text("config.toml", to_toml(settings))
        talk.introduce(source, dataset)
        with CtrlC() as ctrl_c, talk.following("propose", len(proposing)) as shown:
            for _ in ctrl_c.until_pressed(proposing):
                shown.advance()
            summary = proposing.finish(folder)
    talk.warn_of(proposing.problems, summary["frames"], "told nothing")
    if is_blind:
        talk.warn("the model has not seen both objects and surroundings yet: ranked by area")
    rows = {"frames": summary["frames"], "proposals": summary["proposals"]}
    rows |= {"ranked by": summary["ranked_by"], "written to": folder.path}
    talk.results("propose", rows, {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(summary['frames'], 'frame')}; these are kept")
        raise typer.Exit(ctrl_c.status)
