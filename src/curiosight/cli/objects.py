"""curiosight objects: what is there, and what is new, moved or gone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.catalogue import CHANGES, MIN_CONFIDENCE
from curiosight.cli import options
from curiosight.cli.again import command_again
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config, to_toml
from curiosight.experiments.cataloguing import Cataloguing
from curiosight.experiments.exploring import load_run_model, run_settings
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.catalogue import CatalogueReport, write_catalogue
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source

PAGE = "objects.html"


@reads_source
def objects(
    run: options.Run,
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE…",
            help="Recordings with poses of the same rooms, in one world, the oldest first: each "
            "is a visit. Or room:SEED or home:SEED, and the same with rearrange=1.",
        ),
    ],
    threshold: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            help="Leave out entries of less confidence, in [0, 1].",
        ),
    ] = MIN_CONFIDENCE,
    every: Annotated[int, typer.Option(help="Take every K-th frame.", metavar="K")] = 1,
    stride: Annotated[
        int,
        typer.Option(
            metavar="K",
            help="Look at every K-th row and column of depth: 1 finds the smallest and farthest "
            "things, 3 is eight times faster.",
        ),
    ] = 1,
    scene: options.Scene = None,
    up: options.Up = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """List what is there: each thing once; since the last visit what is new, moved or gone.

    Writes objects.html to look at first, objects.json (COCO: images, annotations, categories, and
    objects: place, support, T_world_centre, size_m, first_seen, last_seen, n_views, confidence,
    change) and config.toml. Settings are those of RUN unless --config names others. Ctrl-C ends it
    early and keeps what is found.
    """
    talk = Talk(quiet=quiet, as_json=json)
    given = {"teacher.scene": scene, "teacher.up": up, "segmentation.stride": stride}
    model = load_run_model(run)
    settings = load_config(None, config or run_settings(run), {**reading, **given})
    folder = OutputFolder(out, "objects", sources[-1], overwrite=overwrite)
    datasets = [open_source(source, reading=settings.reading) for source in sources]
    with announce_compilation(talk.console):
        cataloguing = Cataloguing(settings, model, datasets, min_confidence=threshold, every=every)
        folder.write_text("config.toml", to_toml(settings))
        for source, dataset in zip(sources, datasets, strict=True):
            talk.introduce(source, dataset)
        with CtrlC() as ctrl_c, talk.following("objects", len(cataloguing)) as shown:
            for _ in ctrl_c.until_pressed(cataloguing):
                shown.advance()
            summary = cataloguing.finish(folder)
    options_given = {"threshold": threshold, "every": every, "stride": stride}
    command = command_again("objects", [run, *sources], options_given)
    _write_page(cataloguing, command, summary, folder)
    talk.warn_of(cataloguing.problems, summary["frames"], "told nothing")
    if not cataloguing.is_confirmed:
        talk.warn("the model has not seen both objects and surroundings yet: depth alone told")
    if not summary["objects"]:
        talk.warn("nothing was found (see what `curiosight segment` makes of it, or --threshold)")
    talk.results("objects", _rows(summary, folder), {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(summary['frames'], 'frame')}; these are kept")
        raise typer.Exit(ctrl_c.status)


def _write_page(
    cataloguing: Cataloguing, command: list[str], summary: dict[str, Any], folder: OutputFolder
) -> None:
    entries = cataloguing.catalogue.entries
    report = CatalogueReport(
        entries,
        {entry.id: cataloguing.picture_of(entry) for entry in entries},
        [visit.name for visit in cataloguing.catalogue.visits],
        " ".join(command),
        list(cataloguing.problems.sentences(summary["frames"], "told nothing")),
    )
    write_catalogue(report, folder.file(PAGE))


def _rows(summary: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    rows = {"frames": summary["frames"], "things": summary["objects"]}
    if summary["visits"] > 1:
        rows |= {change: summary[change] for change in CHANGES}
    return rows | {"open": folder.path / PAGE}
