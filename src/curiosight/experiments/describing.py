"""Say what a recording is: opened, looked at, and doubted where it contradicts itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, Doubt, find_doubts
from curiosight.experiments.components import survey_frames
from curiosight.experiments.dividing import choose_regions
from curiosight.frame import Frame
from curiosight.teacher import Survey

N_OPENED = 12
# Every so many of them tell which way is up.
SURVEY_STRIDE = 3


@dataclass(frozen=True, slots=True)
class Opened:
    """What some frames of a recording hold.

    usable: how many of the `opened` have depth that can be used. unit_m: metres per unit, None
    where that is not known. min_m, max_m: the range of their readings, without the extreme
    thousandths, None where there is none. missing_share: of all their pixels. sizes: those of
    colour and depth, in words, where they differ. problem: what is wrong with the first that
    cannot be used.
    """

    usable: int
    opened: int
    unit_m: float | None
    min_m: float | None
    max_m: float | None
    missing_share: float | None
    sizes: str | None = None
    problem: str | None = None


def open_some(dataset: Dataset, n_frames: int = N_OPENED) -> list[Frame]:
    """Return frames spread over a recording."""
    n_opened = min(n_frames, len(dataset))
    return [dataset[int(index)] for index in np.linspace(0, len(dataset) - 1, n_opened)]


def look_at_depth(dataset: Dataset, frames: Sequence[Frame]) -> Opened:
    """Return what frames of a recording with depth hold."""
    # Every fourth pixel tells shares and percentiles as well.
    good = [
        frame.depth[::4, ::4]
        for frame in frames
        if frame.problem is None and frame.depth is not None
    ]
    usable = [depth for depth in good if np.isfinite(depth).any()]
    known = [depth[np.isfinite(depth)] for depth in usable]
    low, high = np.quantile(np.concatenate(known), (0.001, 0.999)) if known else (None, None)
    n_missing = sum(
        depth.size - readings.size for depth, readings in zip(usable, known, strict=True)
    )
    problems = [frame.problem for frame in frames if frame.problem is not None]
    return Opened(
        usable=len(usable),
        opened=len(frames),
        unit_m=getattr(dataset, "depth_scale", None),
        min_m=None if low is None else round(float(low), 3),
        max_m=None if high is None else round(float(high), 3),
        missing_share=round(n_missing / sum(d.size for d in usable), 3) if usable else None,
        sizes=_sizes(dataset),
        problem=problems[0] if problems else None,
    )


def describe(config: Config, dataset: Dataset) -> dict[str, Any]:
    """Return what is known of a recording, for `curiosight info`; raises nothing for bad frames.

    `warnings` has what its frames contradict, and `depth` what they hold; with depth, they tell
    which way is up too, for regions by pose.
    """
    frames = open_some(dataset)
    survey = _survey(config, dataset, frames[::SURVEY_STRIDE])
    divided = choose_regions(config, dataset, survey)
    height, width = frames[0].rgb.shape[:2]
    n_confident = sum(
        getattr(entry, "confidence", None) is not None for entry in getattr(dataset, "entries", ())
    )
    return {
        "layout": dataset.name,
        "reasons": list(getattr(dataset, "reasons", ())),
        "frames": len(dataset),
        "first_id": dataset.ids[0],
        "last_id": dataset.ids[-1],
        "width": width,
        "height": height,
        "depth": asdict(look_at_depth(dataset, frames)) if dataset.has_depth else None,
        "scene": survey.scene if survey is not None else None,
        "supports": survey.supports() if survey is not None else {},
        "camera": _camera(dataset),
        "poses": sum(pose is not None for pose in dataset.poses),
        "ground_truth": sum(map(dataset.has_ground_truth, range(len(dataset)))),
        "confidence": n_confident,
        "regions": {
            "kind": divided.kind,
            "names": list(divided.names),
            "frames": [int((divided.of_view == r).sum()) for r in range(divided.n_regions)],
        },
        "remarks": list(dataset.remarks),
        "warnings": [
            {"code": doubt.code, "text": doubt.text, "fix": doubt.fix}
            for doubt in doubts_of(dataset)
        ],
    }


def doubts_of(dataset: Dataset) -> list[Doubt]:
    """Return what contradicts itself in a recording; nothing in one that is drawn."""
    return find_doubts(dataset) if dataset.has_depth and hasattr(dataset, "entries") else []


def _survey(config: Config, dataset: Dataset, frames: Sequence[Frame]) -> Survey | None:
    """Return what frames tell together; None where none of them has depth that can be used."""
    good = [frame for frame in frames if frame.problem is None and frame.depth is not None]
    return survey_frames(config, dataset, good) if good else None


def _camera(dataset: Dataset) -> dict[str, Any] | None:
    if dataset.camera is None:
        return None
    kept = ("fx", "fy", "cx", "cy", "depth_window")
    return {name: getattr(dataset.camera, name) for name in kept}


def _sizes(dataset: Dataset) -> str | None:
    size, depth_size = getattr(dataset, "size", None), getattr(dataset, "depth_size", None)
    if size is None or depth_size is None or size == depth_size:
        return None
    return f"{depth_size[0]}×{depth_size[1]}, colour {size[0]}×{size[1]}"
