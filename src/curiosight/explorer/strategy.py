"""What a strategy is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from curiosight.explorer.outcome import Outcome
from curiosight.frame import Viewpoint

# Looks in one stay, far over what helps.
MAX_STAY = 10_000
N_AHEAD = 4  # views decided in advance, so that their frames can be decoded meanwhile


class Strategy(Protocol):
    """Decide where to look, told after each look how wrong the prediction was.

    One that can say why is also an `Explains`.
    """

    def choose(self) -> Viewpoint:
        """Return the next viewpoint."""
        ...

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        """Take note of what came of looking there."""
        ...

    def upcoming(self) -> Sequence[Viewpoint]:
        """Return the next few viewpoints where they are already decided; changes nothing."""
        ...

    def progress_of(self, region: int) -> float | None:
        """Return the region's learning progress; None = not known, or not measured."""
        ...


def draw_stay(pool: Sequence[Viewpoint], n_views: int, rng: np.random.Generator) -> list[Viewpoint]:
    """Draw views without replacement; where the pool is exhausted, start over."""
    n_rounds = -(-n_views // len(pool))
    order = [index for _ in range(n_rounds) for index in rng.permutation(len(pool))]
    return [pool[index] for index in order[:n_views]]


def by_region(views: Sequence[Viewpoint]) -> dict[int, list[Viewpoint]]:
    """Group views by region, in the order of the regions' numbers; those in none are left out."""
    pools: dict[int, list[Viewpoint]] = {}
    for view in sorted(at_least_one(views), key=lambda view: view.region):
        if view.region >= 0:
            pools.setdefault(view.region, []).append(view)
    if not pools:
        raise ValueError("views: expected views in regions, got none that is in a region")
    return pools


def at_least_one(views: Sequence[Viewpoint]) -> Sequence[Viewpoint]:
    """Return views, or raise ValueError where there are none."""
    if not views:
        raise ValueError("views: expected at least one view, got none")
    return views
