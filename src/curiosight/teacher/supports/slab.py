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
# What a point can be on, in the order in which one tells more than another.
NOTHING, ON_FLOOR, ON_TABLE, ON_FURNITURE, ON_DOUBTFUL = range(5)
ON: dict[Kind, int] = {
    Kind.TABLE: ON_TABLE,
    Kind.FURNITURE: ON_FURNITURE,
    Kind.DOUBTFUL: ON_DOUBTFUL,
    Kind.BARE: ON_DOUBTFUL,
}


def on_supports(points: Points, supports: Iterable[Support], noise: float) -> Array:
    """(h, w) uint8: the kind of support in whose slab a point is, facing up.

    Where it is known where a support is, it is nowhere else.
    """
    kinds = np.zeros(points.depth.shape, np.uint8)
    everywhere = np.ones(points.depth.shape, np.bool_)
    for support in supports:
        # Another thing may be as high as a table elsewhere, such as a seat.
        is_known = support.core is not None or ON[support.kind] == ON_DOUBTFUL
        extent = support.extent if is_known else None
        _mark_on(
            *(points.depth, points.normals, support.heights),
            everywhere if extent is None else extent,
            support.plane.normal.astype(np.float32),
            *(support.settings.slab, noise, ON[support.kind] if support.is_table else ON_FLOOR),
            kinds,
        )
    return kinds


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_on(
    depth: Array,
    normals: Array,
    heights: Array,
    extent: Array,
    up: Array,
    slab: float,
    noise: float,
    kind: int,
    kinds: Array,
) -> None:
    """Mark what is on a support in (h, w) `kinds`: in its extent and slab, and facing up or down.

    Near an edge, where no normal is known, the inner half of the slab is the support: what is
    higher is rather the foot of something.
    """
    base, slope = np.float32(slab), np.float32(noise)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z, height = depth[v, u], abs(heights[v, u])
            band = base + slope * (z * z)
            if kinds[v, u] < kind and extent[v, u] and height < band:
                facing = normals[v, u, 0] * up[0] + normals[v, u, 1] * up[1]
                facing += normals[v, u, 2] * up[2]
                if abs(facing) >= MIN_FACING or (facing != facing and 2 * height < band):
                    kinds[v, u] = kind


def under_tables(points: Points, supports: Iterable[Support]) -> Mask:
    """(h, w) bool: straight below the top of a table, or in it."""
    found = np.zeros(points.depth.shape, np.bool_)
    for support in supports:
        if support.extent is not None:
            found |= support.extent & (support.heights < support.settings.slab)
    return found
