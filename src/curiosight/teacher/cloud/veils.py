"""Veils: readings between what is near and what is behind it, of no surface at all.

A sensor that smooths, as those do that measure the time of light, strings points from the edge of
a thing to what is behind it. They tie the two together in space.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points

Array = npt.NDArray[Any]
# Metres along the view for each metre across it, on both sides of a point: a surface that is turned
# away from the camera by more than 80 degrees is rather none.
MIN_SLOPE = 6.0
# Share of the points that are so in a view of a sensor that smooths: it veils every edge. Others
# show a tenth of that, by chance.
MIN_SHARE = 0.004


def find_veils(points: Points) -> Mask:
    """(h, w) bool: the points where depth rises, or falls, steeply from one side to the other.

    None where they are few, as in the view of a sensor that has sharp edges.
    """
    is_veil = np.zeros(points.depth.shape, np.bool_)
    if min(is_veil.shape) >= 3:
        steps = abs(points.x[1] - points.x[0]), abs(points.y[1] - points.y[0])
        _mark_veils(points.depth, MIN_SLOPE * steps[0], MIN_SLOPE * steps[1], is_veil)
    is_rare = np.count_nonzero(is_veil) < MIN_SHARE * is_veil.size
    return np.zeros_like(is_veil) if is_rare else is_veil


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_veils(depth: Array, across: float, down: float, is_veil: Array) -> None:
    """Mark (h, w) `is_veil`; across, down: least step to the next column and row, over depth."""
    least_across, least_down = np.float32(across), np.float32(down)
    for v in range(depth.shape[0]):
        above, row, below = depth[max(v - 1, 0)], depth[v], depth[min(v + 1, depth.shape[0] - 1)]
        for u in range(depth.shape[1]):
            here, right = row[u], min(u + 1, depth.shape[1] - 1)
            # Beside a hole a step is NaN and compares false; beyond the grid it is 0.
            one, other = here - row[max(u - 1, 0)], row[right] - here
            least = least_across * here
            is_steep = (one > least) & (other > least) | (one < -least) & (other < -least)
            one, other = here - above[u], below[u] - here
            least = least_down * here
            is_steep |= (one > least) & (other > least) | (one < -least) & (other < -least)
            is_veil[v, u] = is_steep
