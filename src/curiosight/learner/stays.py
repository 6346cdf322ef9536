"""Looks from nearly the same spot, one after the other, tell of a change once: as their mean."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from curiosight.frame import Pose
from curiosight.learner.scenery import Signs

# A stay ends where the camera is so many metres or degrees from where it began.
FAR, TURNED = 1.0, 30.0
# Without poses so many looks are one.
N_BLIND = 10
NAMES = tuple(one.name for one in fields(Signs))


@dataclass(slots=True)
class Stay:
    """What was told at a place from one spot. pose: where it began; None = not known.

    told: of each sign, and of "error", the sum and how many; a camera may stand there for weeks.
    """

    place: int
    pose: Pose | None
    n_looks: int = 0
    told: dict[str, tuple[float, int]] = field(default_factory=dict)

    def goes_on(self, place: int, pose: Pose | None) -> bool:
        """Tell whether a look at a place belongs to it."""
        if place != self.place or (pose is None) != (self.pose is None):
            return False
        if pose is None or self.pose is None:
            return self.n_looks < N_BLIND
        away = float(np.linalg.norm(pose[:3, 3] - self.pose[:3, 3]))
        return away < FAR and float(pose[:3, 2] @ self.pose[:3, 2]) > np.cos(np.deg2rad(TURNED))

    def add(self, signs: Signs, error: float | None) -> None:
        """Take in what a look tells; error: None = nothing."""
        self.n_looks += 1
        for name, number in [*((n, getattr(signs, n)) for n in NAMES), ("error", error)]:
            if number is not None:
                total, n = self.told.get(name, (0.0, 0))
                self.told[name] = total + number, n + 1

    def mean(self, name: str) -> float | None:
        """Return the mean of a sign, or of "error"; None = it was never told."""
        total, n = self.told.get(name, (0.0, 0))
        return total / n if n else None

    def signs(self) -> Signs:
        """Return the mean of each sign."""
        return Signs(**{name: self.mean(name) for name in NAMES})
