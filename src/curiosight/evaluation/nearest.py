"""The nearest marked pixel of every pixel, exactly (Maurer, Qi, Raghavan, PAMI 2003)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit


def nearest_marked(is_marked: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Return (H, W): the flat index of the nearest pixel that is marked; at least one must be.

    Of equally near ones that whose choice the reference programs of saliency measures share: first
    down the columns, then along the rows, where two are alike the first one.
    """
    if not is_marked.any():
        raise ValueError("is_marked: expected at least one marked pixel, got none")
    rows = _nearest_in_columns(np.ascontiguousarray(is_marked))
    nearest: npt.NDArray[np.int64] = _nearest_of_rows(rows)
    return nearest


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_in_columns(is_marked: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Return (H, W) the row of the nearest marked pixel of the column, -1 = none."""
    height, width = is_marked.shape
    nearest = np.full((height, width), -1, np.int64)
    for u in range(width):
        above = -1
        for v in range(height):
            if is_marked[v, u]:
                above = v
            nearest[v, u] = above
        below = -1
        for v in range(height - 1, -1, -1):
            if is_marked[v, u]:
                below = v
            if below >= 0 and (nearest[v, u] < 0 or below - v < v - nearest[v, u]):
                nearest[v, u] = below
    return nearest


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_of_rows(rows: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """Return (H, W) flat indices; rows: of the nearest in each column, -1 = none there.

    Along a row only those columns stay whose candidate is the nearest somewhere.
    """
    height, width = rows.shape
    nearest = np.empty((height, width), np.int64)
    kept = np.empty(width, np.int64)
    for v in range(height):
        n_kept = 0
        for u in range(width):
            if rows[v, u] < 0:
                continue
            away = float(rows[v, u] - v) ** 2
            while n_kept >= 2:
                last, before = kept[n_kept - 1], kept[n_kept - 2]
                a, b = float(last - before), float(u - last)
                away_last = float(rows[v, last] - v) ** 2
                away_before = float(rows[v, before] - v) ** 2
                if (a + b) * away_last - b * away_before - a * away - a * b * (a + b) <= 0:
                    break
                n_kept -= 1
            kept[n_kept] = u
            n_kept += 1
        place = 0
        for u in range(width):
            here = _squared(rows, v, u, kept[place])
            while place + 1 < n_kept:
                there = _squared(rows, v, u, kept[place + 1])
                if here <= there:
                    break
                here, place = there, place + 1
            nearest[v, u] = rows[v, kept[place]] * width + kept[place]
    return nearest


@njit(cache=True, nogil=True, error_model="numpy")
def _squared(rows: npt.NDArray[np.int64], v: int, u: int, column: int) -> float:
    return float(rows[v, column] - v) ** 2 + float(column - u) ** 2
