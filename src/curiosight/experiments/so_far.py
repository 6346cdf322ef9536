"""What an exploration has come to, which its summary and its report tell."""

from __future__ import annotations

from dataclasses import dataclass, field

from curiosight.experiments.handing_on import RecentLooks
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.steps import StepRow
from curiosight.explore import Step
from curiosight.worlds import Odometer


@dataclass(slots=True)
class SoFar:
    """What an exploration has come to.

    seconds: that it took before it was begun or gone on with. last: its last step; None before.
    ids: of the frames it saw, each once. n_regrown: trees.
    """

    n_steps: int = 0
    seconds: float = 0.0
    last: StepRow | None = None
    ids: dict[str, None] = field(default_factory=dict)
    n_regrown: int = 0
    problems: Problems = field(default_factory=Problems)
    lessons: Lessons = field(default_factory=Lessons)
    odometer: Odometer = field(default_factory=Odometer)
    looks: RecentLooks = field(default_factory=RecentLooks)

    def add(self, step: Step) -> None:
        """Count what a step showed and taught, and what was wrong with its frame."""
        observation = step.observation
        self.ids[observation.frame.id] = None
        self.problems.add_told(observation.frame, observation.segmentation)
        self.lessons.add(observation.frame, observation.segmentation)
        self.n_regrown += observation.change.n_regrown
        self.odometer.add(step.viewpoint.T_world_camera)
        has_changed = observation.change.has_drifted
        self.looks.add(step.viewpoint.index, observation.error, has_changed=has_changed)
