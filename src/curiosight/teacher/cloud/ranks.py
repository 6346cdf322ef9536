"""Medians, and ends but for a share: values at a rank, found without sorting the others."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]


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
    """Return the two of (n,) values that so many, less than n / 2, lie below and above.

    The values are reordered.
    """
    last = len(pool) - 1
    return _select(pool, 0, last, n_beyond), _select(pool, n_beyond, last, last - n_beyond)


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
