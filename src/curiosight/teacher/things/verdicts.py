"""Whether a cluster is an object, and if not, why (sec. II-A.2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import hypot
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import Mask, horizontal_axes
from curiosight.teacher.cloud.ranks import ends
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.things.things import Thing
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
# Stray readings beyond the range cover so many pixels of a 640x480 image.
STRAY_PX = 50
# Over a crease, where no normal is known, in pixels of a 640x480 image.
CREASE_PX = 18
# Share of a thing that is straight above or below a surface which is its own.
MIN_UNDER_LID = 0.3


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


def judge(thing: Thing, around: Surroundings) -> Verdict:
    """Apply the paper's tests to a thing; the first that fails names the verdict."""
    support = around.supports[thing.support]
    limits, settings = support.settings, around.settings
    if thing.is_cut:
        return Verdict.CUT
    if hypot(*thing.size) < limits.min_size:
        return Verdict.SMALL
    if not _fits(thing, around):
        return Verdict.LARGE
    if thing.top > limits.max_size:
        return Verdict.HIGH
    if not support.is_table and any(_is_part_of_table(one, thing) for one in around.supports):
        return Verdict.FURNITURE
    is_far = around.points.depth.take(thing.members) > settings.max_range - 0.05
    if np.count_nonzero(is_far) > around.points.count(STRAY_PX):
        return Verdict.FAR
    if _is_part_of_wall(thing, support, around):
        return Verdict.WALL_PART
    # From above, over a table, the whole of a thing is seen, and how little it rises is sure.
    least = 1.1 if support.is_table and _is_from_above(thing, around) else 2.0
    if thing.top < least * (limits.slab + settings.noise * thing.distance**2):
        return Verdict.FLAT
    return Verdict.OBJECT if thing.stands else Verdict.FLOATING


def _fits(thing: Thing, around: Surroundings) -> bool:
    """Tell whether a thing is no larger than objects are."""
    limits = around.supports[thing.support].settings
    if hypot(*thing.size) <= limits.max_size and hypot(*thing.size[:2]) <= limits.max_width:
        return True
    # What is wider than objects mostly are must be known to carry nothing.
    if not any(_share_in(lid, thing) > MIN_UNDER_LID for lid in around.lids):
        return False
    return _least_across(thing, around) <= limits.max_size


def _least_across(thing: Thing, around: Surroundings, *, n_headings: int = 10) -> float:
    """Return the metres across the smallest upright box around a thing, however it is turned."""
    axes = horizontal_axes(around.supports[thing.support].plane.normal)
    places = around.points.xyz_at(thing.members) @ np.stack(axes, axis=1).astype(np.float32)
    across = []
    for heading in np.pi / 2 * np.arange(n_headings) / n_headings:
        along = places @ np.array([np.cos(heading), np.sin(heading)], np.float32)
        aside = places @ np.array([-np.sin(heading), np.cos(heading)], np.float32)
        lengths = [float(np.ptp(ends(values, 0.01))) for values in (along, aside)]
        across.append(hypot(*lengths, thing.size[2]))
    return min(across)


def _is_from_above(thing: Thing, around: Surroundings, *, min_cosine: float = 0.82) -> bool:
    """Tell whether the camera looks down on a thing within 35° of straight down."""
    up = around.supports[thing.support].plane.normal
    cosine: float = _mean_cosine(around.points.xyz.reshape(-1, 3), thing.members, -up)
    return cosine > min_cosine


@njit(cache=True, nogil=True, error_model="numpy")
def _mean_cosine(xyz: Array, where: Array, direction: Array) -> float:
    """Return the cosine between a (3,) unit vector and the mean of the points at (n,) places."""
    x, y, z = 0.0, 0.0, 0.0
    for point in where:
        x, y, z = x + xyz[point, 0], y + xyz[point, 1], z + xyz[point, 2]
    along = x * direction[0] + y * direction[1] + z * direction[2]
    return float(along / np.sqrt(x * x + y * y + z * z))


def _is_part_of_table(table: Support, thing: Thing) -> bool:
    """Tell whether a thing on the floor is a seat's cushion or arm, or a table's leg or apron.

    Those end at the table's top, or are hidden above; the map may know only a part of the top.
    """
    if table.extent is None or table.skirt is None:
        return False
    share = _share_in(table.skirt, thing)
    if not table.kind.carries_objects:
        return share > 0.7 or _share_in(table.extent, thing) > 0.03
    if share <= 0.2:
        return False
    top = ends(table.heights.take(thing.members), 0.02)[1]
    return abs(top) < 0.05 or (share > 0.7 and -0.5 < top < 0.05)


def _share_in(mask: Mask, thing: Thing) -> float:
    return float(_count_in(mask, thing.members)) / len(thing.members)


@njit(cache=True, nogil=True, error_model="numpy")
def _count_in(mask: Array, where: Array) -> int:
    """Count the flat indices where a (h, w) mask is True."""
    flat, n_in = mask.ravel(), 0
    for point in where:
        n_in += flat[point]
    return n_in


def _is_part_of_wall(thing: Thing, support: Support, around: Surroundings) -> bool:
    """Tell whether a thing hangs on a wall, or is round its corner.

    On the floor nothing stands as close to a wall as a radiator, or a curtain.
    """
    n, points = len(thing.members), around.points
    reach = points.steps(CREASE_PX)
    counts = around.faces.count_sides(points, thing.members, around.settings.wall_gap)
    for wall, (n_straight, n_behind, n_close, n_near) in zip(
        around.walls, counts.tolist(), strict=True
    ):
        if 2 * n_straight > n:
            if 2 * n_close > n:
                return True
            # Seen through a window, not through a door.
            is_behind = thing.bottom > 0.3 and 2 * n_behind > n
            if not support.is_table and (is_behind or n_near >= n - int(0.05 * n)):
                return True
        # The other face lies behind.
        is_other = 2 * n_behind >= n and wall.inliers.any()
        if is_other and _turns_corner(points.depth, thing.members, wall.inliers, reach):
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _turns_corner(depth: Array, members: Array, inliers: Array, reach: int) -> bool:
    """Tell whether a cluster is the other face of a wall, round a convex corner.

    It lies behind the wall's plane, and in most of its rows goes over into the wall sideways,
    without a step. Together they are larger than any object. What stands before a wall meets
    it in a concave corner and stays out of this.

    depth, inliers: (h, w), of the points and of the wall. members: (n,) flat indices.
    reach: cells over the crease, where no normal is known.
    """
    height, width = depth.shape
    first, last = np.full(height, width), np.full(height, -1)
    for point in members:
        v, u = point // width, point % width
        first[v], last[v] = min(first[v], u), max(last[v], u)
    n_rows, n_before, n_beyond = 0, 0, 0
    for v in range(height):
        if last[v] >= 0:
            left, right = max(first[v] - reach, 0), min(last[v] + reach, width - 1)
            n_rows += 1
            n_before += inliers[v, left] and abs(depth[v, left] - depth[v, first[v]]) < 0.10
            n_beyond += inliers[v, right] and abs(depth[v, right] - depth[v, last[v]]) < 0.10
    return 2 * max(n_before, n_beyond) > n_rows
