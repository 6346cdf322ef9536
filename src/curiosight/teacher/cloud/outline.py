"""Where the depth sensor's view ends inside the image, told by the readings themselves.

The colour image often shows more than depth: registered depth is what another camera saw, and a
stereo camera knows nothing of what its second eye does not see. Each side of such a view is a
plane through that other camera, so a line in the image, shifted by the inverse of the distance.
What ends on it is cut as if the image ended there.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.points import Points

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

# Tangents of the angles by which the two cameras may be rolled against each other.
SLOPES = (0.0, -0.04, -0.02, 0.02, 0.04)
# Metres that the other camera may be away, across the side.
SHIFTS = (0.0, 0.03, 0.06, 0.09, 0.12)
# Nothing is seen nearer, metres.
NEAREST = 0.2
# Share of the rows whose first reading may be stray.
MAX_STRAY = 0.005
# A tilted or shifted side must explain so much more of the rows than a plain one.
SIMPLER = 0.05
# First readings within this many normalised pixels agree; registration frays an outline.
TOLERANCE = 0.012
# What comes so close to a side is cut by it, in normalised pixels.
WIDTH = 0.015


@dataclass(frozen=True, slots=True)
class Side:
    """One side of the depth sensor's view: inward = offset + slope * along + shift / z.

    inward: normalised pixel that grows from this side into the image: x, y, -x or -y, as axis
    (0 or 1) and sign say. along: the other normalised pixel. shift: metres.
    """

    axis: int
    sign: int
    offset: float
    slope: float
    shift: float


def find_outline(frames: Iterable[Points], *, min_agree: float = 0.7) -> tuple[Side, ...]:
    """Return the sides of the view that the frames of one camera share.

    A side is where the first readings of most rows, or columns, lie on one line, and hardly any
    before it: holes have ragged or slanted outlines, and few objects are so wide. Where the line
    is one only when shifted with the distance, a smaller share tells as much.

    min_agree: share of the rows or columns with a reading.
    """
    frames = list(frames)
    sides = []
    for axis, sign in product((0, 1), (1, -1)) if frames else ():
        first = np.concatenate([_first_readings(points, axis, sign) for points in frames])
        side = _fit(first, axis, sign, min_agree) if len(first) else None
        sides += [] if side is None else [side]
    return tuple(sides)


def cut_by(outline: Iterable[Side], points: Points) -> Mask:
    """(h, w) bool: the readings at the outline of the depth sensor's view.

    A side that clearly more than stray readings of this frame lie beyond is none.
    """
    is_cut = np.zeros(points.depth.shape, np.bool_)
    for side in outline:
        depth, inward, lines = _from_side(points, side.axis, side.sign)
        line = (side.offset + side.slope * lines).astype(np.float32)
        first = _inward_of_first(depth, inward, line, side.shift)
        if np.count_nonzero(first < -2 * TOLERANCE) <= MAX_STRAY * len(lines):
            found = (is_cut if side.axis == 0 else is_cut.T)[:, :: side.sign]
            _mark_near(depth, inward, line, side.shift, WIDTH, found)
    return is_cut


def _from_side(points: Points, axis: int, sign: int) -> tuple[Array, Array, Array]:
    """Return depth in rows, or columns, from a side on, and the pixels inward and along it."""
    depth, across, lines = points.depth, points.x, points.y
    if axis == 1:
        depth, across, lines = depth.T, lines, across
    return depth[:, ::sign], sign * across[::sign], lines


@njit(cache=True, nogil=True, error_model="numpy")
def _inward_of_first(depth: Array, inward: Array, line: Array, shift: float) -> Array:
    """(h,): how far inside of the line the first reading of every row is; inf = no reading."""
    found = np.full(len(line), np.inf)
    for v in range(len(line)):
        for u in range(len(inward)):
            if depth[v, u] > 0:
                found[v] = inward[u] - line[v] - shift / depth[v, u]
                break
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_near(
    depth: Array, inward: Array, line: Array, shift: float, width: float, found: Array
) -> None:
    """Set (h, w) `found` where a reading is no farther inside of the line than a width."""
    for v in range(len(line)):
        for u in range(len(inward)):
            z = depth[v, u]
            if z > 0 and inward[u] < line[v] + shift / z + width:
                found[v, u] = True
            elif inward[u] > line[v] + shift / NEAREST + width:
                break


def _first_readings(points: Points, axis: int, sign: int) -> Array:
    """(n, 3): inward, along and 1/z of the first reading of every row, or column, that has one."""
    depth, inward, lines = _from_side(points, axis, sign)
    has_reading = np.isfinite(depth)
    first = has_reading.argmax(axis=1)
    where = np.flatnonzero(has_reading[np.arange(len(depth)), first])
    first = first[where]
    return np.stack([inward[first], lines[where], 1 / depth[where, first]], axis=1)


def _fit(first: Array, axis: int, sign: int, min_agree: float) -> Side | None:
    """Return the line on which most of (n, 3) first readings lie, the simplest of the best."""
    shift, slope = np.array(list(product(SHIFTS, SLOPES))).T[..., None]
    inward = first[:, 0] - slope * first[:, 1] - shift * first[:, 2]
    n_stray = int(MAX_STRAY * len(first))
    offset = np.partition(inward, n_stray, axis=1)[:, n_stray]
    agree = np.mean(inward < offset[:, None] + TOLERANCE, axis=1)
    # A line that is not the simplest must be better than that by more than chance.
    best = int(np.argmax(agree - SIMPLER * (np.arange(len(agree)) > 0)))
    is_shifted = shift[best, 0] > 0 and agree[best] > 3 * agree[0]
    if agree[best] < (0.5 if is_shifted else 1) * min_agree:
        return None
    return Side(axis, sign, float(offset[best]), float(slope[best, 0]), float(shift[best, 0]))
