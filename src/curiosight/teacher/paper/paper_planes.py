"""The planes of the paper's segmentation: the main one, and walls perpendicular to it (RANSAC)."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask, Plane
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.paper.paper_settings import PaperSettings, PaperSupport

Array = npt.NDArray[Any]
# Planes are drawn from, and fitted to, no more points than this, evenly spaced.
MAX_POINTS = 20_000


def find_main_plane(
    points: Points,
    in_range: Mask,
    limits: PaperSupport,
    settings: PaperSettings,
    rng: np.random.Generator,
) -> Plane | None:
    """Return the plane with most points of the image's lower half; None = no floor or table.

    Its normal points upwards. in_range: (h, w) bool, the points that count.
    """
    tilt = np.radians(settings.camera_tilt_deg)
    expected_up = np.array([0.0, -np.cos(tilt), -np.sin(tilt)])
    in_lower_half = in_range.copy()
    in_lower_half[: len(in_range) // 2] = False
    xyz = points.xyz_at(_some(in_lower_half)).astype(np.float64)
    if len(xyz) < 3:
        return None
    first, second, third = xyz[rng.integers(len(xyz), size=(3, settings.n_hypotheses))]
    normals = _unit(np.cross(second - first, third - first))
    normals *= np.where(normals @ expected_up < 0, -1.0, 1.0)[:, None]
    is_upright = normals @ expected_up >= np.cos(np.radians(settings.max_tilt_deg))
    if not is_upright.any():
        return None
    gaps = _gaps(xyz, normals[is_upright], first[is_upright])
    is_inlier = _most(gaps < settings.plane_distance)
    normal, offset = _fit(xyz[is_inlier], expected_up)
    gap = np.abs(points.xyz @ normal + offset)
    plane = Plane(normal, offset, in_range & (gap < settings.plane_distance))
    return plane if _is_support(plane, points, gap, limits, settings) else None


def _is_support(
    plane: Plane, points: Points, gap: Array, limits: PaperSupport, settings: PaperSettings
) -> bool:
    """Tell whether a plane is large, and its nearest points' own surfaces lie in it.

    gap: (h, w) metres from the plane.
    """
    min_share = limits.min_plane_px / (640 * 480)
    if np.count_nonzero(plane.inliers) < min_share * plane.inliers.size:
        return False
    nearest = plane.inliers & (gap < limits.min_height)
    is_level = points.normals[nearest] @ plane.normal > settings.min_normal_cosine
    return bool(np.count_nonzero(is_level) >= limits.min_level_share * len(is_level))


def find_walls(
    points: Points, up: Array, free: Mask, settings: PaperSettings, rng: np.random.Generator
) -> list[Plane]:
    """Return the large planes perpendicular to the main one, each with all that is on it.

    up: (3,) normal of the main plane. free: (h, w) bool, the points that may be on a wall.
    """
    walls: list[Plane] = []
    rest = free & (points.area > 0)
    for _ in range(settings.n_walls):
        drawn = _draw_wall(points, up, _some(rest), settings, rng)
        if drawn is None:
            break
        normal, offset = drawn
        is_near = np.abs(points.xyz @ normal + offset) < settings.wall_distance
        wall = Plane(normal, offset, free & is_near)
        is_large = _diagonal(points.xyz[_largest_piece(wall.inliers)]) > settings.min_wall_diagonal
        if is_large and abs(normal @ up) < settings.max_wall_cosine:
            walls.append(wall)
        rest &= ~is_near
    return walls


def _draw_wall(
    points: Points, up: Array, where: Array, settings: PaperSettings, rng: np.random.Generator
) -> tuple[Array, float] | None:
    """Return normal and offset of the upright plane with most of some points; None = no plane.

    Two points and `up` span such a plane. A point counts where its own surface lies in it too.
    where: (n,) flat indices on the grid.
    """
    if len(where) < 3:
        return None
    xyz = points.xyz_at(where).astype(np.float64)
    first, second = xyz[rng.integers(len(xyz), size=(2, settings.n_hypotheses))]
    normals = _unit(np.cross(up, second - first))
    is_on = _gaps(xyz, normals, first) < settings.wall_distance
    is_on &= np.abs(points.normals_at(where) @ normals.T) > settings.min_normal_cosine
    most = _most(is_on)
    return _fit(xyz[most], up) if np.count_nonzero(most) >= 3 else None


def _some(mask: Mask) -> Array:
    """(n,) flat indices of some points of a (h, w) mask, evenly spaced where there are many."""
    where = np.flatnonzero(mask)
    return where[:: 1 + len(where) // MAX_POINTS]


def _unit(vectors: Array) -> Array:
    """Return (n, 3) vectors as unit vectors; one without length stays as it is."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: Array = vectors / np.where(lengths > 0, lengths, 1.0)
    return unit


def _gaps(xyz: Array, normals: Array, through: Array) -> Array:
    """(n, k) metres from (n, 3) points to k planes, each with a normal through a point."""
    offsets = np.einsum("ij,ij->i", normals, through)
    gaps: Array = np.abs(xyz @ normals.T - offsets)
    return gaps


def _most(is_inlier: Array) -> Array:
    """(n,) bool: the inliers of that of k planes which has most of the (n, k)."""
    most: Array = is_inlier[:, is_inlier.sum(axis=0).argmax()]
    return most


def _fit(xyz: Array, side: Array) -> tuple[Array, float]:
    """Fit a plane by least squares; its normal is on the side that a (3,) vector points to."""
    centre = xyz.mean(axis=0)
    normal = np.linalg.eigh(np.cov(xyz.T))[1][:, 0]
    normal = normal if normal @ side >= 0 else -normal
    return normal, -float(normal @ centre)


def _largest_piece(is_inlier: Mask) -> Mask:
    """(h, w) bool: the largest piece of a mask that is connected in the image."""
    # Numbered in the order of their first pixels: of equal ones the first is taken.
    _, piece = cv2.connectedComponentsWithAlgorithm(
        is_inlier.astype(np.uint8), 8, cv2.CV_32S, cv2.CCL_WU
    )
    n_points = np.bincount(piece.ravel())
    n_points[0] = 0
    largest: Mask = is_inlier & (piece == n_points.argmax())
    return largest


def _diagonal(xyz: Array) -> float:
    """Return the diagonal of the box, along the camera's axes, around (n, 3) points; 0 if n = 0."""
    return float(np.linalg.norm(np.ptp(xyz, axis=0))) if len(xyz) else 0.0
