"""Tables as the frames of a recording show them together, on a map of their tops.

One frame sees a table's top from the edge, in pieces between the things on it, or not at all.
Then its legs look like things on the floor, and what stands on it like parts of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.segmentation.points import Points

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

# Side of a map's cell, metres.
CELL = 0.04
# A level surface is a table, not a box's lid or a chair's seat, from this size on.
MIN_TABLE_AREA = 0.25
MIN_TABLE_DIAGONAL = 0.7
MAX_TABLE_HEIGHT = 1.3
# What is as low as this, and wide or with a back and arms, is a seat or a bed.
MAX_SEAT_HEIGHT = 0.62
MIN_BED_AREA = 1.5
MIN_ENCLOSED_SHARE = 0.35
# What is this close to a table's outline (metres) belongs to it.
MARGIN = 0.05
# Layers of the map: metres of height.
LAYER = 0.02
MAX_LEVEL_ANGLE = np.radians(20)
# Supports within this height (metres) are one; pose drift and tilt stay below it.
SAME_HEIGHT = 0.10


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table, a counter, a seat or a bed.

    height: metres over the floor. area: square metres of its top that were seen.
    axes: (3, 2) the map's two directions in the world, horizontal unit vectors.
    low: (2,) metres along `axes` of the first cell's corner.
    extent: (rows, columns) uint8, 1 where the top reaches; rows along the second axis.
    is_seat: a sofa or a bed: what is on it is cushion as often as object.
    """

    height: float
    area: float
    axes: Array
    low: Array
    extent: npt.NDArray[np.uint8]
    is_seat: bool = False

    def inset(self, xyz: Array, T_world_camera: Pose) -> Array:
        """(...) metres that (..., 3) points of the camera lie inside the outline, from above.

        Negative outside; -inf far from the table and where a point has no reading.
        """
        axes = T_world_camera[:3, :3].T @ self.axes
        corner = self.low - T_world_camera[:3, 3] @ self.axes
        place = (xyz @ axes.astype(xyz.dtype) - corner.astype(xyz.dtype)) / xyz.dtype.type(CELL)
        return self._inset_of(place)

    def _inset_of(self, place: Array) -> Array:
        """(...) as `inset`, of (..., 2) places: column, row."""
        inner = cv2.distanceTransform(self.extent, cv2.DIST_L2, cv2.DIST_MASK_5)
        outer = cv2.distanceTransform(1 - self.extent, cv2.DIST_L2, cv2.DIST_MASK_5)
        rows, columns = self.extent.shape
        column, row = place[..., 0], place[..., 1]
        is_on_map = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        found = np.full(is_on_map.shape, -np.inf, np.float32)
        column, row = column[is_on_map].astype(np.int64), row[is_on_map].astype(np.int64)
        found[is_on_map] = (inner - outer)[row, column] * CELL
        return found


def level_surface(points: Points, up: Array, noise: float) -> Array:
    """Return (n, 3) points of the camera's that cover the level surfaces in view, about evenly.

    Level is what the normals tell so. At grazing angles, where few rows show a top and give no
    normals, two rows are so far apart that their heights tell. Between rows points are added.
    """
    up = up.astype(np.float32)
    # A low camera sees tables from below.
    is_level = np.abs(points.normals @ up) > np.cos(MAX_LEVEL_ANGLE)
    is_unknown = np.isnan(points.normals[..., 0])
    near, far = points.xyz[1:], points.xyz[:-1]
    rise = (far - near) @ up
    run = np.linalg.norm(far - near - rise[..., None] * up, axis=-1)
    is_grazing = (run > 0.03 + 4 * noise * near[..., 2] ** 2) & is_unknown[1:] & is_unknown[:-1]
    is_between = (is_level[1:] & is_level[:-1]) | is_grazing
    is_between &= (np.abs(rise) < np.tan(MAX_LEVEL_ANGLE) * run) & (run < 0.3)
    start, way = near[is_between], (far - near)[is_between]
    between = [start + share * way for share in np.arange(0, 1, CELL / 0.3).astype(np.float32)]
    return np.concatenate([points.xyz[is_level], *between])


def map_tables(places: Array, heights: Array, axes: Array) -> list[Table]:
    """Return the tables that the level surfaces of several frames make up, the lowest first.

    places: (n, 2) points of level surfaces along `axes`. heights: (n,) metres over the floor.
    """
    is_elevated = (heights > 2 * SAME_HEIGHT) & (heights < MAX_TABLE_HEIGHT)
    places, heights = places[is_elevated], heights[is_elevated]
    tables: list[Table] = []
    while len(places):
        layer = (heights / LAYER).astype(np.int64)
        cell = np.floor(places / CELL).astype(np.int64)
        first = np.unique(np.column_stack([layer, cell]), axis=0)[:, 0]
        n_cells = np.convolve(np.bincount(first), np.ones(3), "same")
        peak = (int(np.argmax(n_cells)) + 0.5) * LAYER
        if n_cells.max() * CELL**2 < 0.5 * MIN_TABLE_AREA:
            break
        near = np.abs(heights - peak) < 2.5 * LAYER
        tables += _tables_at(places[near], heights[near], axes)
        places, heights = places[~near], heights[~near]
    tables.sort(key=lambda table: table.height)
    return [t for i, t in enumerate(tables) if not any(_carries(low, t) for low in tables[:i])]


def _carries(lower: Table, upper: Table, *, min_share: float = 0.5) -> bool:
    """Tell whether one table is on the other: then it is the tops of what stands there."""
    cells = np.argwhere(upper.extent)[:, ::-1] + 0.5 + (upper.low - lower.low) / CELL
    return float(np.mean(lower._inset_of(cells) > 0)) > min_share


def _tables_at(places: Array, heights: Array, axes: Array, *, border: float = 0.5) -> list[Table]:
    """Return the tables of about one height: connected pieces of the map that are large."""
    low = places.min(axis=0) - border
    columns, rows = (np.ptp(places, axis=0) + 2 * border) // CELL + 1
    column, row = ((places - low) / CELL).astype(np.int64).T
    seen = np.zeros((int(rows), int(columns)), np.uint8)
    seen[row, column] = 1
    seen = cv2.morphologyEx(seen, cv2.MORPH_CLOSE, _disc(CELL)).astype(np.uint8)
    # Narrow strips are edges of something else, such as the back of a chair.
    seen = cv2.morphologyEx(seen, cv2.MORPH_OPEN, _disc(CELL)).astype(np.uint8)
    seen = cv2.morphologyEx(seen, cv2.MORPH_CLOSE, _disc(0.12)).astype(np.uint8)
    n_pieces, piece, statistics, _ = cv2.connectedComponentsWithStats(seen)
    found = []
    for number in range(1, n_pieces):
        area = float(statistics[number, cv2.CC_STAT_AREA]) * CELL**2
        is_piece = (piece == number).astype(np.uint8)
        if area < MIN_TABLE_AREA or _diagonal(is_piece) < MIN_TABLE_DIAGONAL:
            continue
        height = float(np.median(heights[piece[row, column] == number]))
        # What stands on a table hides some of it, and casts a shadow without readings.
        extent = cv2.morphologyEx(is_piece, cv2.MORPH_CLOSE, _disc(0.25)).astype(np.uint8)
        found.append(Table(height, area, axes, low, extent))
    return found


def _diagonal(piece: npt.NDArray[np.uint8]) -> float:
    _, size, _ = cv2.minAreaRect(np.argwhere(piece).astype(np.float32))
    return float(np.hypot(*size)) * CELL


def _disc(radius: float) -> npt.NDArray[np.uint8]:
    side = 2 * round(radius / CELL) + 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)).astype(np.uint8)


def is_seat(table: Table, places: Array, heights: Array) -> bool:
    """Tell a sofa or a bed: low, and wide or with a back and arms; or a full shelf.

    places, heights: what the frames saw, as for `map_tables`, whatever it faces.
    """
    if _filled_share(table, places, heights) > 0.5:
        return True
    if table.height > MAX_SEAT_HEIGHT:
        return False
    return table.area > MIN_BED_AREA or _is_enclosed(table, places, heights)


def _filled_share(table: Table, places: Array, heights: Array) -> float:
    over = (heights > table.height + 0.05) & (heights < table.height + 0.45)
    column, row = np.floor((places[over] - table.low) / CELL).astype(np.int64).T
    rows, columns = table.extent.shape
    is_inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    filled = np.zeros(table.extent.shape, np.bool_)
    filled[row[is_inside], column[is_inside]] = True
    return float(np.mean(filled[table.extent > 0]))


def _is_enclosed(table: Table, places: Array, heights: Array, *, ring: float = 0.14) -> bool:
    """Tell whether something a little higher than a low top runs along much of its edge.

    A sofa's back and arms do, but for a wall behind a bench, which is higher still.
    """
    around = cv2.dilate(table.extent, _disc(ring)) - cv2.erode(table.extent, _disc(0.04))
    rows, columns = around.shape
    column, row = np.floor((places - table.low) / CELL).astype(np.int64).T
    is_inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    highest = np.zeros(around.shape)
    np.maximum.at(highest, (row[is_inside], column[is_inside]), heights[is_inside])
    rises = (highest > table.height + 0.08) & (highest < 1.2)
    # Any cell of the ring across the edge counts for the edge beside it.
    rises = cv2.dilate((rises & (around > 0)).astype(np.uint8), _disc(ring)) > 0
    edge = (table.extent - cv2.erode(table.extent, _disc(0.04))) > 0
    return float(np.mean(rises[edge])) > MIN_ENCLOSED_SHARE
