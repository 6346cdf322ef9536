"""The views to choose from, region by region, and how long the ways between them are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from curiosight.explorer.measured_ways import MeasuredWays
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
# (n,) seconds from one viewpoint to n others.
Ways = Callable[[Viewpoint, Sequence[Viewpoint]], Floats]
# What a look takes, beside the way to it.
LOOK_SECONDS = 1.0
# Of a region so many views stand for all, when ways to other regions are measured.
N_STARTS = 5
CACHED = ("_estimated_between", "_estimated_inside")


class Ground:
    """Views by number, their regions, and the ways between them.

    views: those in no region are left out. ways: as estimated, corrected by what `note_way`
    is told; None = not known, as if they took no time.
    region_of: (n,) number of each view's region, from 0 without gaps. regions: their own numbers.
    """

    def __init__(self, views: Sequence[Viewpoint], ways: Ways | None = None) -> None:
        self.views = sorted((view for view in views if view.region >= 0), key=lambda v: v.index)
        if not self.views:
            raise ValueError("views: expected at least one view in a region, got none")
        numbers = np.array([view.region for view in self.views], np.int64)
        self.regions, self.region_of = np.unique(numbers, return_inverse=True)
        self.members = [np.flatnonzero(self.region_of == r) for r in range(len(self.regions))]
        self._number_of = {view.index: number for number, view in enumerate(self.views)}
        self.ways = ways
        self._measured = MeasuredWays(self.n_regions)
        # As estimated; what is measured comes on top. None: known before, to be found again.
        self._rows: dict[int, Floats | None] = {}
        self._blocks: dict[int, Floats] = {}

    def __getstate__(self) -> dict[str, object]:
        """Return what is copied and pickled: all but the ways, which are found again."""
        found_again = {"_rows": dict.fromkeys(self._rows), "_blocks": {}}
        known = {name: one for name, one in vars(self).items() if name not in CACHED}
        return known | found_again

    def __len__(self) -> int:
        return len(self.views)

    def __contains__(self, viewpoint: Viewpoint) -> bool:
        return viewpoint.index in self._number_of

    @property
    def n_regions(self) -> int:
        return len(self.regions)

    def number_of(self, viewpoint: Viewpoint) -> int:
        """Return the number of a view here."""
        return self._number_of[viewpoint.index]

    def seconds_from(self, here: int | None) -> Floats:
        """Return the (n,) seconds from a view to all; 0 from nowhere, before the first look."""
        if here is None:
            return np.zeros(len(self))
        estimated = self._estimated_from(here)
        if not self._measured.is_any:
            return estimated
        beyond = self._measured.beyond[self.region_of[here], self.region_of]
        seconds: Floats = np.maximum(estimated + beyond, 0.0)
        seconds[here] = estimated[here]  # to stay takes no time
        return seconds

    def _estimated_from(self, here: int) -> Floats:
        if self.ways is None:
            return np.zeros(len(self))
        row = self._rows.get(here)
        if row is None:
            row = self._rows[here] = self.ways(self.views[here], self.views)
        return row

    def note_way(self, start: int, goal: int, seconds: float) -> None:
        """Note how long the way from one view to another took; 0 = that is not known."""
        if self.ways is None or start == goal or not seconds > 0:
            return
        if start in self._rows:
            one = self._estimated_from(start)[goal]
        else:
            one = self.ways(self.views[start], [self.views[goal]])[0]
        regions = int(self.region_of[start]), int(self.region_of[goal])
        self._measured.note(*regions, float(one), seconds)

    def among(self, region: int) -> Floats:
        """Return the (m, m) seconds between the views of a region, as estimated."""
        if region not in self._blocks:
            views = [self.views[number] for number in self.members[region]]
            if self.ways is None:
                self._blocks[region] = np.zeros((len(views), len(views)))
            else:
                self._blocks[region] = np.stack([self.ways(start, views) for start in views])
        return self._blocks[region]

    @property
    def between(self) -> Floats:
        """(n_regions, n_regions) seconds from region to region; 0 from one to itself.

        To the nearest view there, the mean over some views to start from.
        """
        beyond = self._measured.beyond * ~np.eye(self.n_regions, dtype=bool)
        return np.maximum(self._estimated_between + beyond, 0.0)

    @property
    def inside(self) -> Floats:
        """(n_regions,) mean seconds from a view to the nearest other of its region."""
        beyond = np.where(
            [len(views) > 1 for views in self.members], self._measured.beyond.diagonal(), 0
        )
        return np.maximum(self._estimated_inside + beyond, 0.0)

    @cached_property
    def _estimated_between(self) -> Floats:
        seconds = np.zeros((self.n_regions, self.n_regions))
        for start in range(self.n_regions):
            ways = self._from_some(start)
            seconds[start] = [ways[:, goal].min(axis=1).mean() for goal in self.members]
        np.fill_diagonal(seconds, 0.0)
        return seconds

    @cached_property
    def _estimated_inside(self) -> Floats:
        steps = np.zeros(self.n_regions)
        for region, members in enumerate(self.members):
            if len(members) > 1:
                ways = np.sort(self._from_some(region)[:, members], axis=1)
                steps[region] = ways[:, 1].mean()  # the first is the view itself
        return steps

    def _from_some(self, region: int) -> Floats:
        """Return (k, n) seconds to all views from some of a region, spread over it."""
        members = self.members[region]
        spread = np.linspace(0, len(members) - 1, min(N_STARTS, len(members))).round()
        return np.stack([self._estimated_from(int(start)) for start in members[spread.astype(int)]])
