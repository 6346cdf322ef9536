"""Maps that follow the image's edges: the guided filter (He, Sun and Tang, ECCV 2010).

In windows of the image, the map is told as a linear function of the colour; the functions of all
windows that hold a pixel are averaged. Both the paper and OpenCV find one function a pixel. They
change slowly, so here they are found for blocks of `stride` pixels, from the sums over all
pixels of the blocks around, and are interpolated between the middles of blocks.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb

Array = npt.NDArray[Any]
Map = npt.NDArray[np.float32]

# Pixels of the shrunken image, and grey levels that count as an edge.
RADIUS, CONTRAST = 8, 8.0
# Of a block: red, green, blue, map, their products in the order of `_sum_blocks`, and pixels.
N_SUMS = 14
PIXELS = 13


def follow_edges(saliency: Map, rgb: Rgb, stride: int = 1) -> Map:
    """Smooth an (h, w) map where its (h, w, 3) image is even; keep it sharp at edges: [0, 1].

    stride: 1 = as OpenCV does it, to the bit; more = as above, several times sooner.
    """
    if stride == 1:
        smooth = cv2.ximgproc.guidedFilter(rgb, saliency, RADIUS, CONTRAST**2)
        clipped: Map = np.clip(smooth, 0, 1)
        return clipped
    radius = max(1, round(RADIUS / stride))
    around = sum_windows(_sum_blocks(rgb, saliency, stride), radius)
    functions = sum_windows(_solve(around, np.float32(CONTRAST**2)), radius)
    applied: Map = _apply(rgb, functions, stride)
    return applied


@njit(cache=True, nogil=True)
def _sum_blocks(rgb: Array, saliency: Array, stride: int) -> Array:
    """Return (h / stride, w / stride, 14) float32 sums over the pixels of each block."""
    height, width = saliency.shape
    n_down, n_across = -(-height // stride), -(-width // stride)
    sums = np.zeros((n_down, n_across, N_SUMS), np.float32)
    for v in range(height):
        for u in range(width):
            block = sums[v // stride, u // stride]
            red, green = np.float32(rgb[v, u, 0]), np.float32(rgb[v, u, 1])
            blue, score = np.float32(rgb[v, u, 2]), saliency[v, u]
            block[0] += red
            block[1] += green
            block[2] += blue
            block[3] += score
            block[4] += red * red
            block[5] += red * green
            block[6] += red * blue
            block[7] += green * green
            block[8] += green * blue
            block[9] += blue * blue
            block[10] += red * score
            block[11] += green * score
            block[12] += blue * score
            block[PIXELS] += np.float32(1)
    return sums


@njit(cache=True, nogil=True)
def sum_windows(values: Array, radius: int) -> Array:
    """Return the (h, w, k) sums over square windows, which the border cuts."""
    height, width, n_values = values.shape
    sums = np.empty_like(values)
    # Wider than the values, so that what enters and leaves a window is added up exactly enough.
    column = np.zeros((width, n_values), np.float64)
    for v in range(-radius, height):
        if v + radius < height:
            for u in range(width):
                for k in range(n_values):
                    column[u, k] += values[v + radius, u, k]
        if v - radius > 0:
            for u in range(width):
                for k in range(n_values):
                    column[u, k] -= values[v - radius - 1, u, k]
        if v >= 0:
            _sum_along(column, radius, sums[v])
    return sums


@njit(cache=True, nogil=True)
def _sum_along(column: Array, radius: int, sums: Array) -> None:
    """Write the sums over `radius` neighbours on each side along a line of (w, k)."""
    width, n_values = column.shape
    total = np.zeros(n_values, np.float64)
    for u in range(-radius, width):
        if u + radius < width:
            for k in range(n_values):
                total[k] += column[u + radius, k]
        if u - radius > 0:
            for k in range(n_values):
                total[k] -= column[u - radius - 1, k]
        if u >= 0:
            for k in range(n_values):
                sums[u, k] = total[k]


@njit(cache=True, nogil=True)
def _solve(sums: Array, tolerance: np.float32) -> Array:
    """Return each window's function: (h, w, 5) factors of red, green, blue, a constant, and 1.

    The 1 becomes the number of windows where functions are summed.
    """
    height, width, _ = sums.shape
    functions = np.ones((height, width, 5), np.float32)
    for v in range(height):
        for u in range(width):
            m, n = sums[v, u], np.float32(1) / sums[v, u, PIXELS]
            r, g, b, s = m[0] * n, m[1] * n, m[2] * n, m[3] * n
            rr, rg, rb = m[4] * n - r * r + tolerance, m[5] * n - r * g, m[6] * n - r * b
            gg, gb = m[7] * n - g * g + tolerance, m[8] * n - g * b
            bb = m[9] * n - b * b + tolerance
            rs, gs, bs = m[10] * n - r * s, m[11] * n - g * s, m[12] * n - b * s
            # Cramer's rule for the symmetric matrix of covariances.
            rr_, rg_, rb_ = gg * bb - gb * gb, gb * rb - rg * bb, rg * gb - gg * rb
            gg_, gb_, bb_ = rr * bb - rb * rb, rb * rg - rr * gb, rr * gg - rg * rg
            scale = np.float32(1) / (rr * rr_ + rg * rg_ + rb * rb_)
            red = (rr_ * rs + rg_ * gs + rb_ * bs) * scale
            green = (rg_ * rs + gg_ * gs + gb_ * bs) * scale
            blue = (rb_ * rs + gb_ * gs + bb_ * bs) * scale
            functions[v, u, 0] = red
            functions[v, u, 1] = green
            functions[v, u, 2] = blue
            functions[v, u, 3] = s - red * r - green * g - blue * b
    return functions


@njit(cache=True, nogil=True)
def _apply(rgb: Array, functions: Array, stride: int) -> Array:
    """Interpolate the functions of blocks, and return what they make of the image: (h, w)."""
    height, width = rgb.shape[:2]
    n_down, n_across, _ = functions.shape
    lines = np.empty((n_across, 4), np.float32)
    applied = np.empty((height, width), np.float32)
    for v in range(height):
        upper, lower, share = _between(v, stride, n_down)
        for u in range(n_across):
            above, below = functions[upper, u], functions[lower, u]
            for k in range(4):
                start = above[k] / above[4]
                lines[u, k] = start + (below[k] / below[4] - start) * share
        for u in range(width):
            left, right, share = _between(u, stride, n_across)
            value = lines[left, 3] + (lines[right, 3] - lines[left, 3]) * share
            for k in range(3):
                factor = lines[left, k] + (lines[right, k] - lines[left, k]) * share
                value += factor * np.float32(rgb[v, u, k])
            applied[v, u] = min(max(value, np.float32(0)), np.float32(1))
    return applied


@njit(cache=True, nogil=True, inline="always")
def _between(pixel: int, stride: int, n_blocks: int) -> tuple[int, int, np.float32]:
    """Return the blocks whose middles a pixel lies between, and how far from the first: [0, 1).

    Beyond the outermost middles the outermost block counts alone.
    """
    halves = max(2 * pixel + 1 - stride, 0)
    first = min(halves // (2 * stride), n_blocks - 1)
    share = np.float32(halves % (2 * stride)) / np.float32(2 * stride)
    return first, min(first + 1, n_blocks - 1), share
