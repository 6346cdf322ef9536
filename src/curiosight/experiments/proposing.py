"""Propose boxes for the objects of a recording (the authors' later work)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.evaluation.proposals import Proposal, propose, to_coco
from curiosight.experiments.components import make_teacher
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.learner.learner import SaliencyLearner


class Proposing:
    """Propose boxes for every `every`-th frame, from depth.

    learner: ranks them by colour; None = the largest come first. top: of each frame.
    temporal: see `TemporalTeacher`.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        learner: SaliencyLearner | None,
        *,
        top: int = 20,
        every: int = 1,
        temporal: bool = False,
    ) -> None:
        for name, value in (("every", every), ("top", top)):
            if value < 1:
                raise ValueError(f"{name}: expected 1 or more, got {value}")
        self.indices = range(0, len(dataset), every)
        self.problems = Problems()
        self._teacher = make_teacher(config, dataset, temporal=temporal)
        self._memory_mb = config.run.memory_mb
        self._dataset, self._learner, self._top = dataset, learner, top
        self._proposals: dict[str, list[Proposal]] = {}
        self._sizes: dict[str, tuple[int, int]] = {}

    def __len__(self) -> int:
        return len(self.indices)

    def __iter__(self) -> Iterator[tuple[Frame, list[Proposal]]]:
        """Yield each frame with its proposals, the best first."""
        with Prefetch(self._dataset, memory_mb=self._memory_mb) as frames:
            for frame in frames.in_order(self.indices):
                segmentation = self._teacher.segment(frame)
                saliency = None
                if self._learner is not None and segmentation.problem is None:
                    saliency = self._learner.saliency(frame.rgb, frame.T_world_camera)
                found = propose(segmentation.instances(), saliency, top=self._top)
                height, width = frame.rgb.shape[:2]
                self._proposals[frame.id], self._sizes[frame.id] = found, (height, width)
                self.problems.add_told(frame, segmentation)
                yield frame, found

    def finish(self, out: OutputFolder) -> dict[str, Any]:
        """Write proposals.json for the frames so far; return a summary, JSON-able."""
        out.write_json("proposals.json", to_coco(self._proposals, self._sizes))
        return {
            "frames": len(self._sizes),
            "proposals": sum(map(len, self._proposals.values())),
            "ranked_by": "area" if self._learner is None else "saliency",
            "problems": self.problems.counts(),
        }
