"""curiosight segment: what the teacher sees in depth."""

from __future__ import annotations

from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config, to_toml
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.segmenting import Segmenting
from curiosight.viewing.live import announce_compilation
from curiosight.viewing.overlays import overlay_labels
from curiosight.worlds.sources import open_source


@reads_source
def segment(
    source: options.Source,
    every: Annotated[int, typer.Option(help="Take every K-th frame.", metavar="K")] = 1,
    scene: options.Scene = None,
    up: options.Up = None,
    temporal: options.Temporal = False,
    reasons: Annotated[
        bool,
        typer.Option(
            "--reasons",
            help="Also write reasons/<id>.png: what was found (floor, table, wall), and why "
            "pixels are unknown; reasons.json says which grey means what.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = False,
    confidence: Annotated[
        bool,
        typer.Option(
            "--confidence",
            help="Also write confidence/<id>.png: how sure each label is, 255 = certain.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = False,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Segment depth: objects on supports (salient), supports and walls (not), the rest unknown.

    Writes labels/<id>.png (255 salient, 0 not salient, 125 unknown, 75 unavailable),
    instances/<id>.png (16 bit, one number an object), objects.json and overlays/<id>.jpg.
    Ctrl-C ends it early and keeps what is written.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(preset, config, {**reading, "teacher.scene": scene, "teacher.up": up})
    folder = OutputFolder(out, "segment", source, overwrite=overwrite)
    dataset = open_source(source, reading=settings.reading)
    with announce_compilation(talk.console):
        segmenting = Segmenting(
            settings,
            dataset,
            folder,
            every=every,
            temporal=temporal,
            reasons=reasons,
            confidence=confidence,
        )
        folder.write_text("config.toml", to_toml(settings))
        talk.introduce(source, dataset)
        with CtrlC() as ctrl_c, talk.following("segment", len(segmenting)) as shown:
            for frame, segmentation in ctrl_c.until_pressed(segmenting):
                overlay = overlay_labels(frame.rgb, segmentation, has_legend=True)
                folder.write_image(f"overlays/{frame.id}.jpg", overlay)
                shown.advance()
            summary = segmenting.finish()
    talk.warn_of(segmenting.problems, summary["frames"], "told nothing")
    rows = {name: summary[name] for name in ("frames", "objects", "scene")}
    rows["supports"] = ", ".join(
        f"{name} in {count(n, 'frame')}" for name, n in summary["supports"].items()
    )
    rows["written to"] = folder.path
    talk.results("segment", rows, {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(summary['frames'], 'frame')}; these are kept")
        raise typer.Exit(ctrl_c.status)
