"""Support planes and walls, found as peaks of histograms along the vertical and around it.

With the up direction known (`up.py`), a support has one unknown, its height, and a wall two,
its heading and distance. Both are then peaks of a small histogram of surface area: exact,
deterministic, and faster than random hypotheses. Every peak is refined by least squares in
inverse depth, where the sensor's noise is the same everywhere.
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


def refine_plane(
    points: Points, normal: Array, offset: float, near: Mask, *, band: Array
) -> Plane | None:
    """Fit a plane to the `near` points, thrice, within 3, 1.5 and 1 times `band` of the last fit.

    None when fewer than 50 points remain.
    """
    plane = Plane(normal, offset, near)
    for slack in (3.0, 1.5, 1.0):
        inliers = near & (np.abs(plane.distance(points.xyz)) < slack * band)
        if np.count_nonzero(inliers) < 50:
            return None
        xyz = points.xyz[inliers].astype(np.float64)
        rays = xyz / xyz[:, 2:]
        # n·p = 1 divided by z: rays·n = 1/z, whose noise does not depend on the distance.
        solution = np.linalg.solve(rays.T @ rays + 1e-9 * np.eye(3), rays.T @ (1 / xyz[:, 2]))
        length = float(np.linalg.norm(solution))
        sign = 1.0 if solution @ plane.normal > 0 else -1.0
        plane = Plane(sign * solution / length, -sign / length, inliers)
    return plane


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
    supports: list[Plane] = []
    for _ in range(2 * max_supports):
        height, area = _peak_height(points, up, level)
        if area < min_area or len(supports) == max_supports:
            break
        near = level & (np.abs(points.xyz @ up.astype(np.float32) - height) < 0.04 + band)
        plane = refine_plane(points, up, -height, near, band=band)
        level &= ~near
        if plane is None or plane.normal @ up < np.cos(max_tilt):
            continue
        if points.area[plane.inliers].sum() >= min_area:
            supports.append(plane)
            level &= np.abs(plane.distance(points.xyz)) > 1.5 * band
    supports.sort(key=lambda plane: -float(points.area[plane.inliers].sum()))
    return supports


def _peak_height(points: Points, up: Array, level: Mask, *, step: float = 0.02) -> tuple[float, float]:
    """Return the height (metres along `up` from the camera) with the most area, and that area."""
    heights = points.xyz[level] @ up.astype(np.float32)
    if heights.size == 0:
        return 0.0, 0.0
    low = float(heights.min())
    index = ((heights - low) / step).astype(np.int64)
    histogram = np.convolve(np.bincount(index, points.area[level]), np.ones(3), "same")
    peak = int(np.argmax(histogram))
    return low + (peak + 0.5) * step, float(histogram[peak])


def find_walls(
    points: Points,
    up: Array,
    *,
    free: Mask,
    band: Array,
    max_cosine: float = 0.3,
    border: Mask,
    min_diagonal: float = 1.5,
    min_cut_diagonal: float = 1.0,
    min_area: float = 0.3,
    max_walls: int = 6,
) -> list[Plane]:
    """Find the vertical planes whose visible part has a diagonal of at least `min_diagonal`.

    free: (h, w) bool, the points that may belong to a wall.
    max_cosine: |normal·up| of a point below which it votes for a wall.
    """
    up32 = up.astype(np.float32)
    vertical = free & (np.abs(points.normals @ up32) < max_cosine)
    right, forward = horizontal_axes(up)
    walls: list[Plane] = []
    for _ in range(2 * max_walls):
        normal, distance, area = _peak_heading(points, right, forward, vertical)
        if area < 0.3 * min_area or len(walls) == max_walls:
            break
        agree = vertical & (points.normals @ normal.astype(np.float32) > 0.85)
        near = agree & (np.abs(points.xyz @ normal.astype(np.float32) + distance) < 0.08 + band)
        plane = refine_plane(points, normal, distance, near, band=band + 0.02)
        vertical &= ~near
        if plane is None or abs(plane.normal @ up) > 0.15:
            continue
        diagonal = visible_diagonal(points.xyz[plane.inliers], up, plane.normal)
        is_cut = (plane.inliers & border).any()
        if points.area[plane.inliers].sum() < min_area:
            continue
        if diagonal >= (min_cut_diagonal if is_cut else min_diagonal):
            walls.append(plane)
            vertical &= np.abs(plane.distance(points.xyz)) > band + 0.03
    return walls


def _peak_heading(
    points: Points, right: Array, forward: Array, vertical: Mask
) -> tuple[Array, float, float]:
    """Return the wall with the most area in a histogram of 3° by 5 cm: normal, offset, area."""
    normals = points.normals[vertical]
    if len(normals) == 0:
        return right, 0.0, 0.0
    heading = np.arctan2(normals @ right.astype(np.float32), normals @ forward.astype(np.float32))
    sector = np.radians(3.0)
    column = ((heading + np.pi) / sector).astype(np.int64)
    centre = (column + 0.5) * sector - np.pi
    xyz = points.xyz[vertical]
    along = np.sin(centre) * (xyz @ right.astype(np.float32))
    along += np.cos(centre) * (xyz @ forward.astype(np.float32))
    low = float(along.min())
    row = ((along - low) / 0.05).astype(np.int64)
    n_rows = int(row.max()) + 1
    votes = np.bincount(column * n_rows + row, points.area[vertical], minlength=121 * n_rows)
    votes = votes.reshape(-1, n_rows)
    votes[:, 1:] += votes[:, :-1]
    votes = votes + np.roll(votes, 1, axis=0) + np.roll(votes, -1, axis=0)
    best_column, best_row = np.unravel_index(int(np.argmax(votes)), votes.shape)
    angle = (best_column + 0.5) * sector - np.pi
    normal = np.sin(angle) * right + np.cos(angle) * forward
    return normal, -(low + best_row * 0.05), float(votes[best_column, best_row])


def horizontal_axes(up: Array) -> tuple[Array, Array]:
    """Return two unit vectors that span the horizontal plane: the camera's right and forward."""
    right = np.array([1.0, 0.0, 0.0]) - up[0] * up
    if np.linalg.norm(right) < 0.1:
        right = np.array([0.0, 0.0, 1.0]) - up[2] * up
    right /= np.linalg.norm(right)
    return right, np.cross(right, up)


def visible_diagonal(xyz: Array, up: Array, normal: Array) -> float:
    """Return the diagonal in metres of (n, 3) wall points, without the outermost 1 %."""
    if len(xyz) == 0:
        return 0.0
    along = np.cross(up, normal)
    extent = [np.ptp(np.percentile(xyz @ axis, (1, 99))) for axis in (up, along)]
    return float(np.hypot(*extent))
