"""Bodies: points that follow each other in the image without a step in depth."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from numba import njit

from curiosight.segmentation.planes import Mask
from curiosight.segmentation.supports import Support

Array = npt.NDArray[Any]


def connect_bodies(free: Mask, depth: Array, noise: float) -> Array:
    """(h, w) int32: the number of the body that each `free` point belongs to, from 1; 0 = none.

    noise: of inverse depth, 1/m.
    """
    is_smooth = free.copy()
    step = 0.02 + 2 * noise * depth**2
    is_smooth[:, 1:] &= np.abs(depth[:, 1:] - depth[:, :-1]) < step[:, 1:]
    is_smooth[1:] &= np.abs(depth[1:] - depth[:-1]) < step[1:]
    return np.asarray(cv2.connectedComponents(is_smooth.astype(np.uint8), connectivity=4)[1])


def beside_table(body: Array, table: Support) -> Mask:
    """(h, w) bool: the bodies that only lean over a table's edge, such as a chair.

    Most of such a body is outside the table's extent, or it goes on below the top and hardly
    reaches the table's core.
    """
    assert table.extent is not None
    core = table.extent if table.core is None else table.core
    counts = np.zeros((int(body.max()) + 1, 5), np.int64)
    _count_points(body, table.extent, core, table.heights, counts)
    shares = counts[:, 1:] / np.maximum(counts[:, :1], 1)
    in_extent, in_core, above, below = shares.T
    is_beside = (in_extent > 0) & (in_extent < 0.5)
    if table.core is not None:
        is_beside |= (in_extent > 0) & (np.minimum(above, below) > 0.05) & (in_core < 0.3)
    beside: Mask = is_beside.take(body)
    return beside


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
