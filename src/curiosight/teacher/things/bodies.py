"""Bodies: points that follow each other in the image without a step in depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.supports.supports import Support

Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """The bodies of a frame.

    number: (h, w) int32, of the body that each point belongs to, from 1; 0 = none.
    n: how many there are, with the 0.
    """

    number: Array
    n: int


def connect_bodies(free: Mask, depth: Array, noise: float) -> Bodies:
    """Return the bodies of the (h, w) `free` points; noise: of inverse depth, 1/m."""
    is_smooth = np.zeros(free.shape, np.uint8)
    _mark_smooth(free, depth, 2 * noise, is_smooth)
    n, number = cv2.connectedComponents(is_smooth, connectivity=4)
    return Bodies(number, n)


def beside_table(bodies: Bodies, table: Support) -> Array:
    """(n_bodies,) bool: the bodies that only lean over a table's edge, such as a chair.

    Most of such a body is outside the table's extent, or it goes on below the top and hardly
    reaches the table's core.
    """
    if table.extent is None:
        return np.zeros(bodies.n, np.bool_)
    core = table.extent if table.core is None else table.core
    counts = np.zeros((bodies.n, 5), np.int64)
    _count_points(bodies.number, table.extent, core, table.heights, counts)
    shares = counts[:, 1:] / np.maximum(counts[:, :1], 1)
    in_extent, in_core, above, below = shares.T
    is_beside: Array = (in_extent > 0) & (in_extent < 0.5)
    if table.core is not None:
        is_beside |= (in_extent > 0) & (np.minimum(above, below) > 0.05) & (in_core < 0.3)
    return is_beside


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_smooth(free: Array, depth: Array, noise: float, is_smooth: Array) -> None:
    """Set (h, w) `is_smooth` to 1 where a free point follows those to its left and above it."""
    slope = np.float32(noise)
    for v in range(free.shape[0]):
        for u in range(free.shape[1]):
            here = depth[v, u]
            step = np.float32(0.02) + slope * (here * here)
            follows_left = (u == 0) | (abs(here - depth[v, max(u - 1, 0)]) < step)
            follows_above = (v == 0) | (abs(here - depth[max(v - 1, 0), u]) < step)
            is_smooth[v, u] = free[v, u] & follows_left & follows_above


@njit(cache=True, nogil=True, error_model="numpy")
def _count_points(body: Array, extent: Array, core: Array, heights: Array, counts: Array) -> None:
    """Add to the (n_bodies, 5) counts of points: all, in extent and core, above and below."""
    for v in range(body.shape[0]):
        for u in range(body.shape[1]):
            number = body[v, u]
            if number == 0:
                continue
            counts[number, 0] += 1
            counts[number, 1] += extent[v, u]
            counts[number, 2] += core[v, u]
            counts[number, 3] += heights[v, u] > 0.03
            counts[number, 4] += heights[v, u] < -0.03
