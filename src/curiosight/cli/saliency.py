"""curiosight saliency: what a baseline finds salient."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config
from curiosight.evaluation.baselines import METHODS
from curiosight.experiments.mapping import MapWriting
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source


@reads_source
def saliency(
    method: Annotated[str, typer.Argument(help=f"One of {', '.join(METHODS)}.")],
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SOURCE", help="A recording, a folder of images, or a video; depth not needed."
        ),
    ],
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Write the maps of a baseline, equal to its original: <id>.png, 255 = most salient.

    Ctrl-C ends it early and keeps what is written.
    """
    talk = Talk(quiet=quiet, as_json=json)
    if method not in METHODS:
        raise ValueError(f"method: expected one of {', '.join(METHODS)}, got {method!r}")
    folder = OutputFolder(out, "saliency", source, overwrite=overwrite)
    settings = load_config(overrides=reading)
    dataset = open_source(source, reading=settings.reading)
    talk.introduce(source, dataset, for_depth=False)
    find = METHODS[method]
    mapping = MapWriting(settings, lambda frame: {"": find(frame.rgb)}, dataset, folder)
    following = talk.following(method, len(dataset))
    with announce_compilation(talk.console), CtrlC() as ctrl_c, following as shown:
        for _ in ctrl_c.until_pressed(mapping):
            shown.advance()
    n_mapped = mapping.n_mapped
    talk.warn_of(mapping.problems, mapping.n_seen, "could not be mapped")
    facts = {"method": method, "images": n_mapped, "bad_images": mapping.n_seen - n_mapped}
    rows = {"method": method, "images": n_mapped, "written to": folder.path}
    talk.results("saliency", rows, {**facts, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(n_mapped, 'image')}; these are kept")
        raise typer.Exit(ctrl_c.status)
