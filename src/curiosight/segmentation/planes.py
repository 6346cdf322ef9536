"""Support planes, found as peaks of the histogram of surface along the vertical.

With the up direction known (`up.py`), a support has one unknown, its height: a peak of a small
histogram of surface area is exact, deterministic, and faster than random hypotheses. Every peak
is refined by least squares in inverse depth, where the sensor's noise is the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.points import Points

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """The plane normal·p + offset = 0 in the camera's frame, and where it was seen.

    normal: (3,) unit vector, up for a support, towards the camera for a wall.
    inliers: (h, w) bool on the grid of the points.
    """

    normal: Array
    offset: float
    inliers: Mask

    def distance(self, xyz: Array) -> Array:
        """Signed distance in metres of (..., 3) points, positive on the side of the normal."""
        signed: Array = xyz @ self.normal.astype(xyz.dtype) + np.float32(self.offset)
        return signed


def noise_band(points: Points, base: float, noise: float) -> Array:
    """(h, w) half-thickness in metres of a plane seen at each point: base + noise z².

    noise: inverse-depth noise of the sensor, 1/m; 0.0028 is one step of a Kinect's disparity.
    """
    band: Array = base + noise * points.depth**2
    return band


def fit_plane(
    xyz: Array, band: Array, normal: Array, offset: float, *, max_points: int = 8000
) -> tuple[Array, float, Array] | None:
    """Fit a plane to points, thrice, within 3, 1.5 and 1 times `band` of the last fit.

    xyz: (n, 3) and band: (n,) metres. normal, offset: where to begin; the side is kept.
    max_points: of more, evenly spaced ones are fitted.
    Return normal, offset and the (n,) bool inliers; None when fewer than 50 points remain.
    """
    stride = 1 + len(xyz) // max_points
    fitted, thickness = xyz[::stride], band[::stride]
    for slack in (3.0, 1.5, 1.0):
        signed = fitted @ normal.astype(np.float32) + np.float32(offset)
        inside = fitted[np.abs(signed) < slack * thickness].astype(np.float64)
        if len(inside) * stride < 50:
            return None
        inverse = 1 / inside[:, 2]
        rays = inside * inverse[:, None]
        # n·p = 1 divided by z: rays·n = 1/z, whose noise does not depend on the distance.
        solution = np.linalg.solve(rays.T @ rays + 1e-9 * np.eye(3), rays.T @ inverse)
        length = float(np.linalg.norm(solution))
        sign = 1.0 if solution @ normal > 0 else -1.0
        normal, offset = sign * solution / length, -sign / length
    signed = xyz @ normal.astype(np.float32) + np.float32(offset)
    return normal, offset, np.abs(signed) < band


def find_supports(
    points: Points,
    up: Array,
    *,
    max_tilt: float = np.radians(6),
    max_normal_angle: float = np.radians(20),
    band: Array,
    min_area: float = 0.06,
    max_supports: int = 6,
    max_range: float = np.inf,
) -> list[Plane]:
    """Find the horizontal planes, largest first.

    up: (3,) unit vector in the camera's frame.
    max_tilt: how far a support's refined normal may lean from `up`, radians.
    max_normal_angle: how far a point's own normal may, for the point to vote.
    min_area: visible square metres.
    """
    level = points.normals @ up.astype(np.float32) > np.cos(max_normal_angle)
    level &= points.depth < max_range
    xyz, area, thickness = points.xyz[level], points.area[level], band[level]
    heights = xyz @ up.astype(np.float32)
    is_free = np.ones(len(xyz), np.bool_)
    found: list[tuple[float, Plane]] = []
    for _ in range(2 * max_supports):
        height, peak_area = _peak_height(heights[is_free], area[is_free])
        if peak_area < min_area or len(found) == max_supports:
            break
        near = np.flatnonzero(is_free & (np.abs(heights - height) < 0.04 + thickness))
        fit = fit_plane(xyz[near], thickness[near], up, -height)
        is_free[near] = False
        if fit is None or fit[0] @ up < np.cos(max_tilt):
            continue
        normal, offset, inliers = fit
        visible_area = float(area[near[inliers]].sum())
        if visible_area >= min_area:
            mask = scatter(near[inliers], level)
            found.append((visible_area, Plane(normal, offset, mask)))
            is_free &= np.abs(xyz @ normal.astype(np.float32) + offset) > 1.5 * thickness
    found.sort(key=lambda pair: -pair[0])
    return [plane for _, plane in found]


def scatter(chosen: Array, mask: Mask) -> Mask:
    """Return the part of a mask that remains when only some of its True cells are `chosen`."""
    part = np.zeros(mask.shape, np.bool_)
    part.ravel()[np.flatnonzero(mask)[chosen]] = True
    return part


def _peak_height(heights: Array, area: Array, *, step: float = 0.02) -> tuple[float, float]:
    """Return the height (metres along `up` from the camera) with the most area, and that area."""
    if heights.size == 0:
        return 0.0, 0.0
    low = float(heights.min())
    index = ((heights - low) / step).astype(np.int64)
    histogram = np.convolve(np.bincount(index, area), np.ones(3), "same")
    peak = int(np.argmax(histogram))
    return low + (peak + 0.5) * step, float(histogram[peak])


def horizontal_axes(up: Array) -> tuple[Array, Array]:
    """Return two unit vectors that span the horizontal plane: the camera's right and forward."""
    right = np.array([1.0, 0.0, 0.0]) - up[0] * up
    if np.linalg.norm(right) < 0.1:
        right = np.array([0.0, 0.0, 1.0]) - up[2] * up
    right /= np.linalg.norm(right)
    return right, np.cross(right, up)
