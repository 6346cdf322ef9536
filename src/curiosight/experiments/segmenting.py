"""Segment a recording's depth and write what the teacher sees (sec. II-A.2)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.components import make_teacher
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Frame
from curiosight.segmentation import Cluster, Segmentation


def segment_recording(
    config: Config, dataset: Dataset, out: OutputFolder, *, every: int = 1
) -> Iterator[tuple[Frame, Segmentation]]:
    """Segment every `every`-th frame; yield each once its files are written.

    Writes labels/<id>.png (8 bit, the codes of `Label`), instances/<id>.png (16 bit, 0 none)
    and, at the end or when interrupted, objects.json.
    """
    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    teacher = make_teacher(config, dataset)
    found: dict[str, Any] = {}
    indices = range(0, len(dataset), every)
    with Prefetch(dataset, memory_mb=config.run.memory_mb) as frames:
        try:
            for turn, index in enumerate(indices):
                frame = frames[index]
                frames.expect(indices[turn + 1 : turn + 4])
                segmentation = teacher.segment(frame)
                out.write_image(f"labels/{frame.id}.png", segmentation.labels)
                out.write_image(f"instances/{frame.id}.png", segmentation.instances())
                found[frame.id] = [
                    describe_object(number, cluster)
                    for number, cluster in enumerate(segmentation.objects, start=1)
                ]
                yield frame, segmentation
        finally:
            out.write_json("objects.json", found)


def describe_object(number: int, cluster: Cluster) -> dict[str, Any]:
    """Return an object as JSON-able numbers; `instance` is its value in instances/<id>.png."""
    u_min, v_min, u_max, v_max = cluster.box
    return {
        "instance": number,
        "box_px": [u_min, v_min, u_max - u_min, v_max - v_min],
        "area_px": cluster.n_pixels,
        "size_m": [round(length, 3) for length in cluster.size],
        "distance_m": round(cluster.distance, 3),
        "support_height_m": round(cluster.support_height, 3),
    }
