"""The tables of a recording, from a map of all level surfaces that its frames show.

One frame sees a table's top from the edge, in pieces between the things on it, or not at all.
Then its legs look like things on the floor, and what stands on it like parts of it. Together
the frames know how high each table is and how far it reaches.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.segmentation.points import Points, look_up

Array = npt.NDArray[Any]

# Side of a map's cell, and thickness of its layers: metres.
CELL, LAYER = 0.04, 0.02
# A level surface is a table, not a box's lid or a chair's seat, from this size on.
MIN_TABLE_AREA = 0.25
MIN_TABLE_DIAGONAL = 0.7
MIN_TABLE_HEIGHT, MAX_TABLE_HEIGHT = 0.2, 1.3
# What is this close to a table's outline (metres) belongs to it.
MARGIN = 0.05
MAX_LEVEL_ANGLE = np.radians(20)


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table, a counter, a seat, a bed or a shelf.

    height: metres over the floor. area: square metres of its top that were seen.
    axes: (3, 2) the map's two directions in the world, horizontal unit vectors.
    low: (2,) metres along `axes` of the first cell's corner.
    inset: (rows, columns) float32 metres that a cell lies inside the table's outline,
        negative outside; rows along the second axis.
    carries_objects: False where what is on it is part of it: cushions, books in a shelf.
    """

    height: float
    area: float
    axes: Array
    low: Array
    inset: npt.NDArray[np.float32]
    carries_objects: bool = True

    def inset_of(self, points: Points, T_world_camera: Pose) -> Array:
        """(h, w) metres that points lie inside the outline, seen from above.

        -inf far from the table and where a point has no reading.
        """
        axes = T_world_camera[:3, :3].T @ self.axes
        corner = self.low - T_world_camera[:3, 3] @ self.axes
        inset: Array = look_up(self.inset, points.xyz, axes, corner, CELL)
        return inset


def map_tables(level: Array, seen: Array, up: Array, floor: float, axes: Array) -> list[Table]:
    """Return the tables of a recording, the lowest first.

    level, seen: (n, 3) points of level surfaces and of all surfaces, in the world.
    up: (3,) unit vector; floor: metres along it. axes: see `Table`.
    """
    heights = level @ up - floor
    is_elevated = (heights > MIN_TABLE_HEIGHT) & (heights < MAX_TABLE_HEIGHT)
    places, heights = level[is_elevated] @ axes, heights[is_elevated]
    tables: list[Table] = []
    while len(places):
        layer = (heights / LAYER).astype(np.int64)
        cells = np.unique(np.column_stack([layer, np.floor(places / CELL).astype(int)]), axis=0)
        n_cells = np.convolve(np.bincount(cells[:, 0]), np.ones(3), "same")
        if n_cells.max() * CELL**2 < 0.5 * MIN_TABLE_AREA:
            break
        near = np.abs(heights - (int(np.argmax(n_cells)) + 0.5) * LAYER) < 2.5 * LAYER
        tables += _tables_at(places[near], heights[near], axes)
        places, heights = places[~near], heights[~near]
    tables.sort(key=lambda table: table.height)
    lowest = [t for i, t in enumerate(tables) if not any(_holds(low, t) for low in tables[:i])]
    places, heights = seen @ axes, seen @ up - floor
    return [
        replace(table, carries_objects=not _is_upholstered_or_full(table, places, heights))
        for table in lowest
    ]


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


def _tables_at(places: Array, heights: Array, axes: Array, *, border: float = 0.5) -> list[Table]:
    """Return the tables of about one height: connected pieces of the map that are large.

    border: metres of map around them.
    """
    low = places.min(axis=0) - border
    n_columns, n_rows = np.ceil((np.ptp(places, axis=0) + 2 * border) / CELL).astype(int)
    column, row = ((places - low) / CELL).astype(np.int64).T
    top = np.zeros((n_rows, n_columns), np.uint8)
    top[row, column] = 1
    # Narrow strips are edges of something else, such as the back of a chair.
    top = cv2.morphologyEx(top, cv2.MORPH_CLOSE, _disc(0.04)).astype(np.uint8)
    top = cv2.morphologyEx(top, cv2.MORPH_OPEN, _disc(0.04)).astype(np.uint8)
    top = cv2.morphologyEx(top, cv2.MORPH_CLOSE, _disc(0.12)).astype(np.uint8)
    n_pieces, piece, statistics, _ = cv2.connectedComponentsWithStats(top)
    found = []
    for number in range(1, n_pieces):
        area = float(statistics[number, cv2.CC_STAT_AREA]) * CELL**2
        is_piece = (piece == number).astype(np.uint8)
        _, size, _ = cv2.minAreaRect(np.argwhere(is_piece).astype(np.float32))
        if area < MIN_TABLE_AREA or np.hypot(*size) * CELL < MIN_TABLE_DIAGONAL:
            continue
        height = float(np.median(heights[piece[row, column] == number]))
        # What stands on a table hides some of it, and casts a shadow without readings.
        reach = cv2.morphologyEx(is_piece, cv2.MORPH_CLOSE, _disc(0.25)).astype(np.uint8)
        found.append(Table(height, area, axes, low, _inset(reach)))
    return found


def _inset(reach: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    inside = cv2.distanceTransform(reach, cv2.DIST_L2, cv2.DIST_MASK_5)
    outside = cv2.distanceTransform(1 - reach, cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray((inside - outside) * CELL, np.float32)


def _disc(radius: float) -> npt.NDArray[np.uint8]:
    side = 2 * round(radius / CELL) + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)), np.uint8)


def _holds(lower: Table, upper: Table, *, min_share: float = 0.5) -> bool:
    """Tell whether one table is on the other: then it is the tops of what stands there."""
    shift = np.round((upper.low - lower.low) / CELL).astype(int)[::-1]
    cells = np.argwhere(upper.inset > 0) + shift
    is_on_map = ((cells >= 0) & (cells < lower.inset.shape)).all(axis=1)
    row, column = cells[is_on_map].T
    n_inside = int(np.count_nonzero(lower.inset[row, column] > 0))
    return n_inside > min_share * len(cells)


def _is_upholstered_or_full(
    table: Table,
    places: Array,
    heights: Array,
    *,
    max_seat_height: float = 0.62,
    min_bed_area: float = 1.5,
    min_enclosed: float = 0.35,
    min_filled: float = 0.5,
) -> bool:
    """Tell a sofa or a bed, low and wide or with a back and arms, and a full shelf.

    places: (n, 2) along the table's axes, and heights: (n,) over the floor, of all surfaces.
    min_enclosed: share of the edge along which something a little higher runs; a wall, which
        is higher still, does not count. min_filled: share of the top with something over it.
    """
    is_full = (heights > table.height + 0.05) & (heights < table.height + 0.45)
    filled = _highest(table, places[is_full], heights[is_full]) > 0
    if np.mean(filled[table.inset > 0]) > min_filled:
        return True
    if table.height > max_seat_height or table.area > min_bed_area:
        return table.height <= max_seat_height
    highest = _highest(table, places, heights)
    is_rim = (table.inset > -0.14) & (table.inset <= CELL)
    rises = (highest > table.height + 0.08) & (highest < 1.2) & is_rim
    beside = cv2.dilate(rises.astype(np.uint8), _disc(0.14)) > 0
    is_edge = (table.inset > 0) & (table.inset <= CELL)
    return float(np.mean(beside[is_edge])) > min_enclosed


def _highest(table: Table, places: Array, heights: Array) -> Array:
    """(rows, columns) height of the highest point over each cell, 0 = none."""
    cells = np.floor((places - table.low) / CELL).astype(np.int64)[:, ::-1]
    is_on_map = ((cells >= 0) & (cells < table.inset.shape)).all(axis=1)
    highest = np.zeros(table.inset.shape)
    np.maximum.at(highest, tuple(cells[is_on_map].T), heights[is_on_map])
    return highest
