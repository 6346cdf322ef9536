"""What each view would show, from the surfaces seen so far."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.explorer.outcome import MAX_RANGE, Seen
from curiosight.frame import Label, Pose

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float64]

# Cells across and down what a view would show, and the tangents of half its field of view:
# those of a common depth camera, as nobody has looked from there yet.
N_ACROSS, N_DOWN = 24, 18
HALF_ACROSS, HALF_DOWN = 0.61, 0.457
NEAREST = 0.3
# Readings of one surface lie within so much of each other: metres, and a part of the distance.
SAME, SAME_PART = 0.1, 0.05


class Outlook:
    """Keep of every view what it would show, as far as other views have shown it.

    Each look is drawn into the views that could see its surfaces, nearest first; a surface that
    hides another is known once it has been seen itself.

    poses: T_world_camera of each view; None = nothing can be said of it.
    depth: (n_views, cells) metres, inf = not known.
    n_seen: looks that showed it so, each counting as much as it was from the same side and as
    near. n_told, n_salient: looks that told whether it is an object, and that said so.
    """

    def __init__(self, poses: list[Pose | None]) -> None:
        n_views = len(poses)
        self.is_posed = np.array([pose is not None for pose in poses])
        known = [np.eye(4) if pose is None else pose for pose in poses]
        self._T_world_camera = np.ascontiguousarray(np.stack(known), np.float64)
        shape = n_views, N_ACROSS * N_DOWN
        self.depth = np.full(shape, np.inf, np.float32)
        self.n_seen = np.zeros(shape, np.float32)
        self.n_told = np.zeros(shape, np.float32)
        self.n_salient = np.zeros(shape, np.float32)

    def add(self, seen: Seen, T_world_camera: Pose, could_see: npt.NDArray[np.bool_]) -> None:
        """Draw what a look showed into the views that could see it.

        T_world_camera: from where. could_see: (n_views,) of each view whether it is near enough.
        """
        is_salient = seen.labels == Label.SALIENT
        is_known = is_salient | (seen.labels == Label.NOT_SALIENT)
        _draw(
            np.asarray(seen.points, np.float64),
            is_salient.astype(np.uint8),
            is_known.astype(np.uint8),
            np.asarray(T_world_camera[:3, 3], np.float64),
            np.flatnonzero(could_see & self.is_posed),
            self._T_world_camera,
            self.depth,
            self.n_seen,
            self.n_told,
            self.n_salient,
        )

    def is_known(self, views: Array) -> npt.NDArray[np.bool_]:
        """Return (n, cells) of some views: surfaces that were seen."""
        return np.isfinite(self.depth[views])

    def is_salient(self, views: Array) -> npt.NDArray[np.bool_]:
        """Return (n, cells) of some views: those that most looks took for an object."""
        return self.n_salient[views] > self.n_told[views] / 2

    def forget(self, views: Array, share: float) -> None:
        """Believe what is known of some views only in part, as where things may have changed.

        share: of it, what is not believed any more; of 1 nothing is known.
        """
        for counts in (self.n_seen, self.n_told, self.n_salient):
            counts[views] *= 1 - share
        if share >= 1:
            self.depth[views] = np.inf


@njit(cache=True, nogil=True)
def _draw(
    points: Array,
    is_salient: Array,
    is_known: Array,
    eye: Array,
    views: Array,
    T_world_camera: Array,
    depth: Array,
    n_seen: Array,
    n_told: Array,
    n_salient: Array,
) -> None:
    """Draw (n, 3) points into views: per cell the nearest of them, seen once more."""
    n_cells = depth.shape[1]
    nearest = np.empty(n_cells, np.float32)
    which = np.empty(n_cells, np.int64)
    for view in views:
        nearest[:] = np.inf
        R, t = T_world_camera[view, :3, :3], T_world_camera[view, :3, 3]
        for p in range(len(points)):
            a, b, c = points[p, 0] - t[0], points[p, 1] - t[1], points[p, 2] - t[2]
            z = R[0, 2] * a + R[1, 2] * b + R[2, 2] * c
            if z < NEAREST or z > MAX_RANGE:
                continue
            x = (R[0, 0] * a + R[1, 0] * b + R[2, 0] * c) / z / HALF_ACROSS
            y = (R[0, 1] * a + R[1, 1] * b + R[2, 1] * c) / z / HALF_DOWN
            if x <= -1 or x >= 1 or y <= -1 or y >= 1:
                continue
            cell = int((y + 1) / 2 * N_DOWN) * N_ACROSS + int((x + 1) / 2 * N_ACROSS)
            if z < nearest[cell]:
                nearest[cell] = z
                which[cell] = p
        for cell in range(n_cells):
            z = nearest[cell]
            if z == np.inf:
                continue
            before = depth[view, cell]
            tolerance = SAME + SAME_PART * z
            if z < before - tolerance:  # it hides what was known
                depth[view, cell] = z
                n_seen[view, cell] = 0
                n_told[view, cell] = 0
                n_salient[view, cell] = 0
            elif z > before + tolerance:  # it is hidden
                continue
            p = which[cell]
            n_seen[view, cell] += _alike(points[p], eye, t)
            if is_known[p]:
                n_told[view, cell] += 1
                n_salient[view, cell] += is_salient[p]


@njit(cache=True, nogil=True)
def _alike(point: Array, eye: Array, other: Array) -> float:
    """Return in [0, 1] how alike a point looks from two places: the side, and how near."""
    dot, square, other_square = 0.0, 0.0, 0.0
    for axis in range(3):
        a, b = eye[axis] - point[axis], other[axis] - point[axis]
        dot += a * b
        square += a * a
        other_square += b * b
    if dot <= 0:
        return 0.0
    cosine = dot / np.sqrt(square * other_square)
    nearness = np.sqrt(min(square, other_square) / max(square, other_square))
    return float(cosine * cosine * nearness)
