"""The nearest of some points to each of others."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]


def nearest_points(xyz: Array, wanted: Array) -> tuple[Array, Array]:
    """Return for each of (m, d) wanted places how far the nearest of (n, d) points is, and which.

    Of equally near ones it is any, but always the same. n is at least 1.
    """
    xyz, wanted = np.asarray(xyz, np.float64), np.asarray(wanted, np.float64)
    # Along the axis in which they reach farthest few are near a place.
    axis = int(np.ptp(xyz, axis=0).argmax())
    order = np.argsort(xyz[:, axis], kind="stable")
    squared, place = _search(np.ascontiguousarray(xyz[order]), wanted, axis)
    return np.sqrt(squared), order[place]


@njit(cache=True, nogil=True, error_model="numpy")
def _search(xyz: Array, wanted: Array, axis: int) -> tuple[Array, Array]:
    """Do so among points sorted along an axis: to both sides until these alone are farther."""
    squared, place = np.full(len(wanted), np.inf), np.zeros(len(wanted), np.int64)
    along = xyz[:, axis].copy()
    for one in range(len(wanted)):
        middle = np.searchsorted(along, wanted[one, axis])
        for step in (-1, 1):
            other = middle - 1 if step < 0 else middle
            while 0 <= other < len(xyz):
                if (along[other] - wanted[one, axis]) ** 2 > squared[one]:
                    break
                away = 0.0
                for part in range(xyz.shape[1]):
                    away += (xyz[other, part] - wanted[one, part]) ** 2
                if away < squared[one]:
                    squared[one], place[one] = away, other
                other += step
    return squared, place
