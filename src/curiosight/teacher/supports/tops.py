"""Support or thing: what a level surface over the floor belongs to.

The paper's definition (sec. II-A): what stands free on the floor and is no larger than objects are
is an object, unless it carries some. Three things are looked at from above: what rises from the
surface, how wide all is that it belongs to, and how much of its surroundings was seen. What rises
inside its outline and ends there stands on it; what rises along its edge and goes on beyond is its
own back or arm. Where neither is told, it is doubtful: what seems to stand on it counts as such,
but the surface itself teaches nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.teacher.supports.ground import (
    CELL,
    Ground,
    Mask,
    area,
    closed,
    diagonal,
    grown,
    inset,
    pieces,
)

Array = npt.NDArray[Any]

# Heights of tops over the floor, metres.
MIN_HEIGHT, MAX_HEIGHT = 0.2, 1.3
# What rises so many metres over a top stands on it or is its own; what is higher than the last
# over the floor is a wall.
MIN_RISE, MAX_RISE, WALL_HEIGHT = 0.05, 0.5, 1.3
# Metres of a wall that are seen to be so high, and of a window in it, at least and at most.
MIN_WALL, MAX_WINDOW = 0.6, 2.5
# Share of a thing that is inside the outline of what it stands on, surely and perhaps, and its
# least area in m².
MIN_INSIDE, MAYBE_INSIDE, MIN_STANDING = 0.7, 0.5, 3 * CELL**2
# Share of the way from the edge to the middle of a top.
MIDDLE = 0.6
# What is lower than this is sat or lain on if its sides rise along so much of its edge, if it is
# so large (m²), or, at any height, if so much of it is covered: a shelf.
MAX_SEAT_HEIGHT, MIN_ENCLOSED, MIN_BED_AREA, MAX_COVERED = 0.62, 0.3, 1.5, 0.65
# Metres between a seat and its arm.
JOINT = 0.12
# Share of a container's edge with a side below, and of its top that one sees into.
MIN_CLOSED, MIN_HOLLOW = 0.7, 0.05
# Share of the surroundings that was seen of what is known to stand free.
MIN_SEEN_AROUND = 0.6
# Metres across a surface that is smaller is never taught as not salient: it may be a lid.
MIN_SURE = 0.7
# Metres across a high one that is no sill and no shelf's board, see `max_small_height`.
MIN_HIGH_WIDTH = 0.34
# What stands on a top hides some of it, and casts a shadow: gaps of half so many metres are closed.
WIDEST_GAP = 0.25


def near_walls(highest: Array) -> Mask:
    """(rows, columns) bool: the cells of a wall and beside it; highest: metres over the floor."""
    return grown(highest >= WALL_HEIGHT, 0.12)


def of_walls(highest: Array) -> Mask:
    """(rows, columns) bool: the cells of a wall, which goes on below its windows.

    highest: as in `near_walls`.
    """
    is_high = (highest >= WALL_HEIGHT).astype(np.uint8)
    lines = cv2.HoughLinesP(
        is_high,
        1.0,
        np.pi / 90,
        round(MIN_WALL / CELL),
        minLineLength=MIN_WALL / CELL,
        maxLineGap=MAX_WINDOW / CELL,
    )
    for line in [] if lines is None else lines.reshape(-1, 4).tolist():
        cv2.line(is_high, line[:2], line[2:], 1.0, thickness=3)
    return is_high > 0


class Kind(Enum):
    """What a level surface over the floor is.

    TABLE: carries things, or is larger than they are. FURNITURE: larger too, but what is on it is
    part of it. DOUBTFUL: may be either, or an object. BARE: furniture or an object, on which
    nothing stands. THING: the top of an object.
    """

    TABLE = "table"
    FURNITURE = "seat, bed or shelf"
    DOUBTFUL = "support or thing"
    BARE = "furniture or thing"
    THING = "thing"

    @property
    def carries_objects(self) -> bool:
        """Tell whether what is on it may be an object."""
        return self in (Kind.TABLE, Kind.DOUBTFUL)


@dataclass(frozen=True, slots=True, eq=False)
class TopView:
    """A level surface and what is around it, seen from above, on cells of side CELL.

    height: metres over the floor. top: (rows, columns) bool, its extent.
    highest: the highest point of each cell, metres over the floor; -inf = none.
    n_sides: how many points of each cell are at the middle of its height over the floor.
    n_rising: how many points of each cell are over the surface, see MIN_RISE.
    n_over_floor: how many are over the floor.
    is_seen: bool, any.
    max_small_height: see `SegmentationSettings`.
    blur: metres by which noise makes things wider on the cells.
    """

    height: float
    top: Mask
    highest: Array
    n_sides: Array
    n_rising: Array
    n_over_floor: Array
    is_seen: Mask
    max_small_height: float
    blur: float = 0.0

    def kind(self, max_size: float, seats: list[Mask]) -> Kind:
        """Return what the surface is.

        max_size: metres across the largest object. seats: what is known as furniture: what
        joins one and carries nothing is its arm or back.
        """
        standing, is_small = self.standing(), diagonal(self.top) < MIN_SURE
        is_narrow = is_small or 2 * np.max(inset(self.top)) < MIN_HIGH_WIDTH
        if self.height > self.max_small_height and is_narrow:
            return Kind.THING
        if is_small and self._is_container():
            return Kind.THING
        rests = self._is_rested_on(standing)
        if standing and not rests:
            return Kind.DOUBTFUL if is_small else Kind.TABLE
        rests |= any((grown(self.top, JOINT) & seat).any() for seat in seats)
        if np.hypot(diagonal(self.top), self.height) > max_size:
            return Kind.FURNITURE if rests else Kind.TABLE
        body = self.body()
        highest = float(np.max(self.highest[body], initial=self.height))
        if not rests and not is_small and self.standing(MAYBE_INSIDE):
            return Kind.DOUBTFUL
        is_in_size = np.hypot(diagonal(body), highest) <= max_size + self.blur
        if is_small or (is_in_size and self._share_seen_around(body) >= MIN_SEEN_AROUND):
            return Kind.THING
        return Kind.FURNITURE if rests else Kind.BARE

    def standing(self, min_inside: float = MIN_INSIDE) -> list[Mask]:
        """Return what stands on the surface: what rises inside its outline and ends there.

        min_inside: share of it that must; things hide some of what they stand on.
        The back of a chair does so too, but along much of the edge, and on a small seat away from
        the middle.
        """
        inside, depth = grown(self.top, CELL), inset(self.top)
        least = MIDDLE * np.max(depth) if diagonal(self.top) < MIN_SURE else -np.inf
        rising = (self.n_rising > 1) & grown(self.top, 0.2)
        return [
            piece
            for piece in pieces(rising)
            if area(piece) >= MIN_STANDING
            and np.mean(inside[piece]) >= min_inside
            and np.max(depth[piece]) >= least
            and self._share_along_edge(piece) <= MIN_ENCLOSED
        ]

    def body(self) -> Mask:
        """Return the extent of all that the surface belongs to, walls left out."""
        is_body = ((self.n_over_floor > 1) & ~near_walls(self.highest)) | self.top
        own = [piece for piece in pieces(is_body) if (piece & self.top).any()]
        return np.asarray(np.any(own, axis=0))

    def _is_rested_on(self, standing: list[Mask]) -> bool:
        """Tell a seat, a bed or a full shelf: what is on it is part of it, but what stands."""
        is_own = np.isfinite(self.highest)
        for piece in standing:
            is_own &= ~piece
        if np.mean((is_own & (self.n_rising > 0))[self.top]) > MAX_COVERED:
            return True
        if self.height > MAX_SEAT_HEIGHT or area(self.top) > MIN_BED_AREA:
            return self.height <= MAX_SEAT_HEIGHT
        rises = is_own & (self.highest > self.height + 0.08) & ~of_walls(self.highest)
        return self._share_along_edge(rises) > MIN_ENCLOSED

    def _is_container(self) -> bool:
        """Tell a bin from a stool: it has sides all around, and one sees into it, or it is full."""
        if self._share_along_edge(self.n_sides > 0) < MIN_CLOSED:
            return False
        is_hollow = self.highest[self.top] < self.height - MIN_RISE
        is_covered = self.n_rising[self.top] > 0
        return bool(np.mean(is_hollow) > MIN_HOLLOW or np.mean(is_covered) > MAX_COVERED)

    def _share_along_edge(self, cells: Mask) -> float:
        """Return along which share of the edge some cells run, on it or close outside."""
        inside = inset(self.top)
        near = cells & (inside > -0.14) & (inside <= CELL)
        return float(np.mean(grown(near, CELL)[(inside > 0) & (inside <= CELL)]))

    def _share_seen_around(self, body: Mask) -> float:
        ring = grown(body, 0.12) & ~body
        return float(np.mean(closed(self.is_seen, 0.04)[ring])) if ring.any() else 0.0


class SeenFromAbove:
    """What a recording, or a frame, shows over its floor, in which level surfaces are judged.

    ground: the map that is looked at. cells, heights: (n,) cell and metres over the floor of every
    point seen. band: (n,) metres that a point may be off, or one number.
    max_size: see `TopView.kind`. max_small_height, blur: see `TopView`.
    """

    def __init__(
        self,
        ground: Ground,
        cells: Array,
        heights: Array,
        *,
        max_size: float,
        max_small_height: float,
        band: Array | float = 0.0,
        blur: float = 0.0,
    ) -> None:
        self.highest = ground.highest(cells, heights)
        self.n_over_floor = ground.count(cells[heights > 0.10 + band])
        self._is_seen = ground.count(cells) > 0
        self._points = ground, cells, heights, band
        self._limits = max_size, max_small_height, blur
        self._larger: list[Mask] = []
        self._seats: list[Mask] = []

    def judge(self, height: float, top: Mask, over: Array) -> Kind | None:
        """Return what a surface is, the largest first.

        None = it is below or over most of another, and belongs to it or to what stands on it.

        height: metres over the floor. top: (rows, columns) bool. over: (n,) metres of the points
        over the surface.
        """
        if any(np.mean(larger[top]) > 0.5 for larger in self._larger):
            return None
        (ground, cells, heights, band), (max_size, max_small_height, blur) = (
            self._points,
            self._limits,
        )
        rises = (over > MIN_RISE + band) & (over < MAX_RISE)
        is_side = (heights > 0.3 * height) & (heights < 0.8 * height)
        view = TopView(
            height,
            top,
            self.highest,
            ground.count(cells[is_side]),
            ground.count(cells[rises]),
            self.n_over_floor,
            self._is_seen,
            max_small_height,
            blur,
        )
        kind = view.kind(max_size, self._seats)
        self._larger.append(top)
        if kind is Kind.FURNITURE:
            self._seats.append(top)
        return kind
