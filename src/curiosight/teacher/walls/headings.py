"""Where walls may be: upright surface by the direction it faces and its distance."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Surface, horizontal_axes

Array = npt.NDArray[Any]

SECTOR = np.radians(3.0)
N_SECTORS = 120
ROW = 0.05


class Headings:
    """The histogram of vertical surface over heading (3°) and distance (5 cm)."""

    def __init__(self, surface: Surface, up: Array) -> None:
        self._right, self._forward = horizontal_axes(up)
        axes = np.stack([self._right, self._forward], axis=1).astype(np.float32)
        x, y = (surface.xyz @ axes).T
        heading = np.arctan2(*(surface.normals @ axes).T)
        sector = np.minimum(((heading + np.pi) / SECTOR).astype(np.int64), N_SECTORS - 1)
        centre = ((np.arange(N_SECTORS) + 0.5) * SECTOR - np.pi).astype(np.float32)
        along = np.sin(centre)[sector] * x + np.cos(centre)[sector] * y
        self._low = float(along.min()) if len(along) else 0.0
        row = ((along - self._low) / ROW).astype(np.int64)
        self._n_rows = int(row.max()) + 1 if len(row) else 1
        # No vote falls into a row before the first of each sector.
        self._cell = sector * (1 + self._n_rows) + 1 + row
        self._peak = 0, 0

    def keep(self, places: Array) -> None:
        """Forget the points that are not at the places."""
        self._cell = self._cell.take(places)

    def peak(self, weights: Array) -> tuple[Array, float, float]:
        """Return normal, offset and weight of the heaviest wall: 3 sectors by 2 rows."""
        votes, sums = np.zeros((N_SECTORS, 1 + self._n_rows)), np.empty((N_SECTORS, self._n_rows))
        _vote(self._cell, weights, votes.ravel())
        _sum_around(votes, sums)
        sector, row = divmod(int(np.argmax(sums)), self._n_rows)
        angle = (sector + 0.5) * SECTOR - np.pi
        self._peak = sector, row
        normal = np.sin(angle) * self._right + np.cos(angle) * self._forward
        return normal, -(self._low + row * ROW), float(sums[sector, row])

    def voters(self) -> Array:
        """(n,) bool: the points that made the last peak."""
        sector, row = np.divmod(self._cell, 1 + self._n_rows)
        beside = (sector - self._peak[0] + 1) % N_SECTORS < 3
        of_peak: Array = beside & ((row == self._peak[1]) | (row == self._peak[1] + 1))
        return of_peak


@njit(cache=True, nogil=True, error_model="numpy")
def _vote(cell: Array, weights: Array, votes: Array) -> None:
    """Add the (n,) weights to the votes of their cells."""
    for point in range(len(cell)):
        votes[cell[point]] += weights[point]


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_around(votes: Array, sums: Array) -> None:
    """Set (n, m) sums to those of (n, 1 + m) votes in 3 sectors by 2 rows, the second on it."""
    for sector in range(len(sums)):
        # The first sector follows the last.
        here, before, after = votes[sector], votes[sector - 1], votes[(sector + 1) % len(sums)]
        for row in range(sums.shape[1]):
            sums[sector, row] = (
                (here[row] + here[row + 1])
                + (before[row] + before[row + 1])
                + (after[row] + after[row + 1])
            )
