"""curiosight info: what a recording is."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk
from curiosight.config import Config, load_config
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.components import choose_regions, survey_dataset
from curiosight.teacher import Survey
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source


@reads_source
def info(
    source: options.Source,
    regions: Annotated[
        str | None, typer.Option(help="Show these regions: pose, pose:3x2x4, time:5, or a file.")
    ] = None,
    ground_truth: options.GroundTruth = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Say what a recording is: layout, frames, camera, poses, ground truth, regions."""
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(preset, config, {**reading, "explorer.regions": regions})
    dataset = open_source(source, ground_truth=ground_truth, reading=settings.reading)
    with announce_compilation(talk.console):
        facts = describe(settings, dataset)
    rows = {name.replace("_", " "): value for name, value in facts.items()}
    rows["camera"] = _camera_line(facts["camera"])
    rows["remarks"] = "; ".join(facts["remarks"]) or None
    rows["regions"] = _region_line(facts["regions"])
    talk.results(str(source), rows, facts)


def describe(config: Config, dataset: Dataset) -> dict[str, Any]:
    """Return what is known of a recording; with depth some frames tell which way is up."""
    frame = dataset[0]
    height, width = frame.rgb.shape[:2]
    camera = dataset.camera
    survey = _survey(config, dataset)
    divided = choose_regions(config, dataset, survey)
    sizes = [int((divided.of_view == region).sum()) for region in range(divided.n_regions)]
    return {
        "layout": dataset.name,
        "frames": len(dataset),
        "first_id": dataset.ids[0],
        "last_id": dataset.ids[-1],
        "width": width,
        "height": height,
        "depth": dataset.has_depth,
        "scene": survey.scene if survey is not None else None,
        "camera": camera
        and {
            "fx": camera.fx,
            "fy": camera.fy,
            "cx": camera.cx,
            "cy": camera.cy,
            "depth_window": camera.depth_window,
        },
        "frames_with_pose": sum(pose is not None for pose in dataset.poses),
        "frames_with_ground_truth": sum(map(dataset.has_ground_truth, range(len(dataset)))),
        "regions": {
            "kind": divided.kind,
            "names": list(divided.names),
            "frames": sizes,
        },
        "remarks": list(dataset.remarks),
    }


def _survey(config: Config, dataset: Dataset) -> Survey | None:
    """Look at some frames; None where there is no depth or no usable frame."""
    try:
        return survey_dataset(config, dataset)
    except DataError:
        return None


def _camera_line(camera: dict[str, Any] | None) -> str | None:
    if camera is None:
        return None
    text = ", ".join(f"{name} {camera[name]:g}" for name in ("fx", "fy", "cx", "cy"))
    window = camera["depth_window"]
    return text if window is None else f"{text}; depth covers {window}"


def _region_line(regions: dict[str, Any]) -> str:
    sizes = regions["frames"]
    return f"{regions['kind']}: {len(sizes)} of {min(sizes)} to {max(sizes)} frames"
