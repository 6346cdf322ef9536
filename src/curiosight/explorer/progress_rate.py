"""Look where the error is expected to fall fastest per second of robot time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.explorer.ground import Ground, Ways
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.outlook import Outlook
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

LOOK_SECONDS = 1.0
# Views farther than this, in seconds of way, are not taken to see the same surfaces.
REACH_SECONDS = 16.0


@dataclass
class Weights:
    """Worth of what a view would show."""

    unknown: float = 0.2
    other: float = 0.03
    keep: float = 0.6
    again: float = 0.5
    n_plan: int = 10
    overlap: float = 0.9


class ProgressRate:
    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        ways: Ways | None = None,
        weights: Weights | None = None,
    ) -> None:
        self._ground = Ground(views, ways)
        self._w = weights or Weights()
        self._outlook = Outlook([view.T_world_camera for view in self._ground.views])
        self._n_looks = np.zeros(len(self._ground), np.int64)
        self._rng = rng
        self._here: int | None = None
        n = len(self._ground)
        self._gain = np.full(n, self._w.unknown)

    def choose(self) -> Viewpoint:
        ground, w = self._ground, self._w
        if self._here is None:
            number = int(self._rng.integers(len(ground)))
        else:
            seconds = ground.seconds_from(self._here) + LOOK_SECONDS
            gain = self._gain * w.again**self._n_looks
            region = self._best_region(gain, seconds)
            members = ground.members[region]
            number = int(members[np.argmax(gain[members] / seconds[members])])
        self._here = number
        return ground.views[number]

    def _best_region(self, gain: Floats, seconds: Floats) -> int:
        best, best_rate = 0, -1.0
        w = self._w
        here_region = self._ground.region_of[self._here]
        for region, members in enumerate(self._ground.members):
            top = np.sort(gain[members])[::-1][: w.n_plan]
            k = np.arange(1, len(top) + 1)
            total = np.cumsum(top * w.overlap ** (k - 1))
            way = np.sort(seconds[members])[0] - LOOK_SECONDS if region != here_region else 0.0
            rate = float((total / (way + k * (LOOK_SECONDS + 1.5))).max())
            if rate > best_rate:
                best, best_rate = region, rate
        return best

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        number = self._ground.number_of(viewpoint)
        self._n_looks[number] += 1
        if outcome.seen is None:
            return
        near = self._ground.seconds_from(number) <= REACH_SECONDS
        self._outlook.add(outcome.seen, near)
        o, w = self._outlook, self._w
        some = np.flatnonzero(near)
        known = np.isfinite(o.depth[some])
        salient = o.n_salient[some] > o.n_seen[some] / 2
        worth = np.where(salient, 1.0, w.other) * w.keep ** o.n_seen[some]
        self._gain[some] = np.where(known, worth, w.unknown).mean(axis=1)

    def upcoming(self) -> Sequence[Viewpoint]:
        return ()

    def progress_of(self, region: int) -> float | None:
        return None
