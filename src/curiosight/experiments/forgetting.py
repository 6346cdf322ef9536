"""What is left of each place at the end of a run that went through several."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.experiments.transfer import rounded, sums_of

Floats = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

# A place is learned when the run leaves it after so many looks there, since its begin.
N_LOOKS = 10


@dataclass(slots=True)
class Forgetting:
    """How well each place was known when one of them had been learned.

    qualities: by the place that had been learned, in the order of learning: of every place the mean
    of 1 - error of its test frames. n_looks: at each place so far. here: that of the last look.
    """

    qualities: dict[int, dict[int, float]] = field(default_factory=dict)
    n_looks: dict[int, int] = field(default_factory=dict)
    here: int | None = None

    def is_left(self, place: int) -> bool:
        """Take in the place of a look, and tell whether another has been learned by now."""
        left, self.here = self.here, place
        self.n_looks[place] = self.n_looks.get(place, 0) + 1
        if left is None or left == place or left in self.qualities:
            return False
        return self.n_looks[left] >= N_LOOKS

    def add(self, left: int, errors: Floats, places: Numbers) -> None:
        """Keep how well all places are known when one has been left; see `by_place`."""
        self.qualities[left] = by_place(errors, places)

    def summary(self, errors: Floats, places: Numbers) -> dict[str, Any] | None:
        """Return the matrix, its last row as it is now, JSON-able; None for fewer than two places.

        after, tested_on: the numbers of the places of its rows, the last of which is of the end,
        and of its columns. average_quality: at the end. backward_transfer: by how much a place is
        known better at the end than when it had been learned. forgetting: by how much less than
        when it was known best, since then. Places that the run has not left since are not in these
        two.
        """
        end = by_place(errors, places)
        learned = [place for place in self.qualities if place in end]
        columns = learned + [
            place for place in sorted(end) if place not in learned and self.n_looks.get(place)
        ]
        if len(columns) < 2 or not learned:
            return None
        rows = [[self.qualities[place].get(column) for column in columns] for place in learned]
        last = [end[column] for column in columns]
        matrix = np.array([*rows, last], float)
        return {
            "after": learned,
            "tested_on": columns,
            "qualities": [[rounded(one) for one in row] for row in matrix.tolist()],
            **sums_of(matrix, len(learned)),
        }


def by_place(errors: Floats, places: Numbers) -> dict[int, float]:
    """Return of each place the mean of 1 - error.

    errors, places: (n,) of the test frames; -1 = of no place.
    """
    return {
        int(place): float(1 - errors[places == place].mean())
        for place in np.unique(places)
        if place >= 0
    }
