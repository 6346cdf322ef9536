"""Where a strategy stands, and how often it has looked where."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.explorer.ground import Ground
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class Tally:
    """Count the looks at each view and in each region, from where one stands.

    here: number of the view last gone to; None before the first.
    n_seen: (n_views,) looks at each. n_looks: (n_regions,) looks in each.
    """

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self.here: int | None = None
        self._before: int | None = None
        self._is_expected = False
        self.n_seen = np.zeros(len(ground), np.int64)
        self.n_looks = np.zeros(ground.n_regions, np.int64)

    def go_to(self, number: int) -> Viewpoint:
        """Go to a view, count the look, return the view."""
        self._before, self.here = self.here, number
        self._is_expected = True
        self.n_seen[number] += 1
        self.n_looks[self.ground.region_of[number]] += 1
        return self.ground.views[number]

    def arrive(self, viewpoint: Viewpoint, seconds: float) -> None:
        """Take note of a look: how long the way there took replaces what was estimated.

        One that nobody went to by `go_to` is counted now: somebody else chose it.
        """
        if viewpoint not in self.ground:
            return
        number = self.ground.number_of(viewpoint)
        if not self._is_expected or number != self.here:
            self.go_to(number)
        self._is_expected = False
        if self._before is not None:
            self.ground.note_way(self._before, number, seconds)

    def nearest(self, among: Ints) -> int:
        """Return the nearest of some views that were not seen; else of those least often seen."""
        seconds = self.ground.seconds_from(self.here)[among]
        return int(among[np.lexsort((seconds, self.n_seen[among]))[0]])

    def stay(self, region: int, n_looks: int) -> tuple[list[int], float]:
        """Return the views of a stay, each the nearest after the other, and the seconds between.

        The way to the first is counted. Nothing is noted.
        """
        here, n_seen = self.here, self.n_seen
        self.n_seen = n_seen.copy()
        numbers: list[int] = []
        seconds = 0.0
        for _ in range(n_looks):
            number = self.nearest(self.ground.members[region])
            seconds += float(self.ground.seconds_from(self.here)[number])
            self.here = number
            self.n_seen[number] += 1
            numbers.append(number)
        self.here, self.n_seen = here, n_seen
        return numbers, seconds

    def seconds_to_regions(self) -> Floats:
        """Return the (n_regions,) seconds from here to the nearest view of each; 0 from nowhere.

        0 to the region where one stands: its next view is chosen there.
        """
        seconds = self.ground.seconds_from(self.here)
        return np.array([seconds[members].min() for members in self.ground.members])
