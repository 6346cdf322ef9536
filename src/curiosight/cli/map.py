"""curiosight map: saliency from colour alone, or from what depth shows now, too."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.lessons import LEARNED_NOTHING_STATUS
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk
from curiosight.config import load_config
from curiosight.experiments.exploring import load_run_model
from curiosight.experiments.mapping import (
    PROBABILITY,
    UNCERTAINTY,
    LearnedMaps,
    MapWriting,
    make_map_teacher,
)
from curiosight.experiments.output import OutputFolder
from curiosight.learner.learner import SaliencyLearner
from curiosight.viewing.live import announce_compilation
from curiosight.viewing.overlays import overlay_saliency
from curiosight.worlds.sources import open_source


@reads_source
def map_(
    run: options.Run,
    source: Annotated[
        Path,
        typer.Argument(metavar="SOURCE", help="A recording, a folder of images, or a video."),
    ],
    depth: Annotated[
        bool,
        typer.Option(
            "--depth",
            metavar="",
            help="Use the depth at hand, too: one map of what it shows now and what is "
            "remembered. seen/<id>.png says which pixels it shows (255).",
        ),
    ] = False,
    uncertainty: Annotated[
        bool,
        typer.Option(
            "--uncertainty",
            metavar="",
            help="Also write uncertainty/<id>.png: 255 = like nothing that was seen, or trees "
            "and places contradict each other.",
        ),
    ] = False,
    probability: Annotated[
        bool,
        typer.Option(
            "--probability",
            metavar="",
            help="Also write probability/<id>.png: how many in 255 such pixels are salient; "
            "<id>.png is scaled for the best F1 at a half instead.",
        ),
    ] = False,
    overlay: Annotated[
        bool, typer.Option("--overlay", metavar="", help="Also write overlays/<id>.jpg.")
    ] = False,
    no_poses: Annotated[
        bool,
        typer.Option(
            "--no-poses",
            metavar="",
            help="Do not tell the model from where images were taken, as where its world is "
            "another: what they look like says which place they show.",
        ),
    ] = False,
    config: Annotated[
        Path | None,
        typer.Option(
            "--config",
            metavar="FILE.toml",
            help="File of settings, such as the config.toml of a run. Only run.memory_mb matters, "
            "and with --depth how it is read: the model keeps all others.",
            rich_help_panel=options.SETTINGS,
        ),
    ] = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Find objects in colour images with a learned model: <id>.png, 255 = surely salient."""
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(None, config, reading)
    folder = OutputFolder(out, "map", source, overwrite=overwrite)
    dataset = open_source(source, reading=settings.reading)
    with announce_compilation(talk.console):
        teacher = make_map_teacher(settings, dataset) if depth else None
    learner = SaliencyLearner.load(load_run_model(run), teacher)
    talk.introduce(source, dataset, for_depth=depth)
    asked = {UNCERTAINTY: uncertainty, PROBABILITY: probability}
    maps_of = LearnedMaps(
        learner,
        with_poses=not no_poses,
        with_depth=depth,
        folders=frozenset(name for name, is_asked in asked.items() if is_asked),
    )
    mapping = MapWriting(settings, maps_of, dataset, folder)
    with announce_compilation(talk.console), talk.following("map", len(dataset)) as shown:
        for frame, saliency in mapping:
            if overlay and saliency is not None:
                picture = overlay_saliency(frame.rgb, saliency)
                folder.write_image(f"overlays/{frame.id}.jpg", picture)
            shown.advance()
    talk.warn_of(mapping.problems, len(dataset), "could not be mapped")
    if not learner.is_trained:
        talk.warn("the model has not seen both objects and surroundings yet: every map is black")
    facts = {"images": mapping.n_mapped, "bad_images": mapping.n_seen - mapping.n_mapped}
    rows = {"images": mapping.n_mapped, "written to": folder.path}
    talk.results("map", rows, {**facts, "out": str(folder.path)})
    if not learner.is_trained:
        raise typer.Exit(LEARNED_NOTHING_STATUS)
