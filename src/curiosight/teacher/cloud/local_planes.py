"""Local planes: the normal of the surface at each pixel, from a fit in inverse depth.

1/z = a x + b y + c on a plane (`points.py`), so the fit is linear and (a, b, c) is along the
normal.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

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
    normals, area = np.empty((height, width, 3), np.float32), np.empty(inverse.shape, np.float32)
    if height < 3 or width < 3:
        normals[:], area[:] = np.nan, 0
        return normals, area
    is_smooth = np.zeros((height, width), np.uint8)
    _mark_smooth(inverse, max_bend, is_smooth)
    to_edge = _distance_to_edge(is_smooth, radius + 1)
    n_kept = 1 << (2 * radius + 1).bit_length()
    sums, fits = np.zeros((n_kept, width + 1, 3)), np.zeros((3, width), np.float32)
    dx, dy = (float(axis[-1] - axis[0]) / (len(axis) - 1) for axis in (x, y))
    _fit_rows(inverse, x, y, to_edge, _scales(radius, dx, dy), sums, fits, normals, area)
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
def _fit_rows(
    inverse: Array,
    x: Array,
    y: Array,
    to_edge: Array,
    scales: Array,
    sums: Array,
    fits: Array,
    normals: Array,
    area: Array,
) -> None:
    """Set normal and area by a fit in the largest square window that `to_edge` allows.

    sums: (2^k, w + 1, 3) zeros, more rows than any window, and fits: (3, w), to work with. Rows
    that no window needs any more are overwritten: all of them would not stay in the cache.
    """
    radius, kept = len(scales) - 1, len(sums) - 1
    pixel = np.float32((x[1] - x[0]) * (y[1] - y[0]))
    for last in range(len(y) + radius):
        if last < len(y):
            _sum_up(inverse[last], x, y[last], sums[last & kept], sums[(last + 1) & kept])
        v = last - radius
        if v >= 0:
            _fit_windows(v, x, y[v], to_edge[v], scales, sums, fits)
            _turn_to_camera(inverse[v], x, y[v], pixel, fits, normals[v], area[v])


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_up(inverse: Array, x: Array, y: float, above: Array, here: Array) -> None:
    """Set `here` to the sums of (1, x, y)/z over all pixels above and to the left.

    inverse: (w,) of one row, y of the same. above, here: (w + 1, 3) of the row before and this.
    """
    s0, s1, s2 = 0.0, 0.0, 0.0
    for u in range(len(x)):
        value = np.float64(inverse[u])
        if np.isfinite(value):
            s0 += value
            s1 += value * x[u]
            s2 += value * y
        here[u + 1, 0] = above[u + 1, 0] + s0
        here[u + 1, 1] = above[u + 1, 1] + s1
        here[u + 1, 2] = above[u + 1, 2] + s2


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_windows(
    v: int, x: Array, y: float, to_edge: Array, scales: Array, sums: Array, fits: Array
) -> None:
    """Set (3, w) `fits` of row v to the mean of 1/z and its slopes along x and y; NaN = none.

    The window holds no hole, so its sums of x and y are those of the grid, and centred
    coordinates decouple the three unknowns: box sums of products are all it takes.
    """
    kept = len(sums) - 1
    for u in range(len(x)):
        r = np.int64(to_edge[u]) - 1
        if r < 1:
            fits[0, u] = np.nan
            continue
        top, bottom = sums[(v - r) & kept], sums[(v + r + 1) & kept]
        f, e = u - r, u + r + 1
        s0 = bottom[e, 0] - top[e, 0] - bottom[f, 0] + top[f, 0]
        s1 = bottom[e, 1] - top[e, 1] - bottom[f, 1] + top[f, 1]
        s2 = bottom[e, 2] - top[e, 2] - bottom[f, 2] + top[f, 2]
        fits[0, u] = s0 * scales[r, 0]
        fits[1, u] = (s1 - x[u] * s0) * scales[r, 1]
        fits[2, u] = (s2 - y * s0) * scales[r, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_to_camera(
    inverse: Array, x: Array, y: float, pixel: float, fits: Array, normals: Array, area: Array
) -> None:
    """Set the (w, 3) normals and the (w,) areas of a row.

    inverse: (w,) its 1/z. pixel: area of a pixel at z = 1, seen straight on.
    fits: see `_fit_windows`; changed.
    """
    one, least = np.float32(1), np.float32(MIN_COSINE)
    a, b, c = fits[0], fits[1], fits[2]
    # In place, since a loop over more arrays does not vectorise.
    for u in range(len(x)):
        mean, slope_x, slope_y = a[u], b[u], c[u]
        level = mean - slope_x * x[u] - slope_y * y
        per_norm = one / np.sqrt(slope_x * slope_x + slope_y * slope_y + level * level)
        a[u], b[u], c[u] = -slope_x * per_norm, -slope_y * per_norm, -level * per_norm
        cosine = mean * per_norm / np.sqrt(one + x[u] * x[u] + y * y)
        cosine = cosine if cosine > least else least
        covered = pixel / (inverse[u] * inverse[u] * cosine)
        area[u] = covered if mean == mean else np.float32(0)
    for axis in range(3):
        for u in range(len(x)):
            normals[u, axis] = fits[axis, u]
