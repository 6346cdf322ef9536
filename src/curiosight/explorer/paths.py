"""In which order to look at the good views of a region: a short way that takes in near ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Views so many metres apart show much of the same; and what a look leaves of one just like it.
ALIKE_METRES, LEFT_OF_TWIN = 1.5, 0.7


class Alikeness:
    """How much of what a view shows another shows too, by where they stand and look.

    poses: T_world_camera of each view; None = like no other.
    """

    def __init__(self, poses: list[Pose | None]) -> None:
        known = [np.full((4, 4), np.nan) if pose is None else pose for pose in poses]
        T_world_camera = np.stack(known)
        self._places, self._axes = T_world_camera[:, :3, 3], T_world_camera[:, :3, 2]

    def between(self, views: Ints, other: int) -> Floats:
        """Return (n,) in [0, 1] of some views beside another."""
        metres = np.linalg.norm(self._places[views] - self._places[other], axis=1)
        cosines = np.clip(self._axes[views] @ self._axes[other], 0, 1)
        alike: Floats = np.nan_to_num(np.exp(-((metres / ALIKE_METRES) ** 2)) * cosines**2)
        return alike


def plan_path(
    here: int,
    views: Ints,
    values: Floats,
    seconds: Floats,
    alikeness: Alikeness,
    *,
    n_looks: int,
    patience: float,
) -> list[int]:
    """Return up to `n_looks` of some views, in the order of a short way from here.

    One after the other that view is put into the path, where it adds least, which has the most
    value per second that it adds; then views like it are worth less (cheapest insertion).

    values: (n,) of the views. seconds: (n_all, n_all) of the ways between all views.
    patience: seconds that a view is taken to add at least.
    """
    path, left = [here], values.astype(np.float64)
    for _ in range(min(n_looks, len(views))):
        added, at = _insertions(np.array(path), views, seconds)
        chosen = int(np.argmax(left / (added + patience)))
        path.insert(int(at[chosen]), int(views[chosen]))
        left *= 1 - (1 - LEFT_OF_TWIN) * alikeness.between(views, int(views[chosen]))
        left[chosen] = -1.0
    return path[1:]


def _insertions(path: Ints, views: Ints, seconds: Floats) -> tuple[Floats, Ints]:
    """Return (n,) how many seconds each view adds to a path at its best place, and where."""
    to = seconds[np.ix_(path, views)]
    detours = to[:-1] + to[1:] - seconds[path[:-1], path[1:]][:, None]
    added = np.concatenate([detours, to[-1:]])
    best = added.argmin(axis=0)
    return np.maximum(added[best, np.arange(len(views))], 0), best + 1
