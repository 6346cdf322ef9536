"""What of a frame is support or wall, and what its border leaves out."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Camera
from curiosight.teacher.cloud.planes import Mask, noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.supports.tops import Kind

Array = npt.NDArray[Any]
# A surface turned farther away from a plane than this cosine tells is no part of it.
MIN_FACING = 0.7
# A wall goes on for so many metres beyond what was seen of it.
WALL_MARGIN = 0.05


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


def on_walls(points: Points, walls: Iterable[Wall], free: Mask, noise: float) -> Mask:
    """(h, w) bool: free, within the band of a wall that this frame shows, and not facing away."""
    found = np.zeros(points.depth.shape, np.bool_)
    in_view = [wall for wall in walls if wall.inliers.any()]
    if in_view:
        band = noise_band(points.depth, 0.04, 2 * noise)
        for wall in in_view:
            found |= wall.near(points, free, band, min_facing=MIN_FACING, margin=WALL_MARGIN)
    return found


@lru_cache(maxsize=8)
def border_mask(camera: Camera, stride: int, border_px: int, outline_px: int = 4) -> Mask:
    """(h, w) bool on the grid: the image's frame, and what the depth sensor's view leaves out.

    The view is the sensor's whole rectangle (`Camera.depth_window`), less `outline_px`, within
    which registration can shift it: holes and shadows inside it are no border. Read-only: the
    frames of a camera share it.
    """
    rows, columns = np.arange(0, camera.height, stride), np.arange(0, camera.width, stride)
    window = camera.depth_window or (0, 0, camera.width, camera.height)
    u_min, v_min = (max(border_px, low + outline_px) for low in window[:2])
    u_max = min(camera.width - border_px, window[2] - outline_px)
    v_max = min(camera.height - border_px, window[3] - outline_px)
    is_inside = ((rows >= v_min) & (rows < v_max))[:, None]
    border: Mask = ~(is_inside & (columns >= u_min) & (columns < u_max))
    border.flags.writeable = False
    return border
