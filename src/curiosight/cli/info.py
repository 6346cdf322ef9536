"""curiosight info: what a recording is."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk
from curiosight.config import load_config
from curiosight.experiments.describing import describe
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
    rows = {name.replace("_", " "): value for name, value in facts.items() if name != "warnings"}
    rows["reasons"] = "; ".join(facts["reasons"]) or None
    rows["depth"] = _depth_line(facts["depth"])
    rows["camera"] = _camera_line(facts["camera"])
    rows["poses"] = facts["poses"] and f"{facts['poses']} of {facts['frames']}"
    rows["remarks"] = "; ".join(facts["remarks"]) or None
    supports = (f"{n} × {name}" for name, n in facts["supports"].items())
    rows["supports"] = ", ".join(supports) or None
    rows["regions"] = _region_line(facts["regions"])
    talk.results(str(source), rows, facts)
    for warning in facts["warnings"]:
        talk.warn_of_doubt(warning["text"], warning["fix"])


def _depth_line(depth: dict[str, Any] | None) -> str | None:
    """Write what the frames that were opened hold: 12 of 12 usable, 0.512 to 4.210 m, …"""
    if depth is None:
        return None
    parts = [f"{depth['usable']} of {depth['opened']} usable"]
    if depth["sizes"]:
        parts[0] += f" ({depth['sizes']})"
    if depth["usable"]:
        parts.append(f"{depth['min_m']:.2f} to {depth['max_m']:.2f} m")
        if depth["unit_m"]:
            parts.append(f"in units of {depth['unit_m']:.6g} m")
        parts.append(f"{depth['missing_share']:.0%} of the pixels without a reading")
    elif depth["problem"]:
        parts.append(depth["problem"])
    return ", ".join(parts)


def _camera_line(camera: dict[str, Any] | None) -> str | None:
    if camera is None:
        return None
    text = ", ".join(f"{name} {camera[name]:g}" for name in ("fx", "fy", "cx", "cy"))
    window = camera["depth_window"]
    return text if window is None else f"{text}; depth covers {window}"


def _region_line(regions: dict[str, Any]) -> str:
    sizes = regions["frames"]
    return f"{regions['kind']}: {len(sizes)} of {min(sizes)} to {max(sizes)} frames"
