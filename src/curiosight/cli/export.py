"""curiosight export: a recording in the form of the paper's authors' own program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import Config, load_config
from curiosight.datasets import Dataset, GraphNode, RlIac, RlIacWriter
from curiosight.experiments.components import survey_dataset
from curiosight.experiments.dividing import choose_regions, region_graph
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source


@reads_source
def export(
    source: options.Source,
    every: Annotated[int, typer.Option(help="Take every K-th frame.", metavar="K")] = 1,
    regions: Annotated[
        str | None,
        typer.Option(help="Divide it into regions: pose, pose:3x2x4, time:5, or a file."),
    ] = None,
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
    """Write a recording as an RL-IAC folder, which the program of the paper's authors reads.

    Writes image_data/ with x.png, x_depth.png (millimetres) and x_GT.png, input_region_map.dat,
    camera.json, and region_map.dat where the source has a navigation graph or the ways between
    its regions are known. Ctrl-C ends it early and keeps what is written.
    """
    talk = Talk(quiet=quiet, as_json=json)
    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    settings = load_config(preset, config, {**reading, "explorer.regions": regions})
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


def _divide(config: Config, dataset: Dataset) -> tuple[Sequence[int], Sequence[GraphNode]]:
    """Return the region of each frame and the graph; an RL-IAC folder keeps its own."""
    if isinstance(dataset, RlIac) and not config.explorer.regions:
        return dataset.regions, dataset.graph
    survey = survey_dataset(config, dataset)
    regions = choose_regions(config, dataset, survey)
    graph = region_graph(config, dataset, regions, survey.up_world)
    return regions.of_view.tolist(), graph
