"""The tables and other furniture of a recording, from a map of all that its frames show.

One frame sees a table's top from the edge, in pieces between the things on it, or not at all.
Then its legs look like things on the floor, and what stands on it like parts of it. Together
the frames know how high each table is and how far it reaches.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.teacher.cloud.points import Points, look_up
from curiosight.teacher.supports.ground import (
    CELL,
    Ground,
    area,
    closed,
    diagonal,
    grown,
    inset,
    opened,
    pieces,
)
from curiosight.teacher.supports.tops import (
    MAX_HEIGHT,
    MIN_HEIGHT,
    WIDEST_GAP,
    Kind,
    SeenFromAbove,
    near_walls,
)

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

# What is this close to a table's outline (metres) belongs to it.
MARGIN = 0.05
MAX_CORE = 0.25
# Metres by which noise and poses make things wider; each frame tells their size better.
BLUR = 0.10
MAX_LEVEL_ANGLE = np.radians(20)


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table, a counter, or other furniture.

    height: of its top, metres over the floor.
    axes: (3, 2) the map's directions in the world, of columns and of rows, unit vectors.
    low: (2,) metres along them of the first cell's corner.
    inset: (rows, columns) float32 metres that a cell lies inside the outline, negative outside.
    kind: what it is.
    """

    height: float
    axes: Array
    low: Array
    inset: npt.NDArray[np.float32]
    kind: Kind = Kind.TABLE

    @property
    def core(self) -> float:
        """How far inside the outline the table certainly is, metres; half way, of a small one."""
        return min(MAX_CORE, float(np.max(self.inset)) / 2)

    def is_in_view(self, points: Points, T_world_camera: Pose, max_range: float) -> bool:
        """Tell whether points up to a range in metres could be over or under the table's map."""
        seen = np.concatenate([np.zeros((1, 3)), max_range * points.corner_rays()])
        axes, corner = self._in_camera(T_world_camera)
        pyramid = cv2.convexHull((seen @ axes - corner).astype(np.float32))
        rows, columns = self.inset.shape
        outline = [[0, 0], [columns, 0], [columns, rows], [0, rows]]
        window = np.array(outline, np.float32) * np.float32(CELL)
        return bool(cv2.intersectConvexConvex(pyramid, window)[0] > 0)

    def inset_of(self, points: Points, T_world_camera: Pose) -> Array:
        """(h, w) metres that points lie inside the outline, seen from above.

        -inf far from the table and where a point has no reading.
        """
        axes, corner = self._in_camera(T_world_camera)
        found: Array = look_up(self.inset, points, axes, corner, CELL)
        return found

    def _in_camera(self, T_world_camera: Pose) -> tuple[Array, Array]:
        """Return the map's axes and its corner along them, in the camera's frame."""
        axes = T_world_camera[:3, :3].T @ self.axes
        return axes, self.low - T_world_camera[:3, 3] @ self.axes


def map_tables(
    level: Iterable[Array],
    seen: Iterable[Array],
    up: Array,
    floor: float,
    *,
    max_size: float = 1.5,
    min_area: float = 0.07,
    min_diagonal: float = 0.38,
    max_small_height: float = 0.8,
    density: float = 1.0,
) -> tuple[Table, ...]:
    """Return the tables of a recording, the lowest first, then other furniture.

    level, seen: (n, 3) points of level surfaces and of all surfaces, in the world, in parts:
        all together are large. Those seen are gone through more than once.
    up: (3,) unit vector; floor: metres along it.
    max_size: metres across the largest object.
    min_area, min_diagonal: m² and metres of a level surface, to be a table's top.
    density: of the points seen, by that of frames of 320x240.
    """
    if not any(len(xyz) for xyz in seen):
        return ()
    ground = Ground.around(seen, up)
    cells, heights = _on_map(ground, seen, up, floor)
    above = SeenFromAbove(
        ground, cells, heights, max_size=max_size, max_small_height=max_small_height, blur=BLUR
    )
    tables: list[Table] = []
    is_top = np.zeros(ground.shape, np.bool_)
    elevated = _on_map(ground, level, up, floor, (MIN_HEIGHT, MAX_HEIGHT))
    found = _tops(ground, *elevated, min_area, min_diagonal)
    for height, top in sorted(found, key=lambda found: -area(found[1])):
        kind = above.judge(height, top, heights - height)
        if kind is not None:
            is_top |= top
            tables.append(_table(ground, height, top, kind))
    bulky = _bulky_pieces(above.highest, above.n_over_floor / density, grown(is_top, 0.15))
    rest = [
        _table(ground, float(np.median(above.highest[piece])), piece, Kind.FURNITURE)
        for piece in bulky
    ]
    return (*sorted(tables, key=lambda table: table.height), *rest)


def _on_map(
    ground: Ground,
    parts: Iterable[Array],
    up: Array,
    floor: float,
    between: tuple[float, float] = (-np.inf, np.inf),
) -> tuple[Array, Array]:
    """Return (n,) cells, and metres over the floor, of the points of all parts between heights."""
    cells, heights = [np.empty(0, np.int64)], [np.empty(0)]
    for xyz in parts:
        height = xyz @ up - floor
        is_between = (height > between[0]) & (height < between[1])
        cells.append(ground.cells(xyz[is_between]))
        heights.append(height[is_between])
    return np.concatenate(cells), np.concatenate(heights)


def _table(ground: Ground, height: float, top: Mask, kind: Kind) -> Table:
    """Return a table with the map of its surroundings."""
    rows, columns = np.nonzero(grown(top, 0.5))
    window = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    low = ground.low + CELL * np.array([columns.min(), rows.min()])
    return Table(height, ground.axes, low, inset(top[window]), kind)


def level_surface(points: Points, up: Array, noise: float, is_veil: Mask) -> Array:
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
    # A veil falls with the view; a surface seen from the edge, by less than a row is high.
    is_even = np.abs(rise) < abs(float(points.y[1] - points.y[0])) * near[..., 2]
    is_between = (is_level[1:] & is_level[:-1]) | is_grazing
    is_between &= is_even | ~(is_veil[1:] | is_veil[:-1])
    is_between &= (np.abs(rise) < np.tan(MAX_LEVEL_ANGLE) * run) & (run < 0.3)
    start, way = near[is_between], (far - near)[is_between]
    between = [start + share * way for share in np.arange(0, 1, CELL / 0.3).astype(np.float32)]
    return np.concatenate([points.xyz[is_level & ~is_veil], *between])


def _tops(
    ground: Ground,
    cells: Array,
    heights: Array,
    min_area: float,
    min_diagonal: float,
    *,
    step: float = 0.02,
) -> list[tuple[float, Mask]]:
    """Return height and (rows, columns) extent of the level surfaces.

    cells, heights: (n,) of level surfaces. step: metres between layers.
    """
    n_places = ground.shape[0] * ground.shape[1]
    found: list[tuple[float, Mask]] = []
    while len(cells):
        # One number for layer and cell: rows of two sort ten times slower.
        layers = np.unique((heights / step).astype(np.int64) * n_places + cells) // n_places
        n_cells = np.convolve(np.bincount(layers), np.ones(3), "same")
        if n_cells.max() * CELL**2 < 0.5 * min_area:
            break
        near = np.abs(heights - (int(np.argmax(n_cells)) + 0.5) * step) < 2.5 * step
        # Narrow strips are edges of something else, such as the back of a chair.
        layer = opened(closed(ground.count(cells[near]) > 0, 0.04), 0.04)
        for piece in pieces(closed(layer, 0.12)):
            if area(piece) >= min_area and diagonal(piece) >= min_diagonal:
                height = float(np.median(heights[near][piece.ravel()[cells[near]]]))
                found.append((height, closed(piece, WIDEST_GAP)))
        cells, heights = cells[~near], heights[~near]
    return found


def _bulky_pieces(
    highest: Array,
    n_points: Array,
    is_table: Mask,
    *,
    min_points: int = 6,
    min_diagonal: float = 1.1,
) -> list[Mask]:
    """Return what stands on the floor and is wider than objects are, such as a sofa's back.

    highest, n_points: (rows, columns) of all surfaces over the floor, as frames of 320x240 have.
    """
    is_bulk = (n_points >= min_points) & ~near_walls(highest) & ~is_table
    return [piece for piece in pieces(is_bulk) if diagonal(piece) >= min_diagonal]
