"""Which way is up: from one frame, or once for a whole recording with poses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.points import Points

Array = npt.NDArray[Any]

# A camera that looks 25° down sees "up" here; tilts of -20° to 70° are within 45° of it.
CAMERA_UP_PRIOR = np.array([0.0, -np.cos(np.radians(25)), -np.sin(np.radians(25))])

# Within 55° of one of them is every direction.
AXES = np.concatenate([np.eye(3), -np.eye(3)])


def up_from_normals(
    normals: Array, area: Array, *, prior: Array, max_angle: float = np.radians(45)
) -> Array | None:
    """Return the unit vector within `max_angle` of `prior` that most surface faces.

    normals: (n, 3) unit vectors, NaN = unknown; area: (n,) their weights. None when hardly any
    surface lies in that cone: then nothing horizontal is in view.
    """
    return next(ups_from_normals(normals, area, prior=prior, max_angle=max_angle), None)


def ups_from_normals(
    normals: Array,
    area: Array,
    *,
    prior: Array = CAMERA_UP_PRIOR,
    max_angle: float = np.radians(45),
    max_candidates: int = 3,
) -> Iterator[Array]:
    """Yield what may be up as `up_from_normals` does, then what the remaining surface faces."""
    normals, area = np.asarray(normals, np.float32), np.asarray(area, np.float32)
    total = area.sum()
    # What is out of the question counts nothing.
    normals, area = _between(normals, area, prior.astype(np.float32), np.cos(max_angle), np.inf)
    for _ in range(max_candidates):
        if total == 0 or area.sum() < 0.02 * total:
            return
        up = settled(normals, area, _densest(normals, area, prior), (12, 8, 5))
        yield up
        far = up.astype(np.float32), -np.inf, np.cos(np.radians(15))
        normals, area = _between(normals, area, *far)


def settled(normals: Array, votes: Array, up: Array, widths_deg: Iterable[float]) -> Array:
    """Return the mean of the (n, 3) normals that are near it, for one width after the other."""
    for width in np.radians([*widths_deg]):
        total = np.zeros(3)
        _sum_facing(normals, votes, up.astype(np.float32), np.cos(width), total)
        length = float(np.linalg.norm(total))
        up = total / length if length > 0 else up
    return up


def votes_on_up(points: Points, max_range: float) -> Array:
    """(h, w) float32: how much each point's surface counts, 0 beyond a range in metres.

    Its area, less the farther it is: the noise of a normal grows with the distance.
    """
    return np.where(points.depth < max_range, points.area, np.float32(0))


def _cosines(normals: Array, direction: Array) -> Array:
    cosines: Array = normals @ direction.astype(np.float32)
    return cosines


@njit(cache=True, nogil=True, error_model="numpy")
def _between(
    normals: Array, area: Array, direction: Array, low: float, high: float
) -> tuple[Array, Array]:
    """Return the normals, with their area, whose cosine to a direction is between two."""
    least, most, n = np.float32(low), np.float32(high), 0
    taken, of_taken = np.empty_like(normals), np.empty_like(area)
    for i in range(len(area)):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        cosine = x * direction[0] + y * direction[1] + z * direction[2]
        if area[i] > 0 and cosine > least and cosine < most:
            taken[n, 0], taken[n, 1], taken[n, 2], of_taken[n] = x, y, z, area[i]
            n += 1
    return taken[:n], of_taken[:n]


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_facing(
    normals: Array, area: Array, direction: Array, min_cosine: float, total: Array
) -> None:
    """Add the (n, 3) normals near a direction, times their area, to the (3,) `total`."""
    a, b, c = direction
    least, nothing = np.float32(min_cosine), np.float32(0)
    for i in range(len(area)):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        # Without a branch, which would be foretold badly; nothing times NaN would be NaN.
        is_near = (area[i] > 0) & (x * a + y * b + z * c > least)
        weight = np.float64(area[i] if is_near else nothing)
        total[0] += weight * (x if is_near else nothing)
        total[1] += weight * (y if is_near else nothing)
        total[2] += weight * (z if is_near else nothing)


@njit(cache=True, nogil=True, error_model="numpy")
def _densest(normals: Array, area: Array, prior: Array, step: float = 0.07) -> Array:
    """Return the centre of the fullest cell (about 4°) of the cone around `prior`."""
    # The axis that is farther away: along the first there may be none.
    far, votes, axes = np.zeros(3), np.zeros((35, 35)), np.empty((2, 3), np.float32)
    far[0 if abs(prior[0]) < 0.9 else 1] = 1
    side = across(prior, far)
    other = across(prior, side)
    for axis in range(3):
        axes[0, axis], axes[1, axis] = side[axis] / step, other[axis] / step
    _vote(normals, area, axes, votes[1:-1, 1:-1])
    most, x, y = -1.0, 0.0, 0.0
    for row in range(1, 34):
        for column in range(1, 34):
            beside = votes[row - 1, column] + votes[row + 1, column]
            around = votes[row, column] + beside + votes[row, column - 1] + votes[row, column + 1]
            if around > most:
                most, x, y = around, (row - 16.5) * step, (column - 16.5) * step
    up, ahead = np.empty(3), np.sqrt(max(0.0, 1 - x * x - y * y))
    for axis in range(3):
        up[axis] = x * side[axis] + y * other[axis] + ahead * prior[axis]
    _scale(up)
    return up


@njit(cache=True, nogil=True, error_model="numpy")
def across(one: Array, other: Array) -> Array:
    """Return the (3,) unit vector at right angles to both."""
    x = one[1] * other[2] - one[2] * other[1]
    y = one[2] * other[0] - one[0] * other[2]
    z = one[0] * other[1] - one[1] * other[0]
    found = np.array([x, y, z])
    _scale(found)
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _scale(vector: Array) -> None:
    """Make a (3,) vector one of length 1."""
    length = np.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
    for axis in range(3):
        vector[axis] /= length


@njit(cache=True, nogil=True, error_model="numpy")
def _vote(normals: Array, area: Array, axes: Array, votes: Array) -> None:
    """Add the area to the (33, 33) votes of the cells that the normals point to.

    axes: (2, 3) directions of rows and columns, divided by the side of a cell.
    """
    for i in range(len(area)):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        if area[i] > 0:
            # No component is below -1, so that all cells are positive and truncated as floors are.
            row = int(x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2] + 16)
            column = int(x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2] + 16)
            votes[row, column] += area[i]


def directions_of(normals: Array, votes: Array, *, max_candidates: int = 8) -> Iterator[Array]:
    """Yield the directions, of all there are, that most surface faces, the most faced first.

    normals: (n, 3) unit vectors, NaN = unknown; votes: (n,) their weights. Directions are 15°
    apart at least.
    """
    normals, votes = np.asarray(normals, np.float32), np.asarray(votes, np.float32)
    least = 0.02 * votes.sum()
    for _ in range(max_candidates):
        found = [
            (_votes_near(normals, votes, up), up)
            for axis in AXES
            for up in [up_from_normals(normals, votes, prior=axis, max_angle=np.radians(60))]
            if up is not None
        ]
        most, up = max(found, key=lambda pair: pair[0], default=(0.0, None))
        if up is None or most <= least:
            return
        yield up
        votes = np.where(_cosines(normals, up) < np.cos(np.radians(15)), votes, 0)


def _votes_near(normals: Array, votes: Array, up: Array) -> float:
    return float(votes[_cosines(normals, up) > np.cos(np.radians(8))].sum())
