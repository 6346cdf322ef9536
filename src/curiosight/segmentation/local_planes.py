"""Local planes: the normal of the surface at each pixel, from a fit in inverse depth.

1/z = a x + b y + c on a plane (`points.py`), so the fit is linear and (a, b, c) is along the
normal.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from numba import njit

Array = npt.NDArray[Any]

# Less than this cosine between normal and ray is noise, and would make areas too large.
MIN_COSINE = 0.1


def fit_local_planes(
    inverse: Array, x: Array, y: Array, radius: int, max_bend: float
) -> tuple[Array, Array]:
    """Return the (h, w, 3) normal and the (h, w) area of each pixel, see `Points`.

    inverse: (h, w) float32 1/z, NaN = no reading. x, y: (w,) and (h,) float32 normalised pixels,
    evenly spaced. radius, max_bend: see `observe_points`.
    """
    height, width = inverse.shape
    normals = np.full((height, width, 3), np.nan, np.float32)
    area = np.zeros((height, width), np.float32)
    if height < 3 or width < 3:
        return normals, area
    is_smooth = np.zeros((height, width), np.uint8)
    _mark_smooth(inverse, max_bend, is_smooth)
    to_edge = _distance_to_edge(is_smooth, radius + 1)
    sums = np.empty((height + 1, width + 1, 3))
    _sum_up(inverse, x, y, sums)
    dx, dy = (float(axis[-1] - axis[0]) / (len(axis) - 1) for axis in (x, y))
    _fit_windows(inverse, x, y, to_edge, sums, _scales(radius, dx, dy), normals, area)
    return normals, area


def _scales(radius: int, dx: float, dy: float) -> Array:
    """(radius + 1, 3) what the window's three sums are multiplied with, for each radius up to it.

    dx, dy: between columns and rows.
    """
    n = (2.0 * np.arange(radius + 1) + 1) ** 2
    per_spread = 12 / (n * np.maximum(n - 1, 1))
    return np.stack([1 / n, per_spread / dx**2, per_spread / dy**2], axis=1)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_smooth(inverse: Array, max_bend: float, is_smooth: Array) -> None:
    """Set `is_smooth`, (h, w) uint8, to 0 at edges and holes and else to 1, but at the border.

    An edge is where the second difference of inverse depth is large: it is 0 on a plane, however
    steep.
    """
    height, width = inverse.shape
    least, rounding = np.float32(max_bend), np.float32(0.004)
    for v in range(1, height - 1):
        above, row, below = inverse[v - 1], inverse[v], inverse[v + 1]
        for u in range(1, width - 1):
            here = row[u]
            limit = least + rounding * here * here
            # A hole beside the pixel is NaN and compares false: it is an edge by itself.
            is_bent = abs(row[u - 1] + row[u + 1] - here - here) > limit
            is_bent |= abs(above[u] + below[u] - here - here) > limit
            is_smooth[v, u] = (here > 0) & np.isfinite(here) & (not is_bent)


def _distance_to_edge(is_smooth: Array, cap: int) -> Array:
    """Count the pixels (chessboard steps, at most `cap`) from each pixel to one that is 0."""
    distance = is_smooth.copy()
    for _ in range(cap - 1):
        is_smooth = cv2.erode(is_smooth, np.ones((3, 3), np.uint8), borderValue=0)
        distance += is_smooth
    return distance


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_up(inverse: Array, x: Array, y: Array, sums: Array) -> None:
    """Set `sums` to those of (1, x, y)/z over all pixels above and to the left.

    sums: (h + 1, w + 1, 3) float64.
    """
    height, width = inverse.shape
    sums[0] = 0.0
    for v in range(height):
        s0, s1, s2 = 0.0, 0.0, 0.0
        sums[v + 1, 0] = 0.0
        for u in range(width):
            value = np.float64(inverse[v, u])
            if np.isfinite(value):
                s0 += value
                s1 += value * x[u]
                s2 += value * y[v]
            sums[v + 1, u + 1, 0] = sums[v, u + 1, 0] + s0
            sums[v + 1, u + 1, 1] = sums[v, u + 1, 1] + s1
            sums[v + 1, u + 1, 2] = sums[v, u + 1, 2] + s2


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_windows(
    inverse: Array,
    x: Array,
    y: Array,
    to_edge: Array,
    sums: Array,
    scales: Array,
    normals: Array,
    area: Array,
) -> None:
    """Set normal and area by a fit in the largest square window that `to_edge` allows.

    The window holds no hole, so its sums of x and y are those of the grid, and centred
    coordinates decouple the three unknowns: box sums of products are all it takes.
    """
    height, width = inverse.shape
    one, pixel = np.float32(1), np.float32((x[1] - x[0]) * (y[1] - y[0]))
    for v in range(height):
        for u in range(width):
            r = np.int64(to_edge[v, u]) - 1
            if r < 1:
                continue
            t, b, f, e = v - r, v + r + 1, u - r, u + r + 1
            s0 = sums[b, e, 0] - sums[t, e, 0] - sums[b, f, 0] + sums[t, f, 0]
            s1 = sums[b, e, 1] - sums[t, e, 1] - sums[b, f, 1] + sums[t, f, 1]
            s2 = sums[b, e, 2] - sums[t, e, 2] - sums[b, f, 2] + sums[t, f, 2]
            mean = np.float32(s0 * scales[r, 0])
            slope_x = np.float32((s1 - x[u] * s0) * scales[r, 1])
            slope_y = np.float32((s2 - y[v] * s0) * scales[r, 2])
            level = mean - slope_x * x[u] - slope_y * y[v]
            per_norm = one / np.sqrt(slope_x * slope_x + slope_y * slope_y + level * level)
            normals[v, u, 0] = -slope_x * per_norm
            normals[v, u, 1] = -slope_y * per_norm
            normals[v, u, 2] = -level * per_norm
            cosine = mean * per_norm / np.sqrt(one + x[u] * x[u] + y[v] * y[v])
            here = inverse[v, u]
            area[v, u] = pixel / (here * here * max(cosine, np.float32(MIN_COSINE)))
