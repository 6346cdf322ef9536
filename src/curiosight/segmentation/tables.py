"""Tables as the frames of a recording show them together, on a map of their tops.

One frame sees a table's top from the edge, in pieces between the things on it, or not at all.
Then its legs look like things on the floor, and what stands on it like parts of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

# Side of a map's cell, metres.
CELL = 0.04
# A level surface is a table, not a box's lid or a chair's seat, from this size on.
MIN_TABLE_AREA = 0.25
MIN_TABLE_DIAGONAL = 0.7
# What is as low and as wide as this is a seat or a bed.
MAX_SEAT_HEIGHT = 0.62
MIN_SEAT_AREA = 0.7
# Supports within this height (metres) are one; pose drift and tilt stay below it.
SAME_HEIGHT = 0.10


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table, a counter, a seat or a bed.

    height: metres over the floor. area: square metres of its top that were seen.
    axes: (3, 2) the map's two directions in the world, horizontal unit vectors.
    low: (2,) metres along `axes` of the first cell's corner.
    extent: (rows, columns) uint8, 1 where the top reaches; rows along the second axis.
    """

    height: float
    area: float
    axes: Array
    low: Array
    extent: npt.NDArray[np.uint8]

    @property
    def is_seat(self) -> bool:
        """Whether one sits or lies on it: what is on it is cushion as often as object."""
        return self.height < MAX_SEAT_HEIGHT and self.area > MIN_SEAT_AREA

    def covers(self, xyz: Array, T_world_camera: Pose) -> Mask:
        """(...) bool: which (..., 3) points of the camera are straight above or below it."""
        axes = T_world_camera[:3, :3].T @ self.axes
        corner = self.low - T_world_camera[:3, 3] @ self.axes
        return look_up(self.extent, (xyz @ axes.astype(xyz.dtype) - corner) / CELL)


def look_up(cells: Array, place: Array) -> Mask:
    """(...) bool: whether the cell around each (..., 2) place (column, row) is set.

    Places outside, and those that are NaN, are not.
    """
    rows, columns = cells.shape
    column, row = place[..., 0], place[..., 1]
    is_inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    found = np.zeros(is_inside.shape, np.bool_)
    found[is_inside] = cells[row[is_inside].astype(np.int64), column[is_inside].astype(np.int64)]
    return found


def map_tables(
    heights: Sequence[float], tops: Sequence[Array], axes: Array, *, margin: float = 0.05
) -> tuple[Table, ...]:
    """Return the tables that level surfaces of several frames make up, the lowest first.

    heights: of each surface, metres over the floor. tops: (n, 2) its points along `axes`.
    margin: metres around what was seen that still belong to a table.
    """
    tables: list[Table] = []
    remaining = [int(i) for i in np.argsort(heights) if heights[i] > 2 * SAME_HEIGHT]
    while remaining:
        level = [i for i in remaining if heights[i] < heights[remaining[0]] + SAME_HEIGHT]
        remaining = remaining[len(level) :]
        tables += _tables_at([heights[i] for i in level], [tops[i] for i in level], axes, margin)
    return tuple(sorted(tables, key=lambda table: table.height))


def _tables_at(
    heights: Sequence[float], tops: Sequence[Array], axes: Array, margin: float
) -> list[Table]:
    """Return the tables of about one height: connected pieces of the map that are large."""
    places = np.concatenate(tops)
    height_of_place = np.repeat(heights, [len(top) for top in tops])
    border = 0.5
    low = places.min(axis=0) - border
    columns, rows = (np.ptp(places, axis=0) + 2 * border) // CELL + 1
    column, row = ((places - low) / CELL).astype(np.int64).T
    seen = np.zeros((int(rows), int(columns)), np.uint8)
    seen[row, column] = 1
    # A top seen at a grazing angle has gaps between the image's rows.
    seen = cv2.morphologyEx(seen, cv2.MORPH_CLOSE, _disc(0.12)).astype(np.uint8)
    n_pieces, piece, statistics, _ = cv2.connectedComponentsWithStats(seen)
    found = []
    for number in range(1, n_pieces):
        area = float(statistics[number, cv2.CC_STAT_AREA]) * CELL**2
        is_piece = (piece == number).astype(np.uint8)
        if area < MIN_TABLE_AREA or _diagonal(is_piece) < MIN_TABLE_DIAGONAL:
            continue
        height = float(np.median(height_of_place[piece[row, column] == number]))
        # What stands on a table hides some of it, and casts a shadow without readings.
        extent = cv2.morphologyEx(is_piece, cv2.MORPH_CLOSE, _disc(0.25))
        extent = cv2.dilate(extent, _disc(margin))
        found.append(Table(height, area, axes, low, extent.astype(np.uint8)))
    return found


def _diagonal(piece: npt.NDArray[np.uint8]) -> float:
    _, size, _ = cv2.minAreaRect(np.argwhere(piece).astype(np.float32))
    return float(np.hypot(*size)) * CELL


def _disc(radius: float) -> npt.NDArray[np.uint8]:
    side = 2 * round(radius / CELL) + 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)).astype(np.uint8)
