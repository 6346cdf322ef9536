"""Support planes, found as peaks of the histogram of surface along the vertical.

With the up direction known (`up.py`), a support has one unknown, its height: a peak of a small
histogram of surface area is exact, deterministic, and faster than random hypotheses. Every peak
is refined by least squares in inverse depth, where the sensor's noise is the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.plane_fit import fit_plane
from curiosight.teacher.cloud.points import Points, rows_at

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]
# A surface turned farther away from a plane than this cosine tells is no part of it.
MIN_FACING = 0.7


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

    def distances(self, points: Points) -> Array:
        """(h, w) float32 signed distance in metres of all points of a frame."""
        distances = np.empty_like(points.depth)
        plane = np.array([*self.normal, self.offset], np.float32)
        _measure_distances(points.depth, points.x, points.y, plane, distances)
        return distances


@njit(cache=True, nogil=True, error_model="numpy")
def _measure_distances(depth: Array, x: Array, y: Array, plane: Array, distances: Array) -> None:
    """Set the (h, w) distances from a plane, (4,) its normal and offset; depth, x, y: `Points`."""
    a, b, c, offset = plane
    for v in range(len(y)):
        in_row = y[v] * b + c
        for u in range(len(x)):
            distances[v, u] = depth[v, u] * (x[u] * a + in_row) + offset


@njit(cache=True, nogil=True, error_model="numpy")
def coordinates_on(axes: Array, normal: Array, offset: float) -> Array:
    """Return (4, 3) float32 from (x, y, z, 1) to metres along two axes and over a plane.

    axes: (3, 2) directions on the plane normal·p + offset = 0.
    """
    to_plane = np.zeros((4, 3), np.float32)
    to_plane[:3, :2], to_plane[:3, 2] = axes, normal
    to_plane[3, 2] = offset
    return to_plane


def noise_band(depth: Array, base: float, noise: float) -> Array:
    """Return the half-thickness in metres of a plane seen at some depths z: base + noise z².

    noise: inverse-depth noise of the sensor, 1/m; 0.0028 is one step of a Kinect's disparity.
    """
    band: Array = depth * depth
    band *= noise
    band += base
    return band


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Some points of a frame.

    where: (n,) flat indices on the grid. xyz: (n, 3), area: (n,), see `Points`.
    band: (n,) metres, see `noise_band`.
    """

    where: Array
    xyz: Array
    area: Array
    band: Array

    @classmethod
    def gather(cls, points: Points, band: Array, where: Array) -> Self:
        """Return the points at (n,) flat indices; band: (h, w)."""
        return cls(where, points.xyz_at(where), points.area.take(where), band.take(where))

    def at(self, places: Array) -> Self:
        """Return the points at the (n,) places."""
        area, band = self.area.take(places), self.band.take(places)
        return type(self)(self.where.take(places), rows_at(self.xyz, places), area, band)

    def gap(self, normal: Array, offset: float) -> Array:
        """(n,) metres between the points and the plane normal·p + offset = 0."""
        gap: Array = np.abs(self.xyz @ normal.astype(np.float32) + np.float32(offset))
        return gap


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
    vertical = up.astype(np.float32)
    is_level = facing(points, up, np.cos(max_normal_angle), np.inf, points.depth < max_range)
    rest = Surface.gather(points, band, np.flatnonzero(is_level))
    found: list[tuple[float, Plane]] = []
    for _ in range(2 * max_supports):
        heights = rest.xyz @ vertical
        height, peak_area = _peak_height(heights, rest.area)
        if peak_area < min_area or len(found) == max_supports:
            break
        is_near = np.abs(heights - height) < 0.04 + rest.band
        fit = fit_plane(rest.xyz, rest.band, np.flatnonzero(is_near), up, -height)
        is_rest = ~is_near
        if fit is not None and fit[0] @ up >= np.cos(max_tilt):
            gap = rest.gap(*fit)
            inliers = np.flatnonzero(is_near & (gap < rest.band))
            visible_area = float(rest.area.take(inliers).sum())
            if visible_area >= min_area:
                mask = mask_of(rest.where.take(inliers), points.depth.shape)
                found.append((visible_area, Plane(*fit, mask)))
                is_rest &= gap > 1.5 * rest.band
        rest = rest.at(np.flatnonzero(is_rest))
    found.sort(key=lambda pair: -pair[0])
    return [plane for _, plane in found]


def facing(points: Points, direction: Array, low: float, high: float, free: Mask) -> Mask:
    """(h, w) bool: free, and with a cosine between `low` and `high` from normal to direction.

    direction: (3,) unit vector. free: (h, w) bool. No normal, no.
    """
    is_facing = np.empty(free.shape, np.bool_)
    _mark_facing(points.normals, direction.astype(np.float32), low, high, free, is_facing)
    return is_facing


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_facing(
    normals: Array, direction: Array, low: float, high: float, free: Array, is_facing: Array
) -> None:
    """Set (h, w) `is_facing` as `facing` says."""
    least, most = np.float32(low), np.float32(high)
    a, b, c = direction
    for v in range(free.shape[0]):
        for u in range(free.shape[1]):
            is_facing[v, u] = False
            if free[v, u]:
                cosine = normals[v, u, 0] * a + normals[v, u, 1] * b + normals[v, u, 2] * c
                is_facing[v, u] = (cosine > least) & (cosine < most)


def mask_of(where: Array, shape: tuple[int, ...]) -> Mask:
    """(h, w) bool: True at the given flat indices."""
    mask = np.zeros(shape, np.bool_)
    mask.ravel()[where] = True
    return mask


def _peak_height(heights: Array, area: Array, *, step: float = 0.02) -> tuple[float, float]:
    """Return the height (metres along `up` from the camera) with the most area, and that area."""
    if heights.size == 0:
        return 0.0, 0.0
    low = float(heights.min())
    n_steps = 2 + int((float(heights.max()) - low) / step)
    sums = np.zeros(n_steps)
    _sum_area(heights, area, low, step, sums)
    histogram = np.convolve(sums, np.ones(3), "same")
    peak = int(np.argmax(histogram))
    return low + (peak + 0.5) * step, float(histogram[peak])


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_area(heights: Array, area: Array, low: float, step: float, sums: Array) -> None:
    """Add the area to the (n_steps,) sums per step of height upwards from `low`."""
    for point in range(len(heights)):
        sums[int((heights[point] - low) / step)] += area[point]


@njit(cache=True, nogil=True, error_model="numpy")
def horizontal_axes(up: Array) -> tuple[Array, Array]:
    """Return two unit vectors that span the horizontal plane: the camera's right and forward."""
    x, y, z = up
    # Of the camera's x axis what is level, or of its z axis where that is upright.
    i, j, k = (1 - x * x, -x * y, -x * z) if x * x < 0.99 else (-z * x, -z * y, 1 - z * z)
    length = np.sqrt(i * i + j * j + k * k)
    i, j, k = i / length, j / length, k / length
    return np.array([i, j, k]), np.array([j * z - k * y, k * x - i * z, i * y - j * x])
