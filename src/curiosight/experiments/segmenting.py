"""Segment a recording's depth and write what the teacher sees (sec. II-A.2)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.components import make_teacher
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.segmentation import Cluster, Segmentation


class Segmenting:
    """Segment every `every`-th frame of a recording, frame by frame."""

    def __init__(
        self, config: Config, dataset: Dataset, out: OutputFolder, *, every: int = 1
    ) -> None:
        if every < 1:
            raise ValueError(f"every: expected 1 or more, got {every}")
        self.indices = range(0, len(dataset), every)
        self.problems = Problems()
        self._teacher = make_teacher(config, dataset)
        self._memory_mb = config.run.memory_mb
        self._dataset = dataset
        self._out = out
        self._objects: dict[str, list[dict[str, Any]]] = {}

    def __len__(self) -> int:
        return len(self.indices)

    def __iter__(self) -> Iterator[tuple[Frame, Segmentation]]:
        """Yield each frame once labels/<id>.png and instances/<id>.png are written.

        Labels are 8 bit, the codes of `Label`; instances are 16 bit, 0 = none.
        """
        with Prefetch(self._dataset, memory_mb=self._memory_mb) as frames:
            for turn, index in enumerate(self.indices):
                frame = frames[index]
                frames.expect(self.indices[turn + 1 : turn + 4])
                segmentation = self._teacher.segment(frame)
                self._out.write_image(f"labels/{frame.id}.png", segmentation.labels)
                self._out.write_image(f"instances/{frame.id}.png", segmentation.instances())
                self._objects[frame.id] = [
                    describe_object(number, cluster)
                    for number, cluster in enumerate(segmentation.objects, start=1)
                ]
                self.problems.add(frame, segmentation.problem)
                yield frame, segmentation

    def finish(self) -> dict[str, Any]:
        """Write objects.json for the frames segmented so far; return a summary, JSON-able."""
        self._out.write_json("objects.json", self._objects)
        return {
            "frames": len(self._objects),
            "objects": sum(map(len, self._objects.values())),
            "scene": self._teacher.survey.scene,
            "problems": self.problems.counts(),
        }


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
