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
# Of a block's image: red, green, blue, their products in the order of `_sum_image`, and pixels.
N_IMAGE_SUMS, PIXELS = 10, 9
# Of a block's map: itself, and its products with red, green and blue.
N_MAP_SUMS = 4


class EdgeFilter:
    """Smooth (h, w) maps where their (h, w, 3) image is even; keep them sharp at its edges.

    stride: 1 = as OpenCV does it, to the bit; more = as above, several times sooner.

    What depends on the image alone is found once for all its maps.
    """

    def __init__(self, rgb: Rgb, stride: int = 1) -> None:
        self._rgb = rgb
        self._stride = stride
        self._radius = max(1, round(RADIUS / stride))
        if stride == 1:
            self._filter = cv2.ximgproc.createGuidedFilter(rgb, RADIUS, CONTRAST**2)
        else:
            self._around = sum_windows(_sum_image(rgb, stride), self._radius)

    def __call__(self, saliency: Map) -> Map:
        """Return a map in [0, 1]."""
        if self._stride == 1:
            smooth: Map = self._filter.filter(saliency)
            return np.clip(smooth, 0, 1)
        here = sum_windows(_sum_map(self._rgb, saliency, self._stride), self._radius)
        functions = _solve(self._around, here, np.float32(CONTRAST**2))
        around = sum_windows(functions, self._radius)
        applied: Map = _apply(self._rgb, around, self._radius, self._stride)
        return applied


@njit(cache=True, nogil=True)
def _sum_image(rgb: Array, stride: int) -> Array:
    """Return (h / stride, w / stride, 10) float32 sums over the pixels of each block."""
    height, width = rgb.shape[:2]
    n_down, n_across = -(-height // stride), -(-width // stride)
    sums = np.empty((n_down, n_across, N_IMAGE_SUMS), np.float32)
    for down in range(n_down):
        for across in range(n_across):
            r, g, b, n = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            rr, rg, rb = np.float32(0), np.float32(0), np.float32(0)
            gg, gb, bb = np.float32(0), np.float32(0), np.float32(0)
            for v in range(down * stride, min((down + 1) * stride, height)):
                for u in range(across * stride, min((across + 1) * stride, width)):
                    red, green = np.float32(rgb[v, u, 0]), np.float32(rgb[v, u, 1])
                    blue = np.float32(rgb[v, u, 2])
                    r += red
                    g += green
                    b += blue
                    rr += red * red
                    rg += red * green
                    rb += red * blue
                    gg += green * green
                    gb += green * blue
                    bb += blue * blue
                    n += np.float32(1)
            block = sums[down, across]
            block[0], block[1], block[2], block[PIXELS] = r, g, b, n
            block[3], block[4], block[5] = rr, rg, rb
            block[6], block[7], block[8] = gg, gb, bb
    return sums


@njit(cache=True, nogil=True)
def _sum_map(rgb: Array, saliency: Array, stride: int) -> Array:
    """Return (h / stride, w / stride, 4) float32 sums over the pixels of each block."""
    height, width = saliency.shape
    n_down, n_across = -(-height // stride), -(-width // stride)
    sums = np.empty((n_down, n_across, N_MAP_SUMS), np.float32)
    for down in range(n_down):
        for across in range(n_across):
            s, rs, gs, bs = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            for v in range(down * stride, min((down + 1) * stride, height)):
                for u in range(across * stride, min((across + 1) * stride, width)):
                    score = saliency[v, u]
                    s += score
                    rs += np.float32(rgb[v, u, 0]) * score
                    gs += np.float32(rgb[v, u, 1]) * score
                    bs += np.float32(rgb[v, u, 2]) * score
            block = sums[down, across]
            block[0], block[1], block[2], block[3] = s, rs, gs, bs
    return sums


@njit(cache=True, nogil=True)
def sum_windows(values: Array, radius: int) -> Array:
    """Return the (h, w, k) sums over square windows, which the border cuts."""
    height, width, n_values = values.shape
    sums = np.empty_like(values)
    lines = values.reshape(height, width * n_values)
    # Wider than the values, so that what enters and leaves a window is added up exactly enough.
    column = np.zeros(width * n_values, np.float64)
    for v in range(-radius, height):
        if v + radius < height:
            line = lines[v + radius]
            for place in range(column.size):
                column[place] += line[place]
        if v - radius > 0:
            line = lines[v - radius - 1]
            for place in range(column.size):
                column[place] -= line[place]
        if v >= 0:
            _sum_along(column.reshape(width, n_values), radius, sums[v])
    return sums


@njit(cache=True, nogil=True)
def _sum_along(column: Array, radius: int, sums: Array) -> None:
    """Write the sums over `radius` neighbours on each side along a line of (w, k).

    Four of the k at a time, whose additions do not wait for each other; if there are fewer, one
    several times.
    """
    width, n_values = column.shape
    for first in range(0, n_values, 4):
        k, m = first, min(first + 1, n_values - 1)
        n, o = min(first + 2, n_values - 1), min(first + 3, n_values - 1)
        sum_k, sum_m, sum_n, sum_o = 0.0, 0.0, 0.0, 0.0
        for u in range(-radius, width):
            if u + radius < width:
                entering = column[u + radius]
                sum_k += entering[k]
                sum_m += entering[m]
                sum_n += entering[n]
                sum_o += entering[o]
            if u - radius > 0:
                leaving = column[u - radius - 1]
                sum_k -= leaving[k]
                sum_m -= leaving[m]
                sum_n -= leaving[n]
                sum_o -= leaving[o]
            if u >= 0:
                here = sums[u]
                here[k], here[m], here[n], here[o] = sum_k, sum_m, sum_n, sum_o


@njit(cache=True, nogil=True)
def _solve(image_sums: Array, map_sums: Array, tolerance: np.float32) -> Array:
    """Return each window's function: (h, w, 4) factors of red, green, blue, and a constant."""
    height, width, _ = image_sums.shape
    functions = np.empty((height, width, 4), np.float32)
    for v in range(height):
        for u in range(width):
            m, of_map = image_sums[v, u], map_sums[v, u]
            n = np.float32(1) / m[PIXELS]
            r, g, b, s = m[0] * n, m[1] * n, m[2] * n, of_map[0] * n
            rr, rg, rb = m[3] * n - r * r + tolerance, m[4] * n - r * g, m[5] * n - r * b
            gg, gb = m[6] * n - g * g + tolerance, m[7] * n - g * b
            bb = m[8] * n - b * b + tolerance
            rs, gs, bs = of_map[1] * n - r * s, of_map[2] * n - g * s, of_map[3] * n - b * s
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
def _apply(rgb: Array, functions: Array, radius: int, stride: int) -> Array:
    """Interpolate the functions of blocks, and return what they make of the image: (h, w).

    functions: (h / stride, w / stride, 4) their sums over windows of this radius.
    """
    height, width = rgb.shape[:2]
    n_down, n_across, _ = functions.shape
    means = _means(functions, radius)
    first, shares = np.empty(width, np.uint32), np.empty(width, np.float32)
    for u in range(width):
        first[u], _, shares[u] = _between(u, stride, n_across)
    starts, steps = np.empty((4, n_across), np.float32), np.zeros((4, n_across), np.float32)
    applied = np.empty((height, width), np.float32)
    for v in range(height):
        upper, lower, share = _between(v, stride, n_down)
        for k in range(4):
            _interpolate(means[upper, k], means[lower, k], share, starts[k], steps[k])
        _apply_to_line(rgb[v], starts, steps, first, shares, applied[v])
    return applied


@njit(cache=True, nogil=True)
def _means(functions: Array, radius: int) -> Array:
    """Return (n_down, 4, n_across): sums over windows by the number of blocks that these hold."""
    n_down, n_across, _ = functions.shape
    means = np.empty((n_down, 4, n_across), np.float32)
    for down in range(n_down):
        n_lines = min(down + radius, n_down - 1) - max(down - radius, 0) + 1
        for across in range(n_across):
            n_columns = min(across + radius, n_across - 1) - max(across - radius, 0) + 1
            n_blocks = np.float32(n_lines * n_columns)
            for k in range(4):
                means[down, k, across] = functions[down, across, k] / n_blocks
    return means


@njit(cache=True, nogil=True)
def _interpolate(
    upper: Array, lower: Array, share: np.float32, starts: Array, steps: Array
) -> None:
    """Write (n,) what lies so far from the upper to the lower line, and its steps to the next."""
    for place in range(starts.size):
        starts[place] = upper[place] + (lower[place] - upper[place]) * share
    for place in range(starts.size - 1):
        steps[place] = starts[place + 1] - starts[place]


@njit(cache=True, nogil=True)
def _apply_to_line(
    pixels: Array, starts: Array, steps: Array, first: Array, shares: Array, applied: Array
) -> None:
    """Write (w,) what the functions of a line make of its (w, 3) pixels, cut to [0, 1].

    first, shares: (w,) between which blocks each pixel lies, and how far, see `_between`.
    """
    for u in range(applied.size):
        block, share = first[u], shares[u]
        value = starts[3, block] + steps[3, block] * share
        for k in range(3):
            value += (starts[k, block] + steps[k, block] * share) * np.float32(pixels[u, k])
        applied[u] = min(max(value, np.float32(0)), np.float32(1))


@njit(cache=True, nogil=True, inline="always")
def _between(pixel: int, stride: int, n_blocks: int) -> tuple[int, int, np.float32]:
    """Return the blocks whose middles a pixel lies between, and how far from the first: [0, 1).

    Beyond the outermost middles the outermost block counts alone.
    """
    halves = max(2 * pixel + 1 - stride, 0)
    first = min(halves // (2 * stride), n_blocks - 1)
    share = np.float32(halves % (2 * stride)) / np.float32(2 * stride)
    return first, min(first + 1, n_blocks - 1), share
