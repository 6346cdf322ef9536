"""What one view teaches: samples, and what tells the place that they are of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Camera
from curiosight.learner.description import Counts
from curiosight.learner.features import Rows
from curiosight.learner.sight import Sight

Array = npt.NDArray[Any]
Labels = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """What one view teaches.

    rows, is_salient: (n, F) and (n,) samples. sight: what tells its place.
    share: of its labelled pixels, those that are salient; None = as of the samples.
    """

    rows: Rows
    is_salient: Labels
    sight: Sight | None = None
    share: float | None = None

    def counts(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return (n,) of how much each sample stands for, where salient and where not."""
        salient, other = self.is_salient.astype(float), (~self.is_salient).astype(float)
        if self.share is None:
            return salient, other
        n_salient, n_other = max(salient.sum(), 1), max(other.sum(), 1)
        return salient * self.share / n_salient, other * (1 - self.share) / n_other


@dataclass(frozen=True, slots=True, eq=False)
class Visit:
    """A view that is described and labelled once, to be learned from many times.

    rows: (n, F) of its description. counts: (n,) salient and (n,) other pixels of each.
    lesson: what was drawn of it to learn from.
    """

    rows: Rows
    counts: tuple[Counts, Counts]
    lesson: Lesson


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Samples as they were drawn of a look, and where chance stood then.

    rows: (m, F) that they were drawn from. which, is_salient: (n,) the row of each, in the order
    drawn. chances: the states of the sources of
    chance by which they are learned from; one, where forests share that of their learner.
    """

    rows: Rows
    which: npt.NDArray[np.integer]
    is_salient: Labels
    chances: tuple[Mapping[str, Any], ...]

    def samples(self) -> Rows:
        """Return (n, F), a row each."""
        samples: Rows = self.rows[self.which]
        return samples

    def without_rest(self) -> Drawn:
        """Return the same without the rows that nothing was drawn from."""
        rows, which = _only_used(self.rows, self.which)
        return Drawn(rows, which, self.is_salient, self.chances)


@dataclass(frozen=True, slots=True, eq=False)
class Taught:
    """All that a look changes a learner by, for `SaliencyLearner.learn_again`.

    error: before it was learned from, see `Experts.update`. camera: of its frame, if known.
    calibration: `Calibration.state_arrays` after the look; None = scores are not scaled.
    """

    drawn: Drawn
    sight: Sight | None
    error: float | None
    camera: Camera | None
    calibration: Mapping[str, npt.NDArray[np.generic]] | None

    def without_rest(self) -> Taught:
        """Return the same, see `Drawn.without_rest`."""
        return replace(self, drawn=self.drawn.without_rest())


@njit(cache=True, nogil=True)
def _only_used(rows: Array, which: Array) -> tuple[Array, Array]:
    """Return the rows that (n,) numbers tell, each once, and these numbers then."""
    numbers = np.full(len(rows), -1, np.int32)
    for place in range(len(which)):
        numbers[which[place]] = 0
    n_used = 0
    for row in range(len(rows)):
        if numbers[row] == 0:
            numbers[row] = n_used
            n_used += 1
    used = np.empty((n_used, rows.shape[1]), rows.dtype)
    for row in range(len(rows)):
        if numbers[row] >= 0:
            used[numbers[row]] = rows[row]
    then = np.empty(len(which), np.int32)
    for place in range(len(which)):
        then[place] = numbers[which[place]]
    return used, then


def join_lessons(lessons: Sequence[Lesson], n_features: int) -> tuple[Rows, Labels]:
    """Return the samples of all lessons, one after the other."""
    nothing = Lesson(np.empty((0, n_features), np.uint8), np.empty(0, np.bool_))
    rows = np.concatenate([lesson.rows for lesson in (nothing, *lessons)])
    return rows, np.concatenate([lesson.is_salient for lesson in (nothing, *lessons)])
