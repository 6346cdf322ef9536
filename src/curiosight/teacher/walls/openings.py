"""Where a vertical plane is seen through: what lies on either side is not one wall."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points

Array = npt.NDArray[Any]


def find_openings(
    points: Points,
    band: Array,
    to_plane: Array,
    window: tuple[float, float, float],
    n_cells: int,
    *,
    cell: float,
    margin: float = 0.02,
    min_share: float = 0.4,
) -> Mask:
    """(n_cells,) bool: the stretches of a plane that much of the view through shows farther.

    What hides a plane is nearer; what is farther shows that there is none.

    to_plane: see `coordinates_on`, of a plane before the camera.
    window: metres along to the first cell, and upwards to the bottom and the top of all.
    band: (h, w) metres, see `noise_band`. cell: metres along.
    margin: metres behind the plane that count as farther, beside the band. min_share: of the
        rays through a cell.
    """
    grids, cells = (points.depth, points.x, points.y, band), np.array([*window, cell], np.float32)
    counts = _count_through(*grids, to_plane.astype(np.float32), cells, margin, n_cells)
    openings: Mask = counts[:, 1] > min_share * np.maximum(counts[:, 0], 1)
    return openings


@njit(cache=True, nogil=True, error_model="numpy")
def _count_through(
    depth: Array,
    x: Array,
    y: Array,
    band: Array,
    to_plane: Array,
    window: Array,
    margin: float,
    n_cells: int,
) -> Array:
    """(n_cells, 2): how many rays meet the plane in each cell, and how many of them pass it.

    depth, x, y: see `Points`. window: (4,) that of `find_openings`, and the side of a cell.
    """
    counts = np.zeros((n_cells, 2), np.int64)
    low, bottom, top, cell = window
    a, b, c, offset = to_plane[0], to_plane[1], to_plane[2], to_plane[3, 2]
    wider = np.float32(margin)
    for v in range(len(y)):
        along_row, up_row, off_row = y[v] * b[0] + c[0], y[v] * b[1] + c[1], y[v] * b[2] + c[2]
        for u in range(len(x)):
            off = x[u] * a[2] + off_row
            z = -offset / off
            up = z * (x[u] * a[1] + up_row)
            place = (z * (x[u] * a[0] + along_row) - low) / cell
            if z > 0 and bottom < up < top and 0 <= place < len(counts):
                counts[int(place), 0] += 1
                counts[int(place), 1] += -(depth[v, u] * off + offset) > wider + band[v, u]
    return counts
