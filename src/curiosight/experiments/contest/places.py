"""What is left of each place at the end of a run of a contest, from what was measured meanwhile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.runs import RunRecord
from curiosight.experiments.forgetting import Forgetting

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Left:
    """What is left of the places of a run, see `Forgetting.summary`.

    qualities: (n + 1, n) of the n places that it learned and left, in the order of that: row i when
    it left the i-th, the last row at the end. The three figures are as there.
    """

    qualities: Floats
    average_quality: float
    backward_transfer: float
    forgetting: float


def has_several_places(prepared: Prepared) -> bool:
    """Tell whether views and tests of a source are of several rooms that are known.

    Of a home that changes tests are of two homes, and nothing is told.
    """
    if not prepared.knows_places or len(prepared.phases) > 1:
        return False
    tested = set(prepared.phases[0].scored_places().tolist())
    return len((tested & set(prepared.places)) - {-1}) > 1


def places_left(prepared: Prepared, run: RunRecord) -> Left | None:
    """Return what is left of the places of a run; None where it has not left one for another.

    Errors are straight between the looks that were measured, as all errors. Only of sources that
    `has_several_places`.
    """
    place_of = dict(zip(prepared.ids, prepared.places, strict=True))
    tested, forgetting = prepared.phases[0].scored_places(), Forgetting()
    for number, id in enumerate(run.ids, start=1):
        left = forgetting.here
        if forgetting.is_left(place_of[id]) and left is not None:
            forgetting.add(left, _errors_after(run, number), tested)
    summary = forgetting.summary(run.errors[-1], tested)
    if summary is None:
        return None
    learned = len(summary["after"])
    return Left(
        np.array(summary["qualities"], float)[:, :learned],
        summary["average_quality"],
        summary["backward_transfer"],
        summary["forgetting"],
    )


def mean_in_order(left: Sequence[Left]) -> Floats:
    """Return the mean over runs of (n + 1, n) qualities: as many places as each of them learned.

    Runs learn places in orders of their own: row i is of the i-th place that each of them left.
    """
    n = min(len(one.qualities) for one in left) - 1
    mean: Floats = np.mean([one.qualities[[*range(n), -1], :n] for one in left], axis=0)
    return mean


def _errors_after(run: RunRecord, look: int) -> Floats:
    """Return (n_tests,) errors after a look, the first of which is 1."""
    columns = run.errors.T
    return np.array([np.interp(look, run.measured, column) for column in columns])
