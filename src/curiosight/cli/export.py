"""curiosight export: a recording for the paper's authors' program, or as a bag; or a model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.export_model import ONNX, export_model
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import Config, load_config
from curiosight.datasets import BAG_LAYOUTS, BagWriter, Dataset, GraphNode, RlIac, RlIacWriter
from curiosight.datasets.bags.writer import ENDINGS
from curiosight.errors import DataError
from curiosight.experiments.components import survey_dataset
from curiosight.experiments.dividing import choose_regions, region_graph
from curiosight.experiments.output import OutputFolder, default_path
from curiosight.experiments.problems import Problems
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source

RL_IAC = "rl-iac"


@reads_source
def export(
    source: options.Source,
    every: Annotated[int, typer.Option(help="Take every K-th frame.", metavar="K")] = 1,
    regions: Annotated[
        str | None,
        typer.Option(help="Divide it into regions: pose, pose:3x2x4, time:5, or a file."),
    ] = None,
    layout: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="rl-iac, or a bag: ros1 (F.bag), rosbag2 (a folder), mcap (a bare F.mcap); or, of "
            "a run, onnx.",
        ),
    ] = RL_IAC,
    ground_truth: options.GroundTruth = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Write a recording for others, as an RL-IAC folder or a ROS bag; or a run's model.

    RL-IAC, which the program of the paper's authors reads, is image_data/ with x.png, x_depth.png
    (millimetres) and x_GT.png, input_region_map.dat, camera.json, and region_map.dat where the
    source has a navigation graph or the ways between its regions are known. A bag holds colour,
    depth, CameraInfo and poses (/tf), but neither ground truth nor regions. Ctrl-C ends it early
    and keeps what is written. With --layout onnx SOURCE is the folder of a run: its forests
    become an ONNX file, whose metadata tell the features (docs/features.md).
    """
    talk = Talk(quiet=quiet, as_json=json)
    if layout == ONNX:
        options_of_recordings = (regions, ground_truth, preset, config, *reading.values())
        if every != 1 or any(given is not None for given in options_of_recordings):
            raise ValueError("layout: onnx exports a run, and takes --out and --overwrite alone")
        export_model(talk, source, out, overwrite=overwrite)
        return
    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    settings = load_config(preset, config, {**reading, "explorer.regions": regions})
    if layout != RL_IAC:
        if regions is not None or ground_truth is not None:
            raise ValueError("layout: a bag holds no regions or ground truth; leave them away")
        dataset = open_source(source, reading=settings.reading)
        _export_bag(talk, source, dataset, layout, every, out, overwrite)
        return
    folder = OutputFolder(out, "export", source, overwrite=overwrite)
    dataset = open_source(source, ground_truth=ground_truth, reading=settings.reading)
    with announce_compilation(talk.console):
        of_view, graph = _divide(settings, dataset)
    indices = range(0, len(dataset), every)
    writer = RlIacWriter(dataset, folder.path, indices=indices, regions=of_view, graph=graph)
    problems = Problems()
    talk.introduce(source, dataset)
    folder.hold()
    with CtrlC() as ctrl_c, talk.following("export", len(writer)) as shown:
        for frame in ctrl_c.until_pressed(writer):
            problems.add(frame)
            shown.advance()
        n_written = writer.finish()
    talk.warn_of(problems, len(writer), "were not written")
    if len(writer) < len(indices):
        talk.warn(f"{count(len(indices) - len(writer), 'frame')} in no region: not written")
    n_regions = len({of_view[index] for index in writer.indices})
    rows = {"frames": n_written, "regions": n_regions, "written to": folder.path}
    facts = {"frames": n_written, "regions": n_regions, "problems": problems.counts()}
    talk.results("export", rows, {**facts, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(n_written, 'frame')}; these are kept")
        raise typer.Exit(ctrl_c.status)


def _export_bag(
    talk: Talk,
    source: Path,
    dataset: Dataset,
    layout: str,
    every: int,
    out: Path | None,
    overwrite: bool,
) -> None:
    if layout not in BAG_LAYOUTS:
        raise ValueError(
            f"layout: expected {', '.join((RL_IAC, *BAG_LAYOUTS, ONNX))}, got {layout!r}"
        )
    path = out or default_path("export", ENDINGS.get(layout, ""))
    if path.resolve().is_relative_to(source.resolve()):
        found = "lies inside the recording, which stays as it is"
        raise DataError(path, found, "choose an --out elsewhere")
    indices = range(0, len(dataset), every)
    writer = BagWriter(dataset, path, layout, indices=indices, overwrite=overwrite)
    problems = Problems()
    talk.introduce(source, dataset)
    with CtrlC() as ctrl_c, talk.following("export", len(writer)) as shown:
        for frame in ctrl_c.until_pressed(writer):
            problems.add(frame)
            shown.advance()
        if not writer.n_written:
            writer.abandon()
            raise DataError(source, "has no frame that can be written", "see `curiosight info`")
        n_written = writer.finish()
    talk.warn_of(problems, len(writer), "were not written")
    if writer.n_restamped:
        n_frames = count(writer.n_restamped, "frame")
        talk.warn(f"{n_frames} not later than the one before: stamped 1/30 s after it")
    rows = {"frames": n_written, "layout": layout, "written to": path}
    facts = {"frames": n_written, "layout": layout, "problems": problems.counts()}
    talk.results("export", rows, {**facts, "out": str(path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(n_written, 'frame')}; these are kept")
        raise typer.Exit(ctrl_c.status)


def _divide(config: Config, dataset: Dataset) -> tuple[Sequence[int], Sequence[GraphNode]]:
    """Return the region of each frame and the graph; an RL-IAC folder keeps its own."""
    if isinstance(dataset, RlIac) and not config.explorer.regions:
        return dataset.regions, dataset.graph
    survey = survey_dataset(config, dataset)
    regions = choose_regions(config, dataset, survey)
    graph = region_graph(config, dataset, regions, survey.up_world)
    return regions.of_view.tolist(), graph
