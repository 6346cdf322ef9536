"""What a score means: where salient begins, and how probable it is.

Trees weigh both classes alike, so half of their votes is neither the best threshold nor a
probability. Both are read off scores that views got before anything was learned from them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Scores = npt.NDArray[np.float32]

N_BINS = 64
# After so many frames one counts half as much as a new one.
HALF_LIFE = 60
# With fewer frames that show both classes, scores stay as they are.
MIN_FRAMES = 8
# What is added to either class of each bin, of a frame: no bin is sure for having seen little.
PRIOR = 0.02
# As the threshold follows what is learned, it stays within this.
LEAST, MOST = 0.2, 0.8


class Calibration:
    """Learn how scores and labels go together, from scores of what was not learned yet.

    `counts` (2, 64): labelled pixels a frame by bin of their score, not salient and salient.
    `n_frames`: that showed both.
    """

    def __init__(self) -> None:
        self.counts = np.zeros((2, N_BINS))
        self.n_frames = 0.0

    def add(self, scores: Array, n_salient: Array, n_other: Array, *, forgets: bool = True) -> None:
        """Take in a view; one without both classes is passed over.

        scores: (n,) as the trees voted. n_salient, n_other: (n,) of how many such pixels.
        forgets: earlier views count less.
        """
        n_pixels = n_salient.sum() + n_other.sum()
        if not (n_salient.any() and n_other.any()):
            return
        kept = 0.5 ** (1 / HALF_LIFE) if forgets else 1.0
        bins = np.minimum((scores * N_BINS).astype(np.int64), N_BINS - 1)
        self.counts *= kept
        self.counts[0] += np.bincount(bins, n_other / n_pixels, N_BINS)
        self.counts[1] += np.bincount(bins, n_salient / n_pixels, N_BINS)
        self.n_frames = self.n_frames * kept + 1

    @property
    def threshold(self) -> float:
        """The score above which calling all salient has the best F1; 0.5 while little is known."""
        if self.n_frames < MIN_FRAMES:
            return 0.5
        other, salient = self.counts[:, ::-1].cumsum(axis=1)[:, ::-1]
        f1 = 2 * salient / np.maximum(salient + other + salient[0], 1e-12)
        best = f1 >= f1.max() - 1e-9
        return float(np.clip(np.flatnonzero(best).mean() / N_BINS, LEAST, MOST))

    def scaled(self, scores: Scores) -> Scores:
        """Return scores of which 0.5 is the threshold, 0 and 1 stay: order is kept."""
        threshold = np.float32(self.threshold)
        below = scores * (0.5 / threshold)
        above = 0.5 + (scores - threshold) * (0.5 / (1 - threshold))
        return np.where(scores < threshold, below, above).astype(np.float32)

    def probability(self, scores: Scores) -> Scores:
        """Return how probable it is that pixels with unscaled scores are salient.

        The shares of the bins, made to rise with the score by pooling bins (isotonic
        regression), straight between the middles of pools: so that what scores higher is more
        probable, too.
        """
        if self.n_frames < MIN_FRAMES:
            return scores
        total = self.counts.sum(axis=0) + PRIOR
        shares = _rising(self.counts[1] + PRIOR * self._share(), total)
        centres = (np.arange(N_BINS) + 0.5) / N_BINS
        levels, pool = np.unique(shares, return_inverse=True)
        middles = np.bincount(pool, centres * total) / np.bincount(pool, total)
        ends = [levels[0] / 2, *levels, (1 + levels[-1]) / 2]
        return np.asarray(np.interp(scores, [0, *middles, 1], ends), np.float32)

    def _share(self) -> float:
        return float(self.counts[1].sum() / max(self.counts.sum(), 1e-12))

    def state_arrays(self) -> dict[str, Array]:
        return {"calibration": self.counts.copy(), "calibration_frames": np.array(self.n_frames)}

    def restore(self, arrays: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Take over what `state_arrays` returned; ValueError for what it was not of."""
        counts, n_frames = arrays["calibration"], arrays["calibration_frames"]
        if counts.shape != (2, N_BINS) or n_frames.shape or counts.dtype != n_frames.dtype:
            raise ValueError(f"calibration: expected (2, {N_BINS}), got {counts.shape}")
        known, n_known = counts.astype(float), float(n_frames)
        if not ((known >= 0) & (known < np.inf)).all() or not 0 <= n_known < np.inf:
            raise ValueError("calibration: expected counts, got numbers that are none")
        self.counts, self.n_frames = known, n_known


def _rising(salient: Array, total: Array) -> Array:
    """Return (n,) shares that never fall: neighbours that would are pooled."""
    pools: list[list[float]] = []  # salient, total, bins
    for s, t in zip(salient, total, strict=True):
        pools.append([s, t, 1])
        while len(pools) > 1 and pools[-2][0] * pools[-1][1] >= pools[-1][0] * pools[-2][1]:
            last = pools.pop()
            pools[-1] = [a + b for a, b in zip(pools[-1], last, strict=True)]
    return np.repeat([s / t for s, t, _ in pools], [int(n) for *_, n in pools])
