"""Patches: pieces of smooth surface, without a concave crease or a step in depth.

The paper's clusters hold all that stands together (sec. II-A.2). What belongs together in them
is told by convexity, after Stein et al., "Object Partitioning using Local Convexity", CVPR 2014:
objects are mostly convex, so a surface ends where one of two places lies before the other's
tangent plane.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.things.union import join_nodes, number_sets

Array = npt.NDArray[Any]
# What is before a tangent plane by less, metres, is so by noise, or by a curve of the surface.
TOLERANCE = 0.006
# From a crease, half of the window that a normal comes from and a little more, in pixels of a
# 640x480 image.
REACH_PX = 14
# A patch that holds no square as large as this on each side of a point is a crease itself, and so
# is one of fewer pixels; of a 640x480 image, too.
CORE_PX, MIN_PATCH_PX = 6, 270


def find_patches(thing: Array, points: Points, noise: float, *, max_bend_deg: float = 7) -> Array:
    """(h, w) int32 number of each point's patch, from 1; 0 = none.

    Edges of a patch, where no normal is known, belong to the patch that they follow without a
    step in depth, or else to the nearest. A thing without any patch of its own has none.

    thing: (h, w) int32, patches end where the number changes; 0 = none.
    noise: of inverse depth, 1/m.
    max_bend_deg: between the normals of two neighbours; more is a crease.
    """
    tolerance = noise_band(points.depth, TOLERANCE, noise)
    parent, patch = np.arange(thing.size), np.zeros(thing.shape, np.int32)
    normals = points.normals.reshape(-1, 3)
    surface = points.xyz.reshape(-1, 3), normals, tolerance
    reach = points.steps(REACH_PX)
    _link(thing, *surface, np.cos(np.radians(max_bend_deg)), reach, parent)
    smooth = _number_known(thing, normals, parent)
    min_points = max(1, int(points.count(MIN_PATCH_PX)))
    core = _core(smooth, points.steps(CORE_PX))
    _number_whole(smooth, core, 1 + int(smooth.max()), min_points, patch)
    # One step of depth is bridged only where nothing else is left.
    queue = np.empty((thing.size, 2), np.int32)
    for slack in (2.0, np.inf):
        _grow(thing, points.depth, tolerance, slack, queue, patch)
    return patch


@njit(cache=True, nogil=True, error_model="numpy")
def _number_known(thing: Array, normals: Array, parent: Array) -> Array:
    """(h, w) int32 number, from 0, of the set of a thing's points with a normal; -1 elsewhere.

    normals: (h * w, 3). parent: see `_link`.
    """
    number = number_sets(parent)
    smooth = np.full(thing.shape, -1, np.int32)
    for v in range(thing.shape[0]):
        for u in range(thing.shape[1]):
            here = v * thing.shape[1] + u
            if thing[v, u] > 0 and normals[here, 0] == normals[here, 0]:
                smooth[v, u] = number[here]
    return smooth


@njit(cache=True, nogil=True, error_model="numpy")
def _number_whole(smooth: Array, core: Array, n_sets: int, min_points: int, patch: Array) -> None:
    """Number the sets that have enough points and a core, from 1 and in their order, in `patch`.

    All are (h, w); smooth: see `_number_known`.
    """
    sizes, number = np.zeros(n_sets, np.int64), np.zeros(n_sets, np.int32)
    for v in range(smooth.shape[0]):
        for u in range(smooth.shape[1]):
            if smooth[v, u] >= 0:
                sizes[smooth[v, u]] += 1
                number[smooth[v, u]] |= core[v, u]
    n_whole = 0
    for one in range(len(sizes)):
        is_whole = number[one] > 0 and sizes[one] >= min_points
        n_whole += is_whole
        number[one] = n_whole if is_whole else 0
    for v in range(smooth.shape[0]):
        for u in range(smooth.shape[1]):
            if smooth[v, u] >= 0:
                patch[v, u] = number[smooth[v, u]]


def _core(smooth: Array, reach: int) -> Array:
    """(h, w) bool: in the middle of a square of one number, `reach` points to each side."""
    square = np.ones((1 + 2 * reach, 1 + 2 * reach), np.uint8)
    numbers = smooth.astype(np.float32)
    # No square reaches beyond the grid: how much of the image is looked at must not matter.
    least = cv2.erode(numbers, square, borderType=cv2.BORDER_CONSTANT, borderValue=-1)
    core: Array = least == cv2.dilate(numbers, square)
    return core & (smooth >= 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _link(
    thing: Array,
    xyz: Array,
    normals: Array,
    tolerance: Array,
    min_cosine: float,
    reach: int,
    parent: Array,
) -> None:
    """Join the points of a thing with those to their right and below, where the surface goes on.

    xyz, normals: (h * w, 3). tolerance: (h, w) metres.
    """
    height, width = thing.shape
    flat = thing.ravel()
    for v in range(height):
        for u in range(width):
            here, limit = v * width + u, tolerance[v, u]
            for shift, before, beyond in ((1, u, width - u), (width, v, height - v)):
                there = here + shift
                if flat[here] == 0 or beyond < 2 or flat[there] != flat[here]:
                    continue
                cosine = 0.0
                for axis in range(3):
                    cosine += normals[here, axis] * normals[there, axis]
                # Without a normal both are NaN, and compare false.
                if not (cosine > min_cosine and in_front(xyz, normals, here, there) < limit):
                    continue
                if before >= reach and beyond > reach + 1:
                    one, other = here - reach * shift, there + reach * shift
                    is_inside = flat[one] == flat[here] and flat[other] == flat[here]
                    if is_inside and in_front(xyz, normals, one, other) > limit:
                        continue
                join_nodes(parent, here, there)


@njit(cache=True, nogil=True, error_model="numpy")
def in_front(xyz: Array, normals: Array, one: int, other: int) -> float:
    """Return by how many metres one of two points lies before the other's tangent plane.

    Positive for a concave surface and for a step, negative for a convex one. Where one of the
    two normals is not known the other tells it; NaN where neither is. xyz, normals: (n, 3).
    """
    at_one, at_other = 0.0, 0.0
    for axis in range(3):
        way = xyz[other, axis] - xyz[one, axis]
        at_one += way * normals[one, axis]
        at_other -= way * normals[other, axis]
    return float(np.fmax(at_one, at_other))


@njit(cache=True, nogil=True, error_model="numpy")
def _grow(
    thing: Array, depth: Array, tolerance: Array, slack: float, queue: Array, patch: Array
) -> None:
    """Give points of a thing without a patch that of the nearest point with one.

    The way there goes through the thing and has no step in depth over `slack` tolerances.
    queue: (h * w, 2), to work with.
    """
    height, width = thing.shape
    n_waiting = 0
    for v in range(height):
        for u in range(width):
            if patch[v, u] > 0:
                queue[n_waiting, 0], queue[n_waiting, 1] = v, u
                n_waiting += 1
    n_done = 0
    while n_done < n_waiting:
        v, u = queue[n_done, 0], queue[n_done, 1]
        n_done += 1
        for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            row, column = v + dv, u + du
            if row < 0 or column < 0 or row >= height or column >= width:
                continue
            if patch[row, column] != 0 or thing[row, column] != thing[v, u]:
                continue
            if abs(depth[row, column] - depth[v, u]) <= slack * tolerance[v, u]:
                patch[row, column] = patch[v, u]
                queue[n_waiting, 0], queue[n_waiting, 1] = row, column
                n_waiting += 1
