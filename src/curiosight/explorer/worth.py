"""What a look is worth: how new that is which it would show, and whether it can be learned."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.explorer.outlook import Outlook

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


# A region predicted this well, beside all, is worth as much as any.
ENOUGH = 0.35


@dataclass(frozen=True, slots=True)
class Worth:
    """How much each part of a view counts.

    other: a surface that is no object, beside one that is. unknown: what has not been seen.
    keep: of what a surface is worth, what one more look at it leaves. again: of a view, what one
    more look from there leaves. doubt: of what is known, what is not believed any more where
    another region has changed.
    """

    other: float = 0.03
    unknown: float = 0.15
    keep: float = 0.7
    again: float = 0.02
    doubt: float = 0.3
    least_salient: float = 0.01

    def of(self, outlook: Outlook, views: Ints) -> tuple[Floats, Floats]:
        """Return (n,) of views: what would be new in it, and 1 if it shows things, else 0.

        The first is the root of a share: twice as much of the same is not worth twice as much.
        The second is 1 too where half of the view is unknown.
        """
        is_known, is_salient = outlook.is_known(views), outlook.is_salient(views)
        worth = np.where(is_salient, 1.0, self.other) * self.keep ** outlook.n_seen[views]
        fresh = np.where(is_known, worth, self.unknown).mean(axis=1)
        shows = (is_salient.mean(1) > self.least_salient) | (is_known.mean(1) < 0.5)
        return np.sqrt(fresh), shows.astype(np.float64)


class Learnability:
    """How well the views of each region are predicted before they are learned, beside all.

    n_recent: looks of a region that count. A region of which little is known counts as one like
    all others. least: none is worth less than that.
    """

    def __init__(
        self, n_regions: int, *, n_recent: int = 12, n_prior: int = 1, least: float = 0.02
    ) -> None:
        self._recent = [deque[float](maxlen=n_recent) for _ in range(n_regions)]
        self._n_prior, self._least = n_prior, least

    def add(self, region: int, error: float | None) -> None:
        """Note the error of a look; None = it has none."""
        if error is not None:
            self._recent[region].append(error)

    def forget(self, region: int) -> None:
        """Take a region for new."""
        self._recent[region].clear()

    def of_regions(self) -> Floats:
        """Return (n_regions,) from `least`: 1 = as all are."""
        known = [1 - np.array(recent) for recent in self._recent]
        everything = np.concatenate([np.empty(0), *known])
        usual = max(float(everything.mean()), 0.05) if len(everything) else 1.0
        found = [
            (scores.sum() + self._n_prior * usual) / (len(scores) + self._n_prior)
            for scores in known
        ]
        return np.clip((np.array(found) / (ENOUGH * usual)) ** 3, self._least, 1.0)
