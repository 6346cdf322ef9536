"""Depth to points and local planes, on the organised grid.

Everything here works in *inverse depth*. A plane n·p = 1 seen by a pinhole is affine in it:
1/z = n_x x + n_y y + n_z with the normalised pixel (x, y) = ((u - cx)/fx, (v - cy)/fy). So a
local plane is a linear fit, and the noise of a triangulating sensor, which grows with z², is
the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from curiosight.frame import Camera, Depth

Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class Points:
    """The organised cloud of a frame, every `stride`-th pixel of it.

    xyz: (h, w, 3) float32 metres in the colour camera's frame, NaN = no reading.
    normals: (h, w, 3) float32 unit vectors towards the camera, NaN where the surface is
        unknown (an edge, a hole).
    area: (h, w) float32 square metres that a pixel covers on its surface, 0 without a normal.
    """

    xyz: Array
    normals: Array
    area: Array
    stride: int

    @property
    def depth(self) -> Array:
        """(h, w) metres along z."""
        depth: Array = self.xyz[..., 2]
        return depth


def observe_points(
    depth: Depth, camera: Camera, *, stride: int = 2, radius: int = 4, max_bend: float = 0.01
) -> Points:
    """Back-project depth and fit a local plane around every point.

    radius: half the window of the fit, in pixels of the coarse grid; next to an edge the
        window shrinks with the distance to it, and below 1 there is no normal.
    max_bend: a second difference of inverse depth (1/m) that counts as an edge, beside 4 mm of
        depth for rounding; 0.01 is a step of 1 cm at 1 m, 9 cm at 3 m.
    """
    height, width = depth.shape
    x = ((np.arange(0, width, stride) - camera.cx) / camera.fx).astype(np.float32)
    y = ((np.arange(0, height, stride) - camera.cy) / camera.fy).astype(np.float32)
    z = np.ascontiguousarray(depth[::stride, ::stride])
    xyz = np.empty((*z.shape, 3), np.float32)
    xyz[..., 0] = z * x
    xyz[..., 1] = z * y[:, None]
    xyz[..., 2] = z
    inverse = 1.0 / z
    to_edge = _distance_to_edge(inverse, max_bend, radius + 1)
    normals = _fit_normals(inverse, x, y, to_edge)
    range_ = z * np.sqrt(1 + x**2 + (y**2)[:, None])
    cosine = -np.einsum("vuc,vuc->vu", normals, xyz) / range_
    pixel = stride * stride / (camera.fx * camera.fy)
    with np.errstate(invalid="ignore"):
        area = pixel * z**2 / np.maximum(cosine, 0.1)
    area[np.isnan(area)] = 0
    return Points(xyz, normals, area.astype(np.float32), stride)


@njit(cache=True, nogil=True)
def _distance_to_edge(inverse: Array, max_bend: float, cap: int) -> Array:
    """Count the pixels (chessboard steps, at most `cap`) from each pixel to an edge or a hole.

    An edge is where the second difference of inverse depth is large: it is 0 on a plane, however
    steep.
    """
    height, width = inverse.shape
    distance = np.full((height, width), cap, np.int32)
    for v in range(height):
        for u in range(width):
            here = inverse[v, u]
            edge = not np.isfinite(here)
            limit = max_bend + 0.004 * here * here
            if not edge and 0 < u < width - 1:
                bend = inverse[v, u - 1] + inverse[v, u + 1] - 2 * here
                edge = abs(bend) > limit
            if not edge and 0 < v < height - 1:
                bend = inverse[v - 1, u] + inverse[v + 1, u] - 2 * here
                edge = abs(bend) > limit
            border = min(u, v, width - 1 - u, height - 1 - v)
            distance[v, u] = 0 if edge else min(cap, border)
    for v in range(1, height):
        for u in range(1, width - 1):
            near = min(distance[v - 1, u - 1], distance[v - 1, u], distance[v - 1, u + 1])
            distance[v, u] = min(distance[v, u], near + 1, distance[v, u - 1] + 1)
    for v in range(height - 2, -1, -1):
        for u in range(width - 2, 0, -1):
            near = min(distance[v + 1, u - 1], distance[v + 1, u], distance[v + 1, u + 1])
            distance[v, u] = min(distance[v, u], near + 1, distance[v, u + 1] + 1)
    return distance


@njit(cache=True, nogil=True)
def _fit_normals(inverse: Array, x: Array, y: Array, to_edge: Array) -> Array:
    """Fit 1/z = a x + b y + c in a square window per pixel; (a, b, c) is along the normal.

    The window holds no hole, so its sums of x and y are those of the grid, and centred
    coordinates decouple the three unknowns: two box sums of products are all it takes.
    """
    height, width = inverse.shape
    sums = np.zeros((3, height + 1, width + 1))
    for v in range(height):
        row = np.zeros(3)
        for u in range(width):
            value = inverse[v, u] if np.isfinite(inverse[v, u]) else 0.0
            row[0] += value
            row[1] += value * x[u]
            row[2] += value * y[v]
            for k in range(3):
                sums[k, v + 1, u + 1] = sums[k, v, u + 1] + row[k]
    normals = np.full((height, width, 3), np.nan, np.float32)
    dx = x[1] - x[0]
    dy = y[1] - y[0]
    for v in range(height):
        for u in range(width):
            r = to_edge[v, u] - 1
            if r < 1:
                continue
            t, b, f, e = v - r, v + r + 1, u - r, u + r + 1
            s0 = sums[0, b, e] - sums[0, t, e] - sums[0, b, f] + sums[0, t, f]
            s1 = sums[1, b, e] - sums[1, t, e] - sums[1, b, f] + sums[1, t, f]
            s2 = sums[2, b, e] - sums[2, t, e] - sums[2, b, f] + sums[2, t, f]
            side = 2 * r + 1
            spread = side * side * (side * side - 1) / 12.0
            slope_x = (s1 - x[u] * s0) / (spread * dx * dx)
            slope_y = (s2 - y[v] * s0) / (spread * dy * dy)
            level = s0 / (side * side) - slope_x * x[u] - slope_y * y[v]
            norm = np.sqrt(slope_x**2 + slope_y**2 + level**2)
            normals[v, u, 0] = -slope_x / norm
            normals[v, u, 1] = -slope_y / norm
            normals[v, u, 2] = -level / norm
    return normals


@njit(cache=True, nogil=True)
def cell_of_pixel(coarse: Array, depth: Array, stride: int) -> Array:
    """Return for each pixel the grid's cell around it that is closest in depth.

    coarse: (h, w) every `stride`-th pixel of `depth` (H, W). The (H, W) int32 cells are flat
    indices; where nothing tells them apart it is the cell to the upper left.
    """
    height, width = depth.shape
    n_rows, n_columns = coarse.shape
    cells = np.empty((height, width), np.int32)
    for v in range(height):
        top = v // stride
        bottom = min(top + 1, n_rows - 1) if v % stride else top
        for u in range(width):
            left = u // stride
            right = min(left + 1, n_columns - 1) if u % stride else left
            here = depth[v, u]
            best, nearest = top * n_columns + left, abs(coarse[top, left] - here)
            if np.isnan(nearest):
                nearest = np.inf
            for row in range(top, bottom + 1):
                for column in range(left, right + 1):
                    gap = abs(coarse[row, column] - here)
                    if gap < nearest:
                        best, nearest = row * n_columns + column, gap
            cells[v, u] = best
    return cells


@njit(cache=True, nogil=True)
def look_up(cells: Array, xyz: Array, axes: Array, corner: Array, side: float) -> Array:
    """(h, w) float32: what the cell of a map under or over each point holds, -inf beside it.

    cells: (rows, columns) float32. axes: (3, 2) directions of columns and rows in the frame of
    the points. corner: (2,) metres along them of the first cell's corner. side: metres.
    """
    height, width = xyz.shape[:2]
    rows, columns = cells.shape
    per_metre = 1.0 / side
    found = np.full((height, width), -np.inf, np.float32)
    for v in range(height):
        for u in range(width):
            x, y, z = xyz[v, u, 0], xyz[v, u, 1], xyz[v, u, 2]
            column = (x * axes[0, 0] + y * axes[1, 0] + z * axes[2, 0] - corner[0]) * per_metre
            row = (x * axes[0, 1] + y * axes[1, 1] + z * axes[2, 1] - corner[1]) * per_metre
            # A point without a reading is NaN and compares false.
            if 0 <= column < columns and 0 <= row < rows:
                found[v, u] = cells[int(row), int(column)]
    return found


def ends(values: Array, share: float = 0.01) -> tuple[float, float]:
    """Return the two of (n,) values, n > 0, that a share of them lies below and above."""
    n_beyond = int(share * len(values))
    ordered = np.partition(values, (n_beyond, len(values) - 1 - n_beyond))
    return float(ordered[n_beyond]), float(ordered[-1 - n_beyond])
