"""Bodies: points that follow each other in the image without a step in depth."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

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
    touched = np.bincount(body[table.extent])
    size = np.maximum(np.bincount(body.ravel()), 1)

    def share(where: Mask) -> Array:
        inside: Array = np.bincount(body[where], minlength=len(size)) / size
        return inside

    is_beside = share(table.extent) < 0.5
    if table.core is not None:
        crosses = np.minimum(share(table.heights > 0.03), share(table.heights < -0.03)) > 0.05
        is_beside |= crosses & (share(table.core) < 0.3)
    is_beside[0] = False
    is_beside[: len(touched)] &= touched > 0
    beside: Mask = is_beside[body]
    return beside
