"""Depth to points and local planes, on the organised grid.

Everything here works in *inverse depth*. A plane n·p = 1 seen by a pinhole is affine in it:
1/z = n_x x + n_y y + n_z with the normalised pixel (x, y) = ((u - cx)/fx, (v - cy)/fy). So a
local plane is a linear fit, and the noise of a triangulating sensor, which grows with z², is
the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Camera, Depth, Pose
from curiosight.teacher.cloud.local_planes import fit_local_planes

Array = npt.NDArray[Any]
# What is said in pixels is said of an image with so many, 640x480: of any other it is the same
# share of the view, and so the same angle.
USUAL_PIXELS = 640 * 480
# Every so many rows and columns of such an image are looked at.
USUAL_STRIDE = 3


def scale_of(camera: Camera) -> float:
    """Return how many columns and rows of an image there are for one of a 640x480 image."""
    return sqrt(camera.width * camera.height / USUAL_PIXELS)


@dataclass(frozen=True, slots=True)
class Points:
    """The organised cloud of a frame, every `stride`-th pixel of it.

    xyz: (h, w, 3) float32 metres in the colour camera's frame, NaN = no reading.
    depth: (h, w) float32 metres along z, the z of `xyz` in one piece.
    normals: (h, w, 3) float32 unit vectors towards the camera, NaN where the surface is
        unknown (an edge, a hole).
    area: (h, w) float32 square metres that a pixel covers on its surface, 0 without a normal.
    x, y: (w,) and (h,) float32 normalised pixels of the columns and rows: xyz = z (x, y, 1).
    scale: of the image, see `scale_of`.
    border: (h, w) bool, where the view ends; None = nowhere. pose: (4, 4) `T_world_camera`.
    """

    xyz: Array
    depth: Array
    normals: Array
    area: Array
    x: Array
    y: Array
    stride: int
    scale: float = 1.0
    border: npt.NDArray[np.bool_] | None = None
    pose: Pose | None = None

    @property
    def cell(self) -> float:
        """Return the pixels of a 640x480 image from one point of the grid to the next."""
        return self.stride / self.scale

    def steps(self, length_px: float) -> int:
        """Return how many steps on the grid, at least one, cover pixels of a 640x480 image."""
        return max(1, round(length_px / self.cell))

    def count(self, area_px: float) -> float:
        """Return how many points of the grid an area in pixels of a 640x480 image has."""
        return area_px / self.cell**2

    def evidence(self, area_px: float) -> float:
        """Return how many points of the grid are enough to tell of something.

        Those of an area in pixels of a 640x480 image; on a coarser grid than that image's as
        many as there: fewer readings are as likely noise.
        """
        return area_px / min(self.cell, USUAL_STRIDE) ** 2

    def xyz_at(self, where: Array) -> Array:
        """Return the (n, 3) points at (n,) flat indices of the grid."""
        return rows_at(self.xyz, where)

    def corner_rays(self) -> Array:
        """Return the (4, 3) rays (x, y, 1) round the image's corners, one after the other."""
        left, top = float(self.x[0]), float(self.y[0])
        right, bottom = float(self.x[-1]), float(self.y[-1])
        return np.array([[left, top, 1], [right, top, 1], [right, bottom, 1], [left, bottom, 1]])

    def normals_at(self, where: Array) -> Array:
        """Return the (n, 3) normals at (n,) flat indices of the grid."""
        return rows_at(self.normals, where)


def rows_at(vectors: Array, where: Array) -> Array:
    """Return the (n, 3) vectors at (n,) flat indices of (…, 3) float32 ones."""
    rows = np.empty((len(where), 3), np.float32)
    # NumPy's own `take` copies row by row, which takes twice as long.
    _take_rows(vectors.reshape(-1, 3), np.ascontiguousarray(where), rows)
    return rows


@njit(cache=True, nogil=True, error_model="numpy")
def _take_rows(vectors: Array, where: Array, rows: Array) -> None:
    """Set the (n, 3) rows to the vectors at (n,) indices."""
    for place in range(len(where)):
        for axis in range(3):
            rows[place, axis] = vectors[where[place], axis]


def observe_points(
    depth: Depth, camera: Camera, *, stride: int = 2, radius_px: float = 8, max_bend: float = 0.01
) -> Points:
    """Back-project depth and fit a local plane around every point.

    stride: every so many rows and columns are taken.
    radius_px: half the window of the fit, in pixels of a 640x480 image; next to an
        edge the window shrinks with the distance to it, and below 1 there is no normal.
    max_bend: a second difference of inverse depth (1/m) that counts as an edge, beside 4 mm of
        depth for rounding; 0.01 is a step of 1 cm at 1 m, 9 cm at 3 m.
    """
    height, width = depth.shape
    x = ((np.arange(0, width, stride) - camera.cx) / camera.fx).astype(np.float32)
    y = ((np.arange(0, height, stride) - camera.cy) / camera.fy).astype(np.float32)
    z, inverse = np.empty((2, len(y), len(x)), np.float32)
    xyz = np.empty((len(y), len(x), 3), np.float32)
    _back_project(depth, stride, x, y, z, inverse, xyz)
    scale = scale_of(camera)
    radius = max(1, round(radius_px * scale / stride))
    normals, area = fit_local_planes(inverse, x, y, radius, max_bend)
    return Points(xyz, z, normals, area, x, y, stride, scale)


@njit(cache=True, nogil=True, error_model="numpy")
def _back_project(
    depth: Array, stride: int, x: Array, y: Array, z: Array, inverse: Array, xyz: Array
) -> None:
    """Set z, 1/z and (h, w, 3) point of every `stride`-th pixel of the depth in metres.

    x, y: (w,) and (h,) normalised pixels of the columns and rows.
    """
    for v in range(len(y)):
        for u in range(len(x)):
            z[v, u] = depth[v * stride, u * stride]
        for u in range(len(x)):
            inverse[v, u] = np.float32(1) / z[v, u]
        for u in range(len(x)):
            xyz[v, u, 0] = z[v, u] * x[u]
            xyz[v, u, 1] = z[v, u] * y[v]
            xyz[v, u, 2] = z[v, u]


def spread(
    values: Array,
    coarse: Array,
    depth: Array,
    stride: int,
    *,
    max_depth: float,
    beyond: int,
    is_one: bool = False,
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8], npt.NDArray[np.uint16]]:
    """Return for each of (H, W) pixels the values of the grid's cell around it closest in depth.

    values: (h, w) int32, three in one: bits 0 to 7, 8 to 15, and 16 up. coarse: (h, w) every
    `stride`-th pixel of `depth` (H, W). Where nothing tells the cells apart it is the one to the
    upper left.
    beyond: three in one too, of pixels farther than `max_depth` and of those without a reading.
    is_one: there is only the first, the others stay empty.
    """
    others = (0, 0) if is_one else depth.shape
    low, middle = np.empty(depth.shape, np.uint8), np.empty(others, np.uint8)
    high = np.empty(others, np.uint16)
    rows = np.empty((stride + 1, stride * coarse.shape[1]), np.int32)
    _spread(values, coarse, depth, max_depth, beyond, rows, low, middle, high)
    return low, middle, high


@njit(cache=True, nogil=True, error_model="numpy")
def _spread(
    values: Array,
    coarse: Array,
    depth: Array,
    max_depth: float,
    beyond: int,
    rows: Array,
    low: Array,
    middle: Array,
    high: Array,
) -> None:
    """Set what `spread` returns. rows: (stride + 1, w * stride) int32, to work with.

    Every pixel takes the cell to its upper left, in loops that vectorise; then the few whose
    cells around differ choose.
    """
    (height, width), stride = depth.shape, len(rows) - 1
    farthest, nothing = np.float32(max_depth), np.int32(beyond)
    for row in range(len(values)):
        top = row * stride
        n_rows, repeated = min(stride, height - top), rows[stride]
        for shift in range(stride):
            for column in range(values.shape[1]):
                repeated[column * stride + shift] = values[row, column]
        for v in range(n_rows):
            for u in range(width):
                rows[v, u] = repeated[u] if depth[top + v, u] <= farthest else nothing
        below = min(row + 1, len(values) - 1)
        for column in range(values.shape[1]):
            right = min(column + 1, values.shape[1] - 1)
            differs = values[row, column] ^ values[row, right]
            differs |= values[row, column] ^ values[below, column]
            if differs | (values[row, column] ^ values[below, right]):
                _choose_cells(values, coarse, depth, farthest, (row, column, below, right), rows)
        for v in range(n_rows):
            for u in range(width):
                low[top + v, u] = rows[v, u]
            for u in range(middle.shape[1]):
                middle[top + v, u] = rows[v, u] >> 8
                high[top + v, u] = rows[v, u] >> 16


@njit(cache=True, nogil=True, error_model="numpy")
def _choose_cells(
    values: Array,
    coarse: Array,
    depth: Array,
    farthest: float,
    corners: tuple[int, int, int, int],
    rows: Array,
) -> None:
    """Give the pixels below and to the right of a cell the value of the cell closest in depth.

    corners: row and column of the cell, and of that below it and to its right. A cell or a
    pixel without a reading is never close. rows: those of the cell's pixels.
    """
    row, column, below, right = corners
    stride = len(rows) - 1
    for v in range(row * stride, min(row * stride + stride, depth.shape[0])):
        # In the cell's own row, and column, there is nothing to choose from beyond it.
        other_v = below if v > row * stride else row
        for u in range(column * stride, min(column * stride + stride, depth.shape[1])):
            other_u = right if u > column * stride else column
            here, least, value = depth[v, u], np.float32(np.inf), values[row, column]
            for cell in ((row, column), (row, other_u), (other_v, column), (other_v, other_u)):
                gap = abs(coarse[cell] - here)
                if gap < least:
                    least, value = gap, values[cell]
            if here <= farthest:
                rows[v - row * stride, u] = value


def look_up(cells: Array, points: Points, axes: Array, corner: Array, side: float) -> Array:
    """(h, w) float32: what the cell of a map under or over each point holds, -inf beside it.

    cells: (rows, columns) float32. axes: (3, 2) directions of columns and rows in the frame of
    the points. corner: (2,) metres along them of the first cell's corner. side: metres.
    """
    to_map = np.empty((4, 2))
    to_map[:3], to_map[3] = axes, -corner
    to_map = (to_map / side).astype(np.float32)
    return np.asarray(_look_up(cells, points.depth, points.x, points.y, to_map))


@njit(cache=True, nogil=True, error_model="numpy")
def _look_up(cells: Array, depth: Array, x: Array, y: Array, to_map: Array) -> Array:
    """Return what `look_up` does; to_map: (4, 2) float32, from (x, y, z, 1) to column and row.

    depth, x, y: see `Points`.
    """
    found, index = np.empty_like(depth), np.empty(len(x), np.int32)
    n_rows, n_columns = np.float32(len(cells)), np.float32(cells.shape[1])
    width, outside = np.int32(cells.shape[1]), np.float32(-np.inf)
    flat = cells.reshape(cells.size)
    a, b, c, d = to_map[0], to_map[1], to_map[2], to_map[3]
    for v in range(len(y)):
        column_0, row_0 = y[v] * b[0] + c[0], y[v] * b[1] + c[1]
        for u in range(len(x)):
            column = depth[v, u] * (x[u] * a[0] + column_0) + d[0]
            row = depth[v, u] * (x[u] * a[1] + row_0) + d[1]
            # A point without a reading is NaN and compares false.
            is_on_map = (column >= 0.0) & (column < n_columns) & (row >= 0.0) & (row < n_rows)
            index[u] = np.int32(row) * width + np.int32(column) if is_on_map else np.int32(-1)
        for u in range(len(x)):
            found[v, u] = flat[index[u]] if index[u] >= 0 else outside
    return found
