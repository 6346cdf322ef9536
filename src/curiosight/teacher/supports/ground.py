"""A map of the ground that the points of many frames are collected on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
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
    def around(cls, seen: Iterable[Array], up: Array, *, border: float = 0.6) -> Self:
        """Return the map of (n, 3) points in the world, with some metres around them.

        seen: in parts, one of them with a point at least.
        """
        axes = np.stack(horizontal_axes(up), axis=1)
        # NumPy finds the least of a row much faster than that of a column.
        places = (axes.T @ xyz.T for xyz in seen if len(xyz))
        ends = np.array([(part.min(axis=1), part.max(axis=1)) for part in places])
        low = ends[:, 0].min(axis=0) - border
        columns, rows = np.ceil((ends[:, 1].max(axis=0) + border - low) / CELL).astype(int)
        return cls(axes, low, (int(rows), int(columns)))

    def cells(self, xyz: Array) -> Array:
        """Return the flat index of the cell under each of (n, 3) points of the map."""
        index = np.empty(len(xyz), np.int64)
        _find_cells(xyz, self.axes, self.low, self.shape[1], index)
        return index

    def count(self, cells: Array) -> Array:
        """(rows, columns) how many of some cells are each one."""
        return np.bincount(cells, minlength=self.shape[0] * self.shape[1]).reshape(self.shape)

    def highest(self, cells: Array, heights: Array) -> Array:
        """(rows, columns) largest of the heights at each cell; -inf where there is none."""
        highest = np.full(self.shape, -np.inf)
        _raise(cells, heights, highest.ravel())
        return highest


@njit(cache=True, nogil=True, error_model="numpy")
def _find_cells(xyz: Array, axes: Array, low: Array, n_columns: int, index: Array) -> None:
    """Set the (n,) index of the cell under each of (n, 3) points; the rest as in `Ground`."""
    for point in range(len(xyz)):
        x, y, z = xyz[point, 0], xyz[point, 1], xyz[point, 2]
        column = (x * axes[0, 0] + y * axes[1, 0] + z * axes[2, 0] - low[0]) / CELL
        row = (x * axes[0, 1] + y * axes[1, 1] + z * axes[2, 1] - low[1]) / CELL
        index[point] = np.int64(np.floor(row)) * n_columns + np.int64(np.floor(column))


@njit(cache=True, nogil=True, error_model="numpy")
def _raise(cells: Array, heights: Array, highest: Array) -> None:
    """Raise the (n_cells,) highest to the (n,) heights of the points at their cells."""
    for point in range(len(cells)):
        if heights[point] > highest[cells[point]]:
            highest[cells[point]] = heights[point]


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
