"""Medians, and ends but for a share: values at a rank, found without sorting the others."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]
# So many are found sooner in a list of their own, where every so many values come in turn.
FEW, STRIDE = 24, 16


def ends(values: Array, share: float = 0.01) -> tuple[float, float]:
    """Return the two of (n,) values, n > 0, that a share of them lies below and above."""
    low, high = find_ends(values.astype(np.float32), int(share * len(values)))
    return low, high


def median(values: Array) -> float:
    """Return the median of (n,) values, n > 0."""
    low, high = find_ends(values.astype(np.float32), (len(values) - 1) // 2)
    return float(low + high) / 2


@njit(cache=True, nogil=True, error_model="numpy")
def find_ends(pool: Array, n_beyond: int) -> tuple[float, float]:
    """Return the two of (n,) float32 values that so many, less than n / 2, lie below and above.

    The values are reordered.
    """
    last = len(pool) - 1
    if n_beyond <= FEW:
        low, high = _keep_extremes(pool, n_beyond)
    else:
        low = _select(pool, 0, last, n_beyond)
        high = _select(pool, n_beyond, last, last - n_beyond)
    return low, high


@njit(cache=True, nogil=True, error_model="numpy")
def _keep_extremes(pool: Array, n_beyond: int) -> tuple[float, float]:
    """Return what `find_ends` does, from lists of the least and the greatest, in their order."""
    least, most = np.empty(n_beyond + 1, np.float32), np.empty(n_beyond + 1, np.float32)
    for place in range(n_beyond + 1):
        least[place], most[place] = np.inf, np.inf
    # Downwards in the image heights only fall, and each would be put into the list.
    for first in range(STRIDE):
        for place in range(first, len(pool), STRIDE):
            _insert(pool[place], least)
            _insert(-pool[place], most)
    return float(least[n_beyond]), float(-most[n_beyond])


@njit(cache=True, nogil=True, error_model="numpy")
def _insert(value: float, least: Array) -> None:
    """Put a value into a list of the least ones, in their order, if it is one of these."""
    place = len(least) - 1
    if value < least[place]:
        while place > 0 and least[place - 1] > value:
            least[place] = least[place - 1]
            place -= 1
        least[place] = value


@njit(cache=True, nogil=True, error_model="numpy")
def _select(pool: Array, first: int, last: int, rank: int) -> float:
    """Return what would be at `rank` if pool[first : last + 1] were sorted; reorders it."""
    while first < last:
        pivot = pool[(first + last) // 2]
        up, down = first, last
        while up <= down:
            while pool[up] < pivot:
                up += 1
            while pool[down] > pivot:
                down -= 1
            if up <= down:
                pool[up], pool[down] = pool[down], pool[up]
                up += 1
                down -= 1
        if rank <= down:
            last = down
        elif rank >= up:
            first = up
        else:
            break
    return float(pool[rank])
