"""Whether a cluster is an object, and if not, why (sec. II-A.2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.segmentation.planes import Mask
from curiosight.segmentation.points import Points, ends
from curiosight.segmentation.settings import SegmentationSettings
from curiosight.segmentation.supports import Support
from curiosight.segmentation.walls import Wall

Array = npt.NDArray[Any]


class Verdict(Enum):
    """Why a cluster is, or is not, an object. Everything but OBJECT is labelled unknown."""

    OBJECT = "object"
    CUT = "touches the image border"
    FAR = "reaches beyond the range"
    SMALL = "too small"
    LARGE = "too large"
    HIGH = "too high over its support"
    FLAT = "hardly rises over its support"
    FLOATING = "stands on nothing"
    FURNITURE = "belongs to a piece of furniture"
    WALL_PART = "belongs to a wall"


@dataclass(frozen=True, slots=True)
class Cluster:
    """A group of points on a support.

    box: (u_min, v_min, u_max, v_max) in pixels of the full image, ends exclusive.
    n_pixels: in the full image.
    size: metres, (width, length, height); the height is over the support.
    distance: median metres along z.
    support_height: of its support over the lowest one, metres.
    """

    verdict: Verdict
    box: tuple[int, int, int, int]
    n_pixels: int
    size: tuple[float, float, float]
    distance: float
    support_height: float


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What clusters are judged against.

    supports: lowest first. border: (h, w) bool, what no object may touch.
    """

    points: Points
    supports: list[Support]
    walls: list[Wall]
    border: Mask
    settings: SegmentationSettings


def judge(
    cluster: Cluster, members: Array, stands: bool, support: Support, around: Surroundings
) -> Verdict:
    """Apply the paper's tests; the first that fails names the verdict.

    members: flat indices of its points. stands: whether it reaches down to its support.
    """
    limits = support.settings
    diagonal = float(np.linalg.norm(cluster.size))
    depth = around.points.depth.ravel()[members]
    if is_cut(members, around.border):
        return Verdict.CUT
    if diagonal < limits.min_size:
        return Verdict.SMALL
    if diagonal > limits.max_size or np.hypot(*cluster.size[:2]) > limits.max_width:
        return Verdict.LARGE
    _, high = ends(support.heights.ravel()[members], 0.1)
    if high > limits.max_size:
        return Verdict.HIGH
    if any(_is_part_of_table(table, members, support) for table in around.supports):
        return Verdict.FURNITURE
    if np.count_nonzero(depth > around.settings.max_range - 0.05) > 5:
        return Verdict.FAR
    xyz = around.points.xyz_at(members)
    if any(_is_part_of_wall(wall, members, xyz, support, around) for wall in around.walls):
        return Verdict.WALL_PART
    noise = around.settings.noise * cluster.distance**2
    if high < 2 * (limits.slab + noise):
        return Verdict.FLAT
    return Verdict.OBJECT if stands else Verdict.FLOATING


def is_cut(members: Array, border: Mask, *, max_share: float = 0.02) -> bool:
    """Tell whether a cluster touches the border, by more than stray points beside it."""
    n_cut = int(np.count_nonzero(border.ravel()[members]))
    return n_cut > max_share * len(members)


def _is_part_of_table(table: Support, members: Array, support: Support) -> bool:
    """Tell whether a cluster on the floor is a seat's cushion or arm, or a table's leg or apron.

    Those end at the table's top, or are hidden above; the map may know only a part of the top.
    """
    if support.is_table or table.extent is None or table.skirt is None:
        return False
    share = np.mean(table.skirt.ravel()[members])
    if not table.carries_objects:
        return bool(share > 0.7 or np.mean(table.extent.ravel()[members]) > 0.03)
    top = ends(table.heights.ravel()[members], 0.02)[1]
    return bool((share > 0.7 and -0.5 < top < 0.05) or (share > 0.2 and abs(top) < 0.05))


def _is_part_of_wall(
    wall: Wall, members: Array, xyz: Array, support: Support, around: Surroundings
) -> bool:
    """Tell whether a cluster hangs on a wall, or is round its corner.

    On the floor nothing stands as close to a wall as a radiator, or a curtain.
    """
    n_straight, n_behind = wall.count_sides(xyz)
    if 2 * n_straight > len(xyz):
        distance = wall.distance(xyz)
        gap = np.abs(distance)
        if 2 * np.count_nonzero(gap < around.settings.wall_gap) > len(xyz):
            return True
        # Seen through a window, not through a door.
        floats = ends(support.heights.ravel()[members], 0.1)[0] > 0.3
        if not support.is_table and floats and 2 * np.count_nonzero(distance < 0) > len(xyz):
            return True
        if not support.is_table and ends(gap, 0.05)[1] < 2 * around.settings.wall_gap:
            return True
    # The other face lies behind.
    if 2 * n_behind < len(xyz) or not wall.inliers.any():
        return False
    return _turns_corner(around.points, members, wall)


def _turns_corner(points: Points, members: Array, wall: Wall, *, reach: int = 6) -> bool:
    """Tell whether a cluster is the other face of a wall, round a convex corner.

    It lies behind the wall's plane, and in most of its rows goes over into the wall sideways,
    without a step. Together they are larger than any object. What stands before a wall meets
    it in a concave corner and stays out of this.

    reach: cells over the crease, where no normal is known.
    """
    height, width = points.depth.shape
    v, u = np.unravel_index(members, points.depth.shape)
    first, last = np.full(height, width), np.full(height, -1)
    np.minimum.at(first, v, u)
    np.maximum.at(last, v, u)
    rows = np.unique(v)
    for edge, beyond in ((first, -reach), (last, reach)):
        there = np.clip(edge[rows] + beyond, 0, width - 1)
        step = np.abs(points.depth[rows, there] - points.depth[rows, edge[rows]])
        if np.mean(wall.inliers[rows, there] & (step < 0.10)) > 0.5:
            return True
    return False
