"""Which thing of a later visit is which of an earlier one: by place, size and hues.

One assignment for all (see `best_pairs`), each at most once on both sides: what two things have in
common is weighed as log-odds, and a pair that too little speaks for is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.confidence import odds_of
from curiosight.catalogue.hues import hue_distances
from curiosight.catalogue.voxels import Voxels, grown, share_in
from curiosight.frame.assignment import best_pairs

Array = npt.NDArray[Any]

# A thing stands where it stood if this share of its surface lies where it lay, and the other way
# round; things farther apart than this, metres, are not compared so.
MIN_OVERLAP, MAX_SHIFT = 0.6, 0.5
# What tells whether two things are one that was carried elsewhere, as log-odds: fitted by logistic
# regression on drawn homes, see benchmarks/objects_fit.py.
FIRST = 6.55
WEIGHTS = {
    # E-folds of height and of length by which they differ.
    "height": -5.42,
    "length": -3.12,
    # Distance of their hues: 0 = the same, 1 = none shared; and where few views tell them.
    "hues": -16.34,
    "few": -0.21,
    "hues_of_few": 5.83,
    # Farther than things are mostly carried; in another place; from a table to the floor.
    "far": -1.94,
    "elsewhere": -4.25,
    "other_level": -2.54,
    # How sure both are to be things: log-odds of the less sure one, no more than `SURE`.
    "sure": 0.71,
}
FAR, SURE = 6.0, 2.0
# What stands less high than this, metres, is on the floor.
LOW = 0.2
# What stays is likelier than what moves.
SAME_BONUS = 4.0
# A pair that less speaks for is two things.
MIN_ODDS = -3.0
# No thing is thinner, by the cubes that it is made of; metres.
THIN = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class Appearance:
    """What a thing is known again by.

    centre: (3,) metres in the world. size: metres, width, length, height. hues: (972,) shares.
    voxels: of its surface, see `voxels_of`. bottom: metres over the lowest thing of its visit.
    place: number of the place it is in; None = not known. n_views: that show it. confidence: in
    [0, 1], that it is a thing.
    """

    centre: Array
    size: tuple[float, float, float]
    hues: npt.NDArray[np.float64]
    voxels: Voxels
    bottom: float = 0.0
    place: int | None = None
    n_views: int = 8
    confidence: float = 0.9


def match_things(
    before: Sequence[Appearance], after: Sequence[Appearance]
) -> list[tuple[int, int, bool]]:
    """Return pairs of places in both, and whether the thing stands where it stood."""
    if not before or not after:
        return []
    odds, is_same = weigh_pairs(before, after)
    gain = np.maximum(odds - MIN_ODDS, 0.0)
    rows, columns = best_pairs(gain)
    return [
        (int(i), int(j), bool(is_same[i, j]))
        for i, j in zip(rows, columns, strict=True)
        if gain[i, j] > 0
    ]


def weigh_pairs(before: Sequence[Appearance], after: Sequence[Appearance]) -> tuple[Array, Array]:
    """Return (n, m) log-odds that two are one thing, and (n, m) whether it stayed where it was."""
    measures = measure_pairs(before, after)
    is_same = are_there(before, after)
    odds = FIRST + measures @ np.array(list(WEIGHTS.values()))
    return odds + np.where(is_same, SAME_BONUS, 0.0), is_same


def measure_pairs(
    before: Sequence[Appearance], after: Sequence[Appearance]
) -> npt.NDArray[np.float64]:
    """Return (n, m, 9) what is known of each pair of things, in the order of `WEIGHTS`."""
    sizes = [np.log(np.maximum([one.size for one in some], THIN)) for some in (before, after)]
    differs = np.abs(sizes[0][:, None] - sizes[1][None])
    hues = hue_distances(*([one.hues for one in some] for some in (before, after)))
    few = 1 / _of_pairs(np.minimum, [[one.n_views for one in some] for some in (before, after)])
    is_low = [[one.bottom < LOW for one in some] for some in (before, after)]
    odds = [[odds_of(one.confidence) for one in some] for some in (before, after)]
    return np.stack(
        [
            differs[..., 2],
            differs[..., 1],
            hues,
            few,
            hues * few,
            _shifts(before, after) > FAR,
            _are_elsewhere(before, after),
            _of_pairs(np.not_equal, is_low),
            np.minimum(_of_pairs(np.minimum, odds), SURE),
        ],
        axis=-1,
    ).astype(np.float64)


def _of_pairs(function: np.ufunc, values: Sequence[Sequence[float]]) -> Array:
    """Return (n, m) what a function makes of n values before and m after."""
    found: Array = function.outer(np.asarray(values[0]), np.asarray(values[1]))
    return found


def _are_elsewhere(before: Sequence[Appearance], after: Sequence[Appearance]) -> Array:
    """Return (n, m) bool: both places are known, and not the same."""
    places = [[-1 if one.place is None else one.place for one in some] for some in (before, after)]
    is_known = _of_pairs(np.logical_and, [[place >= 0 for place in some] for some in places])
    elsewhere: Array = is_known & _of_pairs(np.not_equal, places)
    return elsewhere


def _shifts(before: Sequence[Appearance], after: Sequence[Appearance]) -> Array:
    centres = [np.stack([one.centre for one in some]) for some in (before, after)]
    shifts: Array = np.linalg.norm(centres[0][:, None] - centres[1][None], axis=2)
    return shifts


def are_there(before: Sequence[Appearance], after: Sequence[Appearance]) -> Array:
    """Return (n, m) bool: the surfaces of two lie in each other."""
    shifts = _shifts(before, after)
    found = np.zeros(shifts.shape, np.bool_)
    around = [[grown(one.voxels) for one in some] for some in (before, after)]
    for i, j in np.argwhere(shifts < MAX_SHIFT).tolist():
        shares = (
            share_in(before[i].voxels, around[1][j]),
            share_in(after[j].voxels, around[0][i]),
        )
        found[i, j] = sum(shares) / 2 > MIN_OVERLAP
    return found
