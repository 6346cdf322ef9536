"""Which thing of a later visit is which of an earlier one: by place, size and colours.

One assignment for all (see `best_pairs`), each
at most once on both sides: what two things have in common is weighed as log-odds, and a pair that
less speaks for than against is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.catalogue.detection import COLOUR_BINS
from curiosight.catalogue.voxels import Voxels, grown, share_in
from curiosight.frame.assignment import best_pairs

Array = npt.NDArray[Any]

# A thing stands where it stood if this share of its surface lies where it lay, and the other way
# round; things farther apart than this, metres, are not compared so.
MIN_OVERLAP, MAX_SHIFT = 0.6, 0.5
# Log-odds, fitted by logistic regression on the things of the drawn home 31: at first; for each
# e-fold of height and length; for the distance of hues (0 = the same, 1 = none shared).
FIRST, PER_HEIGHT, PER_LENGTH, PER_HUES = 4.9, -5.3, -1.8, -11.4
# What stays is likelier than what moves; things are carried about in a room more than farther, and
# seldom from a table to the floor: what stands less high than this, metres, is on the floor.
SAME_BONUS, PER_METRE, ELSEWHERE, FAR, OTHER_LEVEL, LOW = 4.0, -0.1, -3.9, 6.0, -3.0, 0.2
# A pair that less speaks for is two things.
MIN_ODDS = -3.0
# Hues beside each other are alike: standard deviation in bins.
BLUR, BLUR_SIZE = 0.5, (5, 5)
# No thing is thinner, by the cubes that it is made of; metres.
THIN = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class Appearance:
    """What a thing is known again by.

    centre: (3,) metres in the world. size: metres, width, length, height. colours: (300,) shares.
    voxels: of its surface, see `voxels_of`. bottom: metres over the lowest thing of its visit.
    """

    centre: Array
    size: tuple[float, float, float]
    colours: npt.NDArray[np.float64]
    voxels: Voxels
    bottom: float = 0.0


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
    centres = [np.stack([one.centre for one in some]) for some in (before, after)]
    shifts = np.linalg.norm(centres[0][:, None] - centres[1][None], axis=2)
    sizes = [np.log(np.maximum([one.size for one in some], THIN)) for some in (before, after)]
    differs = np.abs(sizes[0][:, None] - sizes[1][None])
    roots = [np.sqrt([_hues(one.colours) for one in some]) for some in (before, after)]
    # Hellinger's distance.
    hues = np.sqrt(np.maximum(0.0, 1.0 - roots[0] @ roots[1].T))
    odds = FIRST + PER_HEIGHT * differs[..., 2] + PER_LENGTH * differs[..., 1] + PER_HUES * hues
    is_low = [np.array([one.bottom < LOW for one in some]) for some in (before, after)]
    odds += OTHER_LEVEL * (is_low[0][:, None] != is_low[1][None])
    is_same = _are_there(before, after, shifts)
    moving = PER_METRE * shifts + ELSEWHERE * (shifts > FAR)
    odds += np.where(is_same, SAME_BONUS, moving)
    return odds, is_same


def _are_there(before: Sequence[Appearance], after: Sequence[Appearance], shifts: Array) -> Array:
    """Return (n, m) bool: the surfaces of two lie in each other."""
    found = np.zeros(shifts.shape, np.bool_)
    around = [[grown(one.voxels) for one in some] for some in (before, after)]
    for i, j in np.argwhere(shifts < MAX_SHIFT).tolist():
        shares = (
            share_in(before[i].voxels, around[1][j]),
            share_in(after[j].voxels, around[0][i]),
        )
        found[i, j] = sum(shares) / 2 > MIN_OVERLAP
    return found


def _hues(colours: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return (300,) the share of each hue, neighbours among it, in bands of height."""
    bands = colours.reshape(COLOUR_BINS)
    blurred = [
        cv2.GaussianBlur(band, BLUR_SIZE, BLUR, borderType=cv2.BORDER_REPLICATE) for band in bands
    ]
    return np.concatenate(blurred, axis=None).astype(np.float64)
