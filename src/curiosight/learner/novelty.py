"""How unlike anything seen a row of features is."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.learner.features import Rows

Array = npt.NDArray[Any]
Novelty = npt.NDArray[np.float32]

# Rows that stand for all that were seen, and others of them that tell what is usual.
N_KEPT, N_USUAL = 2000, 500
# A row is not new that is as near to those kept as half of the seen ones are.
NOT_NEW = 0.5
# It is unlike anything seen that is so much farther than all but a hundredth of them.
FAR, FARTHER = 0.99, 1.5
# Features that hardly change are not divided by less, grey levels.
LEAST_SPREAD = 2.0


class SeenRows:
    """Rows thinned out of those that were learned from, to compare others with.

    rows: (n, F) uint8, all that is still known; what is near is told in the spread of each
        feature.
    """

    def __init__(self, rows: Rows) -> None:
        self._weights = (1 / np.maximum(rows.std(axis=0), LEAST_SPREAD)).astype(np.float32)
        distinct = np.unique(rows, axis=0)
        order = np.random.default_rng(0).permutation(len(distinct))
        n_usual = min(N_USUAL, len(distinct) // 2)
        usual, kept = order[:n_usual], order[n_usual : n_usual + N_KEPT]
        self._kept = np.ascontiguousarray(distinct[kept])
        distances = self.distances(distinct[usual])
        near, far = np.quantile(distances, [NOT_NEW, FAR]).tolist() if n_usual else (0.0, 0.0)
        self._near, self._far = near, FARTHER * far

    @classmethod
    def of(cls, parts: list[Rows]) -> Self | None:
        """Return those of several parts together; None where there are too few to tell."""
        rows = np.concatenate(parts)
        return cls(rows) if len(rows) > 1 else None

    def distances(self, rows: Rows) -> Novelty:
        """(n,): how far each row is from the nearest one kept."""
        return np.asarray(nearest_distances(np.ascontiguousarray(rows), self._kept, self._weights))

    def novelty(self, rows: Rows) -> Novelty:
        """(n,) in [0, 1]: 0 = as near as most that was seen, 1 = unlike anything seen."""
        span = max(self._far - self._near, 1e-6)
        novelty: Novelty = np.clip((self.distances(rows) - self._near) / span, 0, 1)
        return novelty.astype(np.float32)


@njit(cache=True, nogil=True)
def nearest_distances(rows: Array, kept: Array, weights: Array) -> Array:
    """Return (n,) float32, the least weighted sum of absolute differences to any row kept."""
    found = np.empty(len(rows), np.float32)
    n_features = rows.shape[1]
    for i in range(len(rows)):
        least = np.float32(np.inf)
        for j in range(len(kept)):
            total = np.float32(0)
            for k in range(n_features):
                total += abs(np.float32(rows[i, k]) - np.float32(kept[j, k])) * weights[k]
                if total >= least:
                    break
            least = min(least, total)
        found[i] = least
    return found
