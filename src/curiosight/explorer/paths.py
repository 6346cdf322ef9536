"""In which order to look at the good views of a region: a short way that takes in near ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# A view that gives less than this part of what the path gives per second is left for later.
LEAST_RATE = 0.3
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
    values: Floats,
    to: Floats,
    between: Floats,
    alike: Callable[[int], Floats],
    *,
    n_looks: int,
    patience: float,
) -> list[int]:
    """Return up to `n_looks` of n views, by number, in the order of a short way from here.

    One after the other that view is put into the path, where it adds least, which has the most
    value per second that it adds; then views like it are worth less (cheapest insertion). The
    path ends where no view is worth its seconds, beside those that are in it.

    values: (n,) of the views. to: (n,) seconds from here to each. between: (n, n) seconds.
    alike: returns of a view (n,) in [0, 1], how much of it each other shows.
    patience: seconds that a view is taken to add at least.
    """
    path: list[int] = []
    left = values.astype(np.float64)
    value = seconds = 0.0
    for _ in range(min(n_looks, len(values))):
        added, at = _insertions(path, to, between)
        takes = added + patience
        chosen = int(np.argmax(left / takes))
        if left[chosen] * seconds < LEAST_RATE * value * takes[chosen]:
            break
        value, seconds = value + left[chosen], seconds + takes[chosen]
        path.insert(int(at[chosen]), chosen)
        left *= 1 - (1 - LEFT_OF_TWIN) * alike(chosen)
        left[chosen] = -1.0
    return path


def _insertions(path: list[int], to: Floats, between: Floats) -> tuple[Floats, Ints]:
    """Return (n,) how many seconds each view adds to a path at its best place, and where."""
    from_each = np.vstack([to, between[path]])
    onward = np.concatenate([to[path[:1]], between[path[:-1], path[1:]]])
    detours = from_each[:-1] + between[path] - onward[:, None]
    added = np.vstack([detours, from_each[-1:]])
    best = added.argmin(axis=0)
    return np.maximum(added[best, np.arange(len(to))], 0), best
