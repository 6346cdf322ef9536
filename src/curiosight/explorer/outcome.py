"""What a strategy hears of a look: how wrong the prediction was, and what was there to see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Frame, Pose

Array = npt.NDArray[Any]
Again = Callable[[], float | None]

# Readings taken across and down an image, and how far they count, metres.
N_ACROSS, N_DOWN = 64, 48
MAX_RANGE = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Surfaces that a view showed.

    points: (n, 3) float32 in the world's frame, metres. labels: (n,) uint8, a `Label` each.
    readings: by which they were told; None = nobody knows.
    """

    points: npt.NDArray[np.float32]
    labels: npt.NDArray[np.uint8]
    readings: Readings | None = None

    @classmethod
    def of(cls, frame: Frame, labels: npt.NDArray[np.uint8]) -> Self | None:
        """Return what a frame with (H, W) labels shows; None without a pose or depth."""
        readings = Readings.of(frame, labels)
        return None if readings is None else cls(readings.points(), readings.labels, readings)


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """By what a frame tells its `Seen`: a third of its size.

    size: (H, W) of the frame. z: (n,) metres along the optical axis, of those readings of a grid of
    `N_DOWN` by `N_ACROSS` that is_seen marks. labels: (n,), see `Seen`.
    """

    size: tuple[int, int]
    is_seen: npt.NDArray[np.bool_]
    z: Depth
    labels: npt.NDArray[np.uint8]
    camera: Camera
    T_world_camera: Pose

    @classmethod
    def of(cls, frame: Frame, labels: npt.NDArray[np.uint8]) -> Self | None:
        """Return those of a frame with (H, W) labels; None without a pose or depth."""
        pose, depth, camera = frame.T_world_camera, frame.depth, frame.camera
        if pose is None or depth is None or camera is None or frame.problem is not None:
            return None
        height, width = depth.shape
        v, u = _grid(height, width)
        z = depth[v, u]
        is_seen = (z > 0) & (z <= MAX_RANGE)
        return cls((height, width), is_seen, z[is_seen], labels[v, u][is_seen], camera, pose)

    def points(self) -> npt.NDArray[np.float32]:
        """Return (n, 3), see `Seen`."""
        down, across = np.nonzero(self.is_seen)
        v, u = (axis.ravel() for axis in _grid(*self.size))
        camera, pose, z = self.camera, self.T_world_camera, self.z.astype(np.float64)
        x, y = (u[across] - camera.cx) / camera.fx * z, (v[down] - camera.cy) / camera.fy * z
        points = np.stack([x, y, z], axis=1) @ pose[:3, :3].T + pose[:3, 3]
        return np.asarray(points, np.float32)

    def seen(self) -> Seen:
        """Return what they show."""
        return Seen(self.points(), self.labels, self)


def _grid(height: int, width: int) -> tuple[Array, Array]:
    """Return the lines (N_DOWN, 1) and columns (1, N_ACROSS) of an image where readings are."""
    v = np.linspace(0, height - 1, N_DOWN).round().astype(np.int64)[:, None]
    u = np.linspace(0, width - 1, N_ACROSS).round().astype(np.int64)[None, :]
    return v, u


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
