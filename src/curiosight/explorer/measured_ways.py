"""Ways as driving found them: what is measured replaces what was estimated."""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

# Of the ways between two regions the last so many count.
N_KEPT = 5
# What an estimate may be off without being wrong: a share of it, and seconds.
SHARE, SECONDS = 0.01, 0.01


class MeasuredWays:
    """Note how much longer ways between regions take than was estimated.

    beyond: (n_regions, n_regions) seconds, from region to region: the median of what the last
        `N_KEPT` such ways took beyond the estimate. A detour is as long for all views of a
        region. 0 where nothing was measured, or what was agrees.
    """

    def __init__(self, n_regions: int) -> None:
        self.beyond: Floats = np.zeros((n_regions, n_regions))
        self.is_any = False
        self._kept: dict[tuple[int, int], deque[float]] = {}

    def note(self, start: int, goal: int, estimated: float, measured: float) -> None:
        """Note the seconds of a way from a view in one region to a view in another."""
        beyond = measured - estimated
        kept = self._kept.setdefault((start, goal), deque(maxlen=N_KEPT))
        kept.append(beyond if abs(beyond) > SHARE * estimated + SECONDS else 0.0)
        self.beyond[start, goal] = np.median(kept)
        self.is_any = bool(self.beyond.any())
