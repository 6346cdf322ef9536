"""Segment a recording's depth and write what the teacher sees (sec. II-A.2)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.components import make_teacher, survey_dataset
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.frame.boxes import boxes_of
from curiosight.teacher import REASONS, Cluster, Segmentation, Teacher, TemporalTeacher


class Segmenting:
    """Segment every `every`-th frame of a recording, frame by frame.

    temporal: with poses, let earlier views correct each frame, see `TemporalTeacher`.
    reasons: write what was found and why pixels are unknown, too.
    confidence: write how sure each label is, too; raises `ValueError` for a teacher that cannot
        tell.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        *,
        every: int = 1,
        temporal: bool = False,
        reasons: bool = False,
        confidence: bool = False,
    ) -> None:
        if every < 1:
            raise ValueError(f"every: expected 1 or more, got {every}")
        self.indices = range(0, len(dataset), every)
        self.problems = Problems()
        self._survey = survey_dataset(config, dataset)
        self._teacher = make_teacher(config, dataset, self._survey, temporal=temporal)
        self._memory_mb = config.run.memory_mb
        self._dataset = dataset
        self._out = out
        self._writes_reasons = reasons
        self._measured: Teacher | TemporalTeacher | None = None
        if confidence:
            if not isinstance(self._teacher, Teacher | TemporalTeacher):
                raise ValueError("confidence: expected the pipeline 'default', got another teacher")
            self._measured = self._teacher
        self._objects: dict[str, list[dict[str, Any]]] = {}
        self._n_showing: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self.indices)

    def __iter__(self) -> Iterator[tuple[Frame, Segmentation]]:
        """Yield each frame once labels/<id>.png and instances/<id>.png are written.

        Labels are 8 bit, the codes of `Label`; instances are 16 bit, 0 = none.
        """
        with Prefetch(self._dataset, memory_mb=self._memory_mb) as frames:
            for frame in frames.in_order(self.indices):
                segmentation = self._teacher.segment(frame)
                self._out.write_image(f"labels/{frame.id}.png", segmentation.labels)
                instances = segmentation.instances()
                self._out.write_image(f"instances/{frame.id}.png", instances)
                if self._writes_reasons:
                    self._out.write_image(f"reasons/{frame.id}.png", segmentation.reasons())
                if self._measured is not None:
                    sure = self._measured.confidence(frame, segmentation)
                    grey = np.rint(255 * sure).astype(np.uint8)
                    self._out.write_image(f"confidence/{frame.id}.png", grey)
                self._objects[frame.id] = describe_objects(instances, segmentation.objects)
                self._n_showing.update({support.name for support in segmentation.supports})
                self.problems.add_told(frame, segmentation)
                yield frame, segmentation

    def finish(self) -> dict[str, Any]:
        """Write objects.json for the frames segmented so far; return a summary, JSON-able.

        `supports`: in how many frames each kind of support was found.
        With reasons also reasons.json: what the greys of reasons/<id>.png mean.
        """
        self._out.write_json("objects.json", self._objects)
        if self._writes_reasons:
            self._out.write_json("reasons.json", {str(code): why for code, why in REASONS.items()})
        return {
            "frames": len(self._objects),
            "objects": sum(map(len, self._objects.values())),
            "scene": self._survey.scene,
            # Sorted: sets of names come in another order in every process.
            "supports": dict(sorted(self._n_showing.items(), key=lambda kind: (-kind[1], kind[0]))),
            "problems": self.problems.counts(),
        }


def describe_objects(
    instances: npt.NDArray[np.uint16], objects: Sequence[Cluster]
) -> list[dict[str, Any]]:
    """Return objects as JSON-able numbers; `instance` is each one's value in instances/<id>.png.

    box_px: u, v, width, height.
    """
    described = []
    for number, (cluster, box) in enumerate(
        zip(objects, boxes_of(instances), strict=True), start=1
    ):
        assert box is not None, "each object has pixels"
        rows, columns = box
        described.append(
            {
                "instance": number,
                "box_px": [
                    columns.start,
                    rows.start,
                    columns.stop - columns.start,
                    rows.stop - rows.start,
                ],
                "area_px": int(np.count_nonzero(instances[box] == number)),
                "size_m": [round(length, 3) for length in cluster.size],
                "distance_m": round(cluster.distance, 3),
                "support_height_m": round(cluster.support_height, 3),
            }
        )
    return described
