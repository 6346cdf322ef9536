"""A map of the ground that the points of many frames are collected on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import horizontal_axes

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

# Side of a map's cell, metres.
CELL = 0.04


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """Square cells on the horizontal plane.

    axes: (3, 2) their directions in the world, of columns and of rows, unit vectors.
    low: (2,) metres along them of the first cell's corner. shape: rows, columns.
    """

    axes: Array
    low: Array
    shape: tuple[int, int]

    @classmethod
    def around(cls, xyz: Array, up: Array, *, border: float = 0.6) -> Self:
        """Return the map of (n, 3) points in the world, n > 0, with some metres around them."""
        axes = np.stack(horizontal_axes(up), axis=1)
        places = xyz @ axes
        low = places.min(axis=0) - border
        columns, rows = np.ceil((places.max(axis=0) + border - low) / CELL).astype(int)
        return cls(axes, low, (int(rows), int(columns)))

    def cells(self, xyz: Array) -> Array:
        """Return the flat index of the cell under each of (n, 3) points of the map."""
        column, row = np.floor((xyz @ self.axes - self.low) / CELL).astype(np.int64).T
        index: Array = row * self.shape[1] + column
        return index

    def count(self, cells: Array) -> Array:
        """(rows, columns) how many of some cells are each one."""
        return np.bincount(cells, minlength=self.shape[0] * self.shape[1]).reshape(self.shape)

    def highest(self, cells: Array, heights: Array) -> Array:
        """(rows, columns) largest of the heights at each cell; -inf where there is none."""
        highest = np.full(self.shape, -np.inf)
        np.maximum.at(highest.ravel(), cells, heights)
        return highest


def pieces(mask: Mask) -> list[Mask]:
    """Return the connected parts of a (rows, columns) mask."""
    n_pieces, piece = cv2.connectedComponents(mask.astype(np.uint8))
    return [piece == number for number in range(1, n_pieces)]


def area(mask: Mask) -> float:
    """Return the square metres of a mask."""
    return float(np.count_nonzero(mask)) * CELL**2


def diagonal(mask: Mask) -> float:
    """Return the diagonal in metres of the smallest rectangle around a mask."""
    _, size, _ = cv2.minAreaRect(np.argwhere(mask).astype(np.float32))
    return float(np.hypot(*size)) * CELL


def closed(mask: Mask, radius: float) -> Mask:
    """Return a mask without its gaps of up to twice the radius in metres."""
    return _morph(cv2.MORPH_CLOSE, mask, radius)


def opened(mask: Mask, radius: float) -> Mask:
    """Return a mask without its parts narrower than about twice the radius in metres."""
    return _morph(cv2.MORPH_OPEN, mask, radius)


def grown(mask: Mask, radius: float) -> Mask:
    """Return a mask with what is within a radius in metres of it."""
    return _morph(cv2.MORPH_DILATE, mask, radius)


def _morph(operation: int, mask: Mask, radius: float) -> Mask:
    side = 2 * round(radius / CELL) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return np.asarray(cv2.morphologyEx(mask.astype(np.uint8), operation, disc) > 0)


def inset(mask: Mask) -> npt.NDArray[np.float32]:
    """(rows, columns) metres that cells lie inside the outline of a mask, negative outside."""
    is_in = mask.astype(np.uint8)
    inside = cv2.distanceTransform(is_in, cv2.DIST_L2, cv2.DIST_MASK_5)
    outside = cv2.distanceTransform(1 - is_in, cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray((inside - outside) * CELL, np.float32)
