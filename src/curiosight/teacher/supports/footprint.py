"""How far a table that a frame shows reaches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask, Plane, horizontal_axes
from curiosight.teacher.cloud.points import Points, look_up

Array = npt.NDArray[Any]
# A plane's piece goes on over gaps of less than twice this, in pixels of a 640x480 image.
REACH_PX = 7


def above_footprint(
    points: Points, plane: Plane, margins: Sequence[float], *, cell: float = 0.02
) -> list[Mask]:
    """(h, w) bool: points straight above or below the convex hull of the plane's largest piece.

    margins: metres around the hull, of each mask that is returned.
    """
    largest = largest_piece(plane.inliers, points.steps(REACH_PX))
    if not largest.any():
        return [largest] * len(margins)
    inner = cv2.erode(largest.view(np.uint8), np.ones((3, 3), np.uint8)).view(np.bool_)
    axes = np.stack(horizontal_axes(plane.normal), axis=1)
    outline = points.xyz_at(np.flatnonzero(largest & ~inner))
    places = np.ascontiguousarray(outline @ axes.astype(np.float32))
    hull = cv2.convexHull(places).reshape(-1, 2)
    n_margins = _margins_around(points, hull, axes, sorted(margins), cell)
    return [n_margins > sum(wider > margin for wider in margins) for margin in margins]


def _margins_around(
    points: Points, hull: Array, axes: Array, margins: Sequence[float], cell: float
) -> Array:
    """(h, w): how many of the margins around a (n, 2) convex hull along the axes points are in."""
    low = hull.min(axis=0) - 2 * margins[-1]
    width, height = np.ceil((hull.max(axis=0) + 2 * margins[-1] - low) / cell).astype(int) + 1
    drawn = np.zeros((height, width), np.uint8)
    cv2.fillConvexPoly(drawn, np.round((hull - low) / cell).astype(np.int32), 1.0)
    n_margins = np.zeros((height, width), np.float32)
    for margin in margins:
        reach = 2 * round(margin / cell) + 1
        n_margins += cv2.dilate(drawn, np.ones((reach, reach), np.uint8))
    # The hull was drawn at the nearest corners of cells, so a cell is around its corner.
    corner = (low - cell / 2).astype(np.float64)
    return look_up(n_margins, points, axes, corner, cell)


def largest_piece(inliers: Mask, reach: int = 2) -> Mask:
    """(h, w) bool: the largest part of a plane's inliers that has no gap of 1 + 2 reach points."""
    left, top, width, height = cv2.boundingRect(inliers.view(np.uint8))
    inside = inliers[top : top + height, left : left + width]
    grown = np.pad(inside.view(np.uint8), reach)
    grown = cv2.dilate(grown, np.ones((1 + 2 * reach, 1 + 2 * reach), np.uint8))
    n_pieces, piece = cv2.connectedComponents(grown)
    if n_pieces <= 2:  # the background counts too
        return inliers
    is_largest = piece[reach:-reach, reach:-reach] == 1 + np.argmax(np.bincount(piece.ravel())[1:])
    largest = np.zeros(inliers.shape, np.bool_)
    largest[top : top + height, left : left + width] = inside & is_largest
    return largest
