"""What a strategy hears of a look: how wrong the prediction was, and what was there to see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame

Array = npt.NDArray[Any]
Again = Callable[[], float | None]

# Readings taken across and down an image, and how far they count, metres.
N_ACROSS, N_DOWN = 64, 48
MAX_RANGE = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Surfaces that a view showed.

    points: (n, 3) float32 in the world's frame, metres. labels: (n,) uint8, a `Label` each.
    """

    points: npt.NDArray[np.float32]
    labels: npt.NDArray[np.uint8]

    @classmethod
    def of(cls, frame: Frame, labels: npt.NDArray[np.uint8]) -> Self | None:
        """Return what a frame with (H, W) labels shows; None without a pose or depth."""
        pose, depth, camera = frame.T_world_camera, frame.depth, frame.camera
        if pose is None or depth is None or camera is None or frame.problem is not None:
            return None
        height, width = depth.shape
        v = np.linspace(0, height - 1, N_DOWN).round().astype(np.int64)[:, None]
        u = np.linspace(0, width - 1, N_ACROSS).round().astype(np.int64)[None, :]
        z = depth[v, u].astype(np.float64)
        x, y = (u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z
        is_seen = (z > 0) & (z <= MAX_RANGE)
        inside = np.stack([x[is_seen], y[is_seen], z[is_seen]], axis=1)
        points = inside @ pose[:3, :3].T + pose[:3, 3]
        return cls(points.astype(np.float32), labels[v, u][is_seen])


class Labelled(Protocol):
    """What a teacher says."""

    @property
    def labels(self) -> npt.NDArray[np.uint8]: ...


class Learned(Protocol):
    """What learning from a frame changed."""

    @property
    def has_drifted(self) -> bool: ...


class Observed(Protocol):
    """What a learner makes of a frame."""

    @property
    def frame(self) -> Frame: ...
    @property
    def segmentation(self) -> Labelled: ...
    @property
    def scores(self) -> npt.NDArray[np.float32]: ...
    @property
    def error(self) -> float | None: ...
    @property
    def change(self) -> Learned: ...


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a strategy hears of a look.

    error: 1 - F1 of the prediction there (eq. 1); None = undefined, as nothing salient is known.
    seconds: of the way there. uncertainty: mean of 1 - |2 s - 1| over the scores s; None = not
    known. seen: None where the pose or the depth is not known. has_changed: the place is no longer
    what was learned of it.
    again: tells the error of this look by the model as it is when called; None = nobody can.
    """

    error: float | None = None
    seconds: float = 0.0
    uncertainty: float | None = None
    seen: Seen | None = None
    has_changed: bool = False
    again: Again | None = None

    @classmethod
    def of(cls, observation: Observed, seconds: float, again: Again | None = None) -> Self:
        """Return what an observation tells; seconds: of the way there."""
        seen = Seen.of(observation.frame, observation.segmentation.labels)
        uncertainty = mean_uncertainty(observation.scores)
        has_changed = observation.change.has_drifted
        return cls(observation.error, seconds, uncertainty, seen, has_changed, again)


def mean_uncertainty(scores: npt.NDArray[np.float32]) -> float | None:
    """Return how undecided (n,) scores in [0, 1] are on average: 0 = all are 0 or 1."""
    return float(np.mean(1 - np.abs(2 * scores - 1))) if len(scores) else None
