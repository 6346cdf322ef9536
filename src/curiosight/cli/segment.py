"""curiosight segment: what the teacher sees in depth."""

from __future__ import annotations

from collections import Counter
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.talk import Talk, open_source, warn_of_problems
from curiosight.config import load_config
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.segmenting import segment_recording
from curiosight.viewing.live import announce_compilation
from curiosight.viewing.overlays import overlay_labels


def segment(
    source: options.Source,
    every: Annotated[int, typer.Option(help="Take every K-th frame.", metavar="K")] = 1,
    scene: options.Scene = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
) -> None:
    """Segment depth: objects on supports (salient), supports and walls (not), the rest unknown.

    Writes labels/<id>.png (255 salient, 0 not salient, 125 unknown, 75 unavailable),
    instances/<id>.png (16 bit), objects.json and overlays/<id>.jpg.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(preset, config, {"teacher.scene": scene})
    dataset = open_source(talk, source)
    folder = OutputFolder(out, "segment", overwrite=overwrite)
    n_frames = len(range(0, len(dataset), max(every, 1)))
    problems: Counter[str] = Counter()
    n_objects = 0
    with announce_compilation(talk.console), talk.following("segment", n_frames) as shown:
        for frame, segmentation in segment_recording(settings, dataset, folder, every=every):
            overlay = overlay_labels(frame.rgb, segmentation)
            folder.write_image(f"overlays/{frame.id}.jpg", overlay)
            n_objects += len(segmentation.objects)
            if segmentation.problem is not None:
                problems["bad frame" if frame.problem else segmentation.problem] += 1
            shown.advance()
    warn_of_problems(talk, problems, n_frames)
    summary = {
        "frames": n_frames,
        "objects": n_objects,
        "problems": dict(problems),
        "out": str(folder.path),
    }
    rows = {"frames": n_frames, "objects": n_objects, "written to": folder.path}
    talk.results("segment", rows, summary)
