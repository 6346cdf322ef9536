"""The supports of one frame: which horizontal planes are floor or table, and how far they reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import (
    Mask,
    Plane,
    find_supports,
    noise_band,
)
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.ranks import median
from curiosight.teacher.settings import SegmentationSettings, SupportSettings
from curiosight.teacher.supports.footprint import REACH_PX, above_footprint, largest_piece
from curiosight.teacher.supports.frame_tops import tops_in_frame
from curiosight.teacher.supports.table_map import MARGIN, MAX_CORE
from curiosight.teacher.supports.tops import Kind

Array = npt.NDArray[Any]
Scene = Literal["floor", "table"]

FLOOR = "floor"
# Half the thickness of a plane in the fits, beside the sensor's noise.
PLANE_BAND = 0.008
# Supports within this height (metres) are one; pose drift and tilt stay below it.
SAME_HEIGHT = 0.10
# Square metres in view of the lowest support, unless it is the largest.
MIN_LOWEST_AREA = 0.25
# Legs and aprons stand no farther from what is seen of a table's top, metres.
SKIRT = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """A plane that objects stand on, with the thresholds for what stands on it.

    heights: (h, w) metres of the points over the plane.
    extent: (h, w) bool, what is straight above or below a table; None for a floor.
    core: the part of the extent where the table certainly is; None for a table that only this
        frame knows. skirt: the extent and what is close beside it; None for a floor.
    kind: of a table.
    """

    plane: Plane
    settings: SupportSettings
    heights: Array
    extent: Mask | None = None
    core: Mask | None = None
    skirt: Mask | None = None
    kind: Kind = Kind.TABLE

    @property
    def is_table(self) -> bool:
        return self.extent is not None

    @property
    def name(self) -> str:
        """What it is, in words."""
        return self.kind.value if self.is_table else FLOOR


@dataclass(frozen=True, slots=True, eq=False)
class KnownTable:
    """A table of the recording, as a frame's camera has it.

    offset: metres that its top is below the camera. inset: (h, w) metres that points lie inside
    its outline, seen from above. core, kind: see `Table`.
    """

    offset: float
    inset: Array
    core: float = MAX_CORE
    kind: Kind = Kind.TABLE


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """A plane and its height over the camera in metres, where it was seen."""

    plane: Plane
    height: float


def choose_supports(
    points: Points,
    up: Array,
    settings: SegmentationSettings,
    *,
    scene: Scene,
    camera_height: float | None = None,
    known_tables: Sequence[KnownTable] = (),
) -> list[Support]:
    """Return the supports in view, lowest first, and lids of things; empty when there is none.

    scene: what the lowest support is.
    camera_height: metres over the floor where the recording tells it: then the floor is
        known even where it is hidden, and nothing below it is a support.
    known_tables: are supports even where little or nothing of their tops is in view.
    """
    planes = find_planes(points, up, settings)
    if camera_height is None:
        if not planes:
            return []
        lowest = max(planes[:1] + _large(points, planes, settings), key=lambda p: p.offset)
        above = [plane for plane in planes if plane.offset < lowest.offset - SAME_HEIGHT]
        tops = tops_in_frame(points, lowest, above, settings)
        if scene == "table":
            first = _table(points, lowest, Kind.TABLE, settings)
        else:
            first = Support(lowest, settings.floor, lowest.distances(points))
        return [first] + [_table(points, plane, kind, settings) for plane, kind in tops]
    levels = [_Level(plane, _height(points, plane.inliers, up)) for plane in planes]
    everywhere = np.ones(points.depth.shape, np.bool_)
    floor = _plane_at(points, up, levels, camera_height, settings.noise, SAME_HEIGHT, everywhere)
    seen = [(table, table.inset > -MARGIN) for table in known_tables]
    known = [
        _known_support(points, up, levels, table, extent, settings)
        for table, extent in seen
        if np.count_nonzero(extent) >= 50
    ]
    taken = [table.extent for table in known if table.extent is not None]
    above = [plane for plane in planes if plane.offset < floor.offset - SAME_HEIGHT]
    beside = [_beside(plane, taken) for plane in above]
    tops = tops_in_frame(points, floor, beside, settings)
    new = [_table(points, plane, kind, settings) for plane, kind in tops]
    tables_in_view = sorted([*known, *new], key=lambda support: -support.plane.offset)
    return [Support(floor, settings.floor, floor.distances(points)), *tables_in_view]


def _table(points: Points, plane: Plane, kind: Kind, settings: SegmentationSettings) -> Support:
    heights = plane.distances(points)
    extent, skirt = above_footprint(points, plane, (MARGIN, SKIRT))
    return Support(plane, settings.table, heights, extent, skirt=skirt, kind=kind)


def _known_support(
    points: Points,
    up: Array,
    levels: list[_Level],
    table: KnownTable,
    extent: Mask,
    settings: SegmentationSettings,
) -> Support:
    """Return a known table as this frame shows it: where it shows the top, that is sharper.

    extent: (h, w) bool, where it is by the table's outline.
    """
    core = table.inset > table.core
    plane = _plane_at(points, up, levels, table.offset, settings.noise, 0.06, extent)
    if np.count_nonzero(plane.inliers & extent) >= 50:
        (shown,) = above_footprint(points, plane, (MARGIN,))
        if np.count_nonzero(plane.inliers & extent & shown) >= 50:
            extent, core = extent | shown, core | shown
    # A sofa's arms are wider than the board of a table is beyond its legs.
    skirt = table.inset > (-SKIRT if table.kind.carries_objects else -0.25)
    heights = plane.distances(points)
    return Support(plane, settings.table, heights, extent, core, skirt, table.kind)


def _beside(plane: Plane, taken: list[Mask]) -> Plane:
    """Return the part of a plane that is in no extent of something known."""
    inliers = plane.inliers.copy()
    for extent in taken:
        inliers &= ~extent
    return replace(plane, inliers=inliers)


def find_planes(points: Points, up: Array, settings: SegmentationSettings) -> list[Plane]:
    """Return the horizontal planes within range, whatever they are, largest first."""
    band = noise_band(points.depth, PLANE_BAND, settings.noise)
    return find_supports(points, up, band=band, max_range=settings.max_range)


def share_below(points: Points, plane: Plane) -> float:
    """Return the share of the points with a reading that lie clearly below a plane."""
    # A point without a reading compares false.
    is_below = -plane.distances(points) > noise_band(points.depth, 0.10, 0.02)
    n_seen = np.count_nonzero(np.isfinite(points.depth))
    return float(np.count_nonzero(is_below)) / n_seen


def _large(points: Points, planes: list[Plane], settings: SegmentationSettings) -> list[Plane]:
    """Return the planes that are large enough to be a floor, or the table that all stands on."""
    reach = points.steps(REACH_PX)
    sizes = [points.area[largest_piece(plane.inliers, reach)].sum() for plane in planes]
    return [p for p, size in zip(planes, sizes, strict=True) if size >= MIN_LOWEST_AREA]


def _height(points: Points, inliers: Mask, up: Array) -> float:
    """Return a plane's height over the camera where it was seen: a tilt adds up elsewhere."""
    some = np.flatnonzero(inliers)[::8]
    return median(points.xyz_at(some) @ up.astype(np.float32))


def _within(points: Points, plane: Plane, extent: Mask, up: Array) -> Plane:
    """Return the part of a plane in an extent; level where the plane is mostly elsewhere."""
    inside = plane.inliers & extent
    if np.count_nonzero(inside) > 0.5 * np.count_nonzero(plane.inliers):
        return plane
    return Plane(up, -_height(points, inside, up), inside)


def _plane_at(
    points: Points,
    up: Array,
    levels: list[_Level],
    offset: float,
    noise: float,
    tolerance: float,
    extent: Mask,
) -> Plane:
    """Return the plane at a known height: as seen, else through the few level points near it.

    levels: largest first. tolerance: metres that a seen plane may be off.
    extent: (h, w) bool, where to look.
    """
    for level in levels:
        is_there = abs(level.height + offset) < tolerance
        if is_there and np.count_nonzero(level.plane.inliers & extent) >= 50:
            return _within(points, level.plane, extent, up)
    plane, is_level = np.array([*up, offset], np.float32), np.empty(extent.shape, np.bool_)
    x, y, normals = points.x, points.y, points.normals
    _mark_level(points.depth, x, y, normals, extent, plane, noise, is_level)
    where = np.flatnonzero(is_level)
    if len(where) >= 30:
        offset = -median(points.xyz_at(where) @ plane[:3])
    return Plane(up, offset, is_level)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_level(
    depth: Array,
    x: Array,
    y: Array,
    normals: Array,
    extent: Array,
    plane: Array,
    noise: float,
    is_level: Array,
) -> None:
    """Set (h, w) `is_level`: what is in an extent, near a level plane, and faces as it does.

    depth, x, y, normals: see `Points`. plane: (4,) normal and offset.
    """
    a, b, c, offset = plane
    base, slope, least = np.float32(0.06), np.float32(noise), np.float32(0.9)
    for v in range(len(y)):
        in_row = y[v] * b + c
        for u in range(len(x)):
            z = depth[v, u]
            height = z * (x[u] * a + in_row) + offset
            is_level[v, u] = extent[v, u] & (abs(height) < base + slope * (z * z))
        for u in range(len(x)):
            if is_level[v, u]:
                cosine = normals[v, u, 0] * a + normals[v, u, 1] * b + normals[v, u, 2] * c
                is_level[v, u] = cosine > least
