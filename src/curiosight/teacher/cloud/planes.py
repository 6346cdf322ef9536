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
# Height of a layer of the histogram, and what is near its peak beside the band, metres.
STEP, NEAR_HEIGHT = 0.02, 0.04


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
    for axis in range(3):
        to_plane[axis, 0], to_plane[axis, 1] = axes[axis, 0], axes[axis, 1]
        to_plane[axis, 2] = normal[axis]
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

    where: (n,) flat indices on the grid. xyz, normals: (n, 3), area: (n,), see `Points`.
    band: (n,) metres, see `noise_band`.
    """

    where: Array
    xyz: Array
    normals: Array
    area: Array
    band: Array

    @classmethod
    def facing(
        cls, points: Points, band: Array, free: Mask, direction: Array, low: float, high: float
    ) -> Self:
        """Return the free points with a cosine between two from normal to (3,) direction.

        band: (h, w) metres, see `noise_band`. free: (h, w) bool. No normal, no.
        """
        grids = points.xyz, points.normals, points.area, band, free
        return cls(*_take_facing(*grids, direction.astype(np.float32), low, high))

    def at(self, places: Array) -> Self:
        """Return the points at the (n,) places."""
        xyz, normals = rows_at(self.xyz, places), rows_at(self.normals, places)
        area, band = self.area.take(places), self.band.take(places)
        return type(self)(self.where.take(places), xyz, normals, area, band)

    def gap(self, normal: Array, offset: float) -> Array:
        """(n,) metres between the points and the plane normal·p + offset = 0."""
        gap: Array = np.abs(self.xyz @ normal.astype(np.float32) + np.float32(offset))
        return gap


@njit(cache=True, nogil=True, error_model="numpy")
def _take_facing(
    xyz: Array,
    normals: Array,
    area: Array,
    band: Array,
    free: Array,
    direction: Array,
    low: float,
    high: float,
) -> tuple[Array, Array, Array, Array, Array]:
    """Return what `Surface.facing` is made of; all are (h, w) or (h, w, 3)."""
    height, width = free.shape
    where, n = np.empty(free.size, np.int64), 0
    least, most = np.float32(low), np.float32(high)
    a, b, c = direction
    for v in range(height):
        for u in range(width):
            if free[v, u]:
                cosine = normals[v, u, 0] * a + normals[v, u, 1] * b + normals[v, u, 2] * c
                if cosine > least and cosine < most:
                    where[n] = v * width + u
                    n += 1
    vectors, of_vectors = xyz.reshape(-1, 3), normals.reshape(-1, 3)
    places, facing = np.empty((n, 3), np.float32), np.empty((n, 3), np.float32)
    areas, bands, of_area, of_band = (
        np.empty(n, np.float32),
        np.empty(n, np.float32),
        area.ravel(),
        band.ravel(),
    )
    for place in range(n):
        here = where[place]
        for axis in range(3):
            places[place, axis], facing[place, axis] = vectors[here, axis], of_vectors[here, axis]
        areas[place], bands[place] = of_area[here], of_band[here]
    return where[:n], places, facing, areas, bands


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
    max_points: int = 8000,
) -> list[Plane]:
    """Find the horizontal planes, largest first.

    up: (3,) unit vector in the camera's frame.
    max_tilt: how far a support's refined normal may lean from `up`, radians.
    max_normal_angle: how far a point's own normal may, for the point to vote.
    min_area: visible square metres. max_points: that a fit looks at.
    """
    heights = np.empty_like(points.depth)
    rays, vertical = (points.depth, points.x, points.y), up.astype(np.float32)
    _find_level(*rays, points.normals, vertical, np.cos(max_normal_angle), max_range, heights)
    found: list[tuple[float, Plane]] = []
    for _ in range(2 * max_supports):
        height, peak_area = _find_peak(heights, points.area, STEP)
        if peak_area < min_area or len(found) == max_supports:
            break
        near = _some_near(heights, band, height, max_points)
        fit = fit_plane(points.xyz.reshape(-1, 3), band.ravel(), near, up, -height)
        gap, slack = band, -1.0
        if fit is not None and fit[0] @ up >= np.cos(max_tilt):
            plane = Plane(*fit, np.empty(heights.shape, np.bool_))
            gap = np.abs(plane.distances(points))
            visible_area = _mark_inliers(heights, band, height, gap, points.area, plane.inliers)
            if visible_area >= min_area:
                found.append((visible_area, plane))
                slack = 1.5
        _leave_out(heights, band, height, gap, slack)
    found.sort(key=lambda pair: -pair[0])
    return [plane for _, plane in found]


@njit(cache=True, nogil=True, error_model="numpy")
def _find_level(
    depth: Array,
    x: Array,
    y: Array,
    normals: Array,
    up: Array,
    min_cosine: float,
    max_range: float,
    heights: Array,
) -> None:
    """Set (h, w) `heights`, metres along `up`, of what is level and within a range; NaN elsewhere.

    depth, x, y, normals: see `Points`.
    """
    least, farthest, nothing = np.float32(min_cosine), np.float32(max_range), np.float32(np.nan)
    a, b, c = up
    for v in range(len(y)):
        in_row = y[v] * b + c
        for u in range(len(x)):
            z = depth[v, u]
            cosine = normals[v, u, 0] * a + normals[v, u, 1] * b + normals[v, u, 2] * c
            is_level = (cosine > least) & (z < farthest)
            heights[v, u] = z * (x[u] * a + in_row) if is_level else nothing


@njit(cache=True, nogil=True, error_model="numpy")
def _find_peak(heights: Array, area: Array, step: float) -> tuple[float, float]:
    """Return the height with the most area, and that area; heights, area: (h, w), NaN = none.

    step: metres of height; three are added up.
    """
    flat, areas = heights.ravel(), area.ravel()
    low, high = np.float32(np.inf), np.float32(-np.inf)
    for height in flat:
        low, high = height if height < low else low, height if height > high else high
    if high < low:
        return 0.0, 0.0
    base = np.float64(low)
    # In turn into two rows: most points are as high as the one before, and would wait for it.
    rows = np.zeros((2, 4 + int((np.float64(high) - base) / step)))
    for point in range(len(flat)):
        if flat[point] >= low:
            rows[point & 1, 1 + int((flat[point] - base) / step)] += areas[point]
    most, peak = -1.0, 0
    for index in range(1, rows.shape[1] - 1):
        total = 0.0
        for step_of_three in range(index - 1, index + 2):
            total += rows[0, step_of_three] + rows[1, step_of_three]
        if total > most:
            most, peak = total, index - 1
    return base + (peak + 0.5) * step, most


@njit(cache=True, nogil=True, error_model="numpy")
def _some_near(heights: Array, band: Array, height: float, max_points: int) -> Array:
    """Return the flat indices of what is near a height, of more than so many evenly spaced ones.

    heights, band: (h, w) metres.
    """
    flat, bands = heights.ravel(), band.ravel()
    middle, wider = np.float32(height), np.float32(NEAR_HEIGHT)
    n_near = 0
    for point in range(len(flat)):
        n_near += abs(flat[point] - middle) < wider + bands[point]
    stride = 1 + n_near // max_points
    some, n_some, n_skipped = np.empty(n_near, np.int64), 0, stride - 1
    for point in range(len(flat)):
        if abs(flat[point] - middle) < wider + bands[point]:
            n_skipped += 1
            if n_skipped == stride:
                some[n_some], n_skipped = point, 0
                n_some += 1
    return some[:n_some]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_inliers(
    heights: Array, band: Array, height: float, gap: Array, area: Array, inliers: Array
) -> float:
    """Set (h, w) `inliers`: near a height and in a plane's band; return their area.

    heights, band: (h, w) metres. gap: (h, w) metres from the plane.
    """
    middle, wider, nothing = np.float32(height), np.float32(NEAR_HEIGHT), np.float32(0)
    total = 0.0
    for v in range(heights.shape[0]):
        for u in range(heights.shape[1]):
            is_near = abs(heights[v, u] - middle) < wider + band[v, u]
            inliers[v, u] = is_near & (gap[v, u] < band[v, u])
        for u in range(heights.shape[1]):
            total += np.float64(area[v, u] if inliers[v, u] else nothing)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _leave_out(heights: Array, band: Array, height: float, gap: Array, slack: float) -> None:
    """Set `heights` to NaN near a height, and within so many bands of a plane.

    All are (h, w), see `_mark_inliers`.
    """
    middle, wider = np.float32(height), np.float32(NEAR_HEIGHT)
    factor, nothing = np.float32(slack), np.float32(np.nan)
    for v in range(heights.shape[0]):
        for u in range(heights.shape[1]):
            is_out = abs(heights[v, u] - middle) < wider + band[v, u]
            is_out |= gap[v, u] <= factor * band[v, u]
            heights[v, u] = nothing if is_out else heights[v, u]


def mask_of(where: Array, shape: tuple[int, ...]) -> Mask:
    """(h, w) bool: True at the given flat indices."""
    mask = np.zeros(shape, np.bool_)
    mask.ravel()[where] = True
    return mask


@njit(cache=True, nogil=True, error_model="numpy")
def horizontal_axes(up: Array) -> tuple[Array, Array]:
    """Return two unit vectors that span the horizontal plane: the camera's right and forward."""
    x, y, z = up
    # Of the camera's x axis what is level, or of its z axis where that is upright.
    i, j, k = (1 - x * x, -x * y, -x * z) if x * x < 0.99 else (-z * x, -z * y, 1 - z * z)
    length = np.sqrt(i * i + j * j + k * k)
    i, j, k = i / length, j / length, k / length
    return np.array([i, j, k]), np.array([j * z - k * y, k * x - i * z, i * y - j * x])
