"""Whether a cluster is an object, and if not, why (sec. II-A.2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import hypot
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.planes import Mask, horizontal_axes
from curiosight.teacher.cloud.points import Points, ends
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.things.things import Surroundings, Thing

Array = npt.NDArray[Any]


class Verdict(Enum):
    """Why a cluster is, or is not, an object. Everything but OBJECT is labelled unknown."""

    OBJECT = "object"
    CUT = "touches the image border"
    FAR = "reaches beyond the range"
    NEAR = "reaches nearer than the sensor sees"
    SMALL = "too small"
    LARGE = "too large"
    SPARSE = "too few points for its size"
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


def judge(thing: Thing, around: Surroundings) -> Verdict:
    """Apply the paper's tests to a thing; the first that fails names the verdict."""
    support = around.supports[thing.support]
    limits, settings = support.settings, around.settings
    if thing.is_cut:
        return Verdict.CUT
    if hypot(*thing.size) < limits.min_size:
        return Verdict.SMALL
    if not _fits(thing, support, around.points):
        return Verdict.LARGE
    if _is_sparse(thing, around.points):
        return Verdict.SPARSE
    if thing.top > limits.max_size:
        return Verdict.HIGH
    if any(_is_part_of_table(table, thing, support) for table in around.supports):
        return Verdict.FURNITURE
    depth = around.points.depth.take(thing.members)
    if np.count_nonzero(depth > settings.max_range - 0.05) > 5:
        return Verdict.FAR
    if _goes_on_nearer(thing, depth, around.points.depth, settings.near_range):
        return Verdict.NEAR
    xyz = around.points.xyz_at(thing.members)
    walls = _walls_at(xyz, around.walls, 2 * settings.wall_gap)
    if any(_is_part_of_wall(wall, thing, xyz, support, around) for wall in walls):
        return Verdict.WALL_PART
    # From above, over a table, the whole of a thing is seen, and how little it rises is sure.
    least = 1.1 if support.is_table and _is_from_above(xyz, support) else 2.0
    if thing.top < least * (limits.slab + settings.noise * thing.distance**2):
        return Verdict.FLAT
    return Verdict.OBJECT if thing.stands else Verdict.FLOATING


def _fits(thing: Thing, support: Support, points: Points, *, n_headings: int = 9) -> bool:
    """Tell whether the smallest upright box around a thing is no larger than objects are.

    The camera's axes are tried first, then others.
    """
    limits, height = support.settings, thing.size[2]

    def is_in_size(width: float, length: float) -> bool:
        across = hypot(width, length)
        return across <= limits.max_width and hypot(across, height) <= limits.max_size

    if is_in_size(*thing.size[:2]):
        return True
    # Across its diagonal the box of a thing is at most so much larger.
    if hypot(*thing.size[:2]) > np.sqrt(2) * limits.max_width:
        return False
    places = points.xyz_at(thing.members) @ np.stack(horizontal_axes(support.plane.normal), axis=1)
    for heading in np.pi / 2 * np.arange(1, n_headings) / n_headings:
        cos, sin = np.cos(heading), np.sin(heading)
        turned = places @ np.array([[cos, -sin], [sin, cos]], np.float32)
        width, length = (float(np.ptp(ends(along, 0.02))) for along in turned.T)
        if is_in_size(width, length):
            return True
    return False


def _is_from_above(xyz: Array, support: Support, *, min_cosine: float = 0.82) -> bool:
    """Tell whether the camera looks down on (n, 3) points within 35° of straight down."""
    middle = xyz.mean(axis=0)
    return bool(-(support.plane.normal @ middle) > min_cosine * np.linalg.norm(middle))


def _is_sparse(thing: Thing, points: Points, *, min_filled: float = 0.03) -> bool:
    """Tell whether a thing fills hardly any of its box, as scraps of a wall along the view do.

    min_filled: share of the two longest sides' product that its points cover, seen face on.
    """
    cell = float(points.x[1] - points.x[0]) * float(points.y[1] - points.y[0])
    covered = len(thing.members) * cell * thing.distance**2
    _, middle, longest = sorted(thing.size)
    return covered < min_filled * middle * longest


def _goes_on_nearer(
    thing: Thing,
    depth: Array,
    depths: Array,
    near: float,
    *,
    max_width: float = 0.25,
    min_share: float = 0.3,
) -> bool:
    """Tell whether a slender thing ends upwards where it comes too near for the sensor.

    A table's leg before the camera looks like a small object on the floor then. Of an object
    that is seen whole the far edge of its top is uppermost, and not nearest.

    depth: (n,) metres of the members, depths: (h, w) of all points. near: metres.
    max_width: diagonal of a slender thing's ground plan, metres.
    min_share: of the thing's columns that end so, with no reading above.
    """
    nearest = ends(depth, 0.02)[0]
    if nearest > near or hypot(*thing.size[:2]) > max_width:
        return False
    v, u = np.divmod(thing.members, depths.shape[1])
    top = np.full(depths.shape[1], len(depths))
    np.minimum.at(top, u, v)
    columns = np.flatnonzero(top < len(depths))
    top = top[columns]
    above = depths[np.maximum(top - 2, 0), columns]
    ends_near = np.isnan(above) & (depths[top, columns] < nearest + 0.01)
    return bool(np.count_nonzero(ends_near) > min_share * len(columns))


def _is_part_of_table(table: Support, thing: Thing, support: Support) -> bool:
    """Tell whether a thing on the floor is a seat's cushion or arm, or a table's leg or apron.

    Those end at the table's top, or are hidden above; the map may know only a part of the top.
    """
    if support.is_table or table.extent is None or table.skirt is None:
        return False
    share = _share_in(table.skirt, thing)
    if not table.kind.carries_objects:
        return share > 0.7 or _share_in(table.extent, thing) > 0.03
    if share <= 0.2:
        return False
    top = ends(table.heights.take(thing.members), 0.02)[1]
    return abs(top) < 0.05 or (share > 0.7 and -0.5 < top < 0.05)


def _share_in(mask: Mask, thing: Thing) -> float:
    return np.count_nonzero(mask.take(thing.members)) / len(thing.members)


def _walls_at(xyz: Array, walls: list[Wall], gap: float) -> list[Wall]:
    """Return the walls that the box around (n, 3) points is not before by more than a gap."""
    if not walls:
        return []
    # NumPy finds the least of a row much faster than that of a column.
    places = np.ascontiguousarray(xyz.T)
    low, high = places.min(axis=1), places.max(axis=1)
    normals = np.array([wall.normal for wall in walls])
    offsets = np.array([wall.offset for wall in walls])
    nearest = normals @ (low + high) / 2 - np.abs(normals) @ (high - low) / 2 + offsets
    return [wall for wall, distance in zip(walls, nearest, strict=True) if distance <= gap]


def _is_part_of_wall(
    wall: Wall, thing: Thing, xyz: Array, support: Support, around: Surroundings
) -> bool:
    """Tell whether a thing hangs on a wall, or is round its corner; xyz: (n, 3) of its members.

    On the floor nothing stands as close to a wall as a radiator, or a curtain.
    """
    n_straight, n_behind = wall.count_sides(xyz)
    if 2 * n_straight > len(xyz):
        distance = wall.distance(xyz)
        gap = np.abs(distance)
        if 2 * np.count_nonzero(gap < around.settings.wall_gap) > len(xyz):
            return True
        # Seen through a window, not through a door.
        floats = thing.bottom > 0.3
        if not support.is_table and floats and 2 * np.count_nonzero(distance < 0) > len(xyz):
            return True
        if not support.is_table and ends(gap, 0.05)[1] < 2 * around.settings.wall_gap:
            return True
    # The other face lies behind.
    if 2 * n_behind < len(xyz) or not wall.inliers.any():
        return False
    return _turns_corner(around.points, thing.members, wall)


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
