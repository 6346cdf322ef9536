"""What of a frame is on a support: within its slab, facing up; and what is under one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import MIN_FACING, Mask
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.supports.tops import Kind

Array = npt.NDArray[Any]


def on_supports(points: Points, supports: Iterable[Support], noise: float) -> Mask:
    """(h, w) bool: within the slab of a support, if known where it is, and facing up."""
    found = np.zeros(points.depth.shape, np.bool_)
    everywhere = np.ones(points.depth.shape, np.bool_)
    for support in supports:
        # Another thing may be as high as a table elsewhere, such as a seat.
        is_known = support.core is not None or support.kind is Kind.DOUBTFUL
        is_known &= support.extent is not None
        _mark_on(
            points.depth,
            points.normals,
            support.heights,
            support.extent if is_known and support.extent is not None else everywhere,
            support.plane.normal.astype(np.float32),
            support.settings.slab,
            noise,
            found,
        )
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_on(
    depth: Array,
    normals: Array,
    heights: Array,
    extent: Array,
    up: Array,
    slab: float,
    noise: float,
    found: Array,
) -> None:
    """Mark what is on a support in (h, w) `found`: in its extent and slab, and facing up or down.

    Near an edge, where no normal is known, the inner half of the slab is the support: what is
    higher is rather the foot of something.
    """
    base, slope = np.float32(slab), np.float32(noise)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z = depth[v, u]
            band = base + slope * (z * z)
            if extent[v, u] and abs(heights[v, u]) < band:
                facing = normals[v, u, 0] * up[0] + normals[v, u, 1] * up[1]
                facing += normals[v, u, 2] * up[2]
                if facing != facing:
                    found[v, u] |= abs(heights[v, u]) < np.float32(0.5) * band
                else:
                    found[v, u] |= abs(facing) >= MIN_FACING


def under_tables(points: Points, supports: Iterable[Support]) -> Mask:
    """(h, w) bool: straight below the top of a table, or in it."""
    found = np.zeros(points.depth.shape, np.bool_)
    for support in supports:
        if support.extent is not None:
            found |= support.extent & (support.heights < support.settings.slab)
    return found
