"""How patches of smooth surface meet: what tells whether two are of one object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.cloud.planes import noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.things.patches import REACH_PX, TOLERANCE, in_front

Array = npt.NDArray[Any]
# Columns of `Patches.borders`.
TOUCHING, SEEN, CONCAVE, NEARER = range(4)


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Patches of a frame, and how every two of them meet.

    number: (h, w) int32 of the patch of each point, from 1; 0 = none.
    centres: (n, 2) row and column, places: (n, 3) metres, of the middle of each.
    normals: (n, 3) mean unit vectors; NaN = not known.
    bends: (n,) mean curvature in 1/m along rows and columns; below 0 = hollow.
    tops: (n,) metres over the support.
    borders: (n, n, 4) pairs of neighbours, one in the first patch and one in the second: all;
        those that are told convex or concave; the concave; those nearer in the first.
    """

    number: Array
    points: Points
    centres: Array
    places: Array
    normals: Array
    bends: Array
    tops: Array
    borders: Array

    @classmethod
    def measure(cls, groups: Groups, points: Points, heights: Array, noise: float) -> Self:
        """Measure the patches that have these points.

        heights: (n,) metres of the groups' members. noise: of inverse depth, 1/m.
        """
        n = len(groups)
        number = np.zeros(points.depth.shape, np.int32)
        number.ravel()[groups.members] = np.repeat(np.arange(1, n + 1), groups.sizes)
        sums, borders = np.zeros((n, 10)), np.zeros((n, n, 4), np.int32)
        surface = points.xyz.reshape(-1, 3), points.normals.reshape(-1, 3)
        reach, tolerance = points.steps(REACH_PX), noise_band(points.depth, TOLERANCE, noise)
        _sum_patches(number, *surface, reach, sums)
        _count_borders(number, *surface, tolerance, reach, borders)
        middles = sums[:, :5] / groups.sizes[:, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            normals = sums[:, 5:8] / np.linalg.norm(sums[:, 5:8], axis=1, keepdims=True)
            bends = sums[:, 8] / sums[:, 9]
        tops = groups.ends(heights[:, None], [(0, 0.03)])[:, 0, 1]
        return cls(number, points, middles[:, :2], middles[:, 2:], normals, bends, tops, borders)

    def meet_convexly(self, *, max_concave: float = 0.5, min_px: float = 12) -> Array:
        """(n, n) bool: have a border, not more than a share of it concave or a step.

        min_px: length of the border, in pixels of a 640x480 image.
        """
        seen, concave = self.borders[..., SEEN], self.borders[..., CONCAVE]
        meet: Array = (seen >= self.points.steps(min_px)) & (concave <= max_concave * seen)
        return meet

    def are_inside(
        self, *, max_bend: float = -4, min_nearer: float = 0.3, max_step: float = 0.03
    ) -> Array:
        """(n, n) bool: the second is hollow, behind the first, and reaches up to the same rim.

        max_bend: 1/m, of the hollow one. min_nearer: share of the border where the first hides
        the second. max_step: metres between their tops.
        """
        seen, nearer = self.borders[..., SEEN], self.borders[..., NEARER]
        is_before = (seen > 0) & (nearer > min_nearer * seen)
        is_level = np.abs(self.tops[:, None] - self.tops) < max_step
        inside: Array = is_before & is_level & (self.bends < max_bend)
        return inside

    def go_on_behind(self, *, max_angle_deg: float = 8, max_step: float = 0.012) -> Array:
        """(n, n) bool: surfaces that continue each other where something nearer hides them.

        max_angle_deg: between their normals. max_step: metres between them.
        """
        alike = self.normals @ self.normals.T > np.cos(np.radians(max_angle_deg))
        heights = self.normals @ self.places.T
        steps = np.abs(heights - np.diagonal(heights)[:, None])
        alike &= np.maximum(steps, steps.T) < max_step
        alike &= self.borders[..., TOUCHING] == 0
        order = np.arange(len(alike))
        behind: Array = alike & (order[:, None] < order)
        for one, other in np.argwhere(behind):
            behind[one, other] = self._is_hidden_between(one, other)
        return behind

    def _is_hidden_between(self, one: int, other: int, *, min_share: float = 0.8) -> bool:
        """Tell whether most of the straight line between two patches' middles is hidden."""
        begin, end = self.centres[one], self.centres[other]
        share = np.linspace(0, 1, 2 + int(np.abs(end - begin).max()))[:, None]
        v, u = np.rint(begin + share * (end - begin)).astype(int).T
        is_between = ~np.isin(self.number[v, u], (one + 1, other + 1))
        # Along a line in the image a surface is even in inverse depth.
        inverse = 1 / self.places[[one, other], 2]
        surface = 1 / (inverse[0] + share[:, 0] * (inverse[1] - inverse[0]))
        is_hidden = ~(self.points.depth[v, u] > surface - 0.01) & is_between
        n_between = np.count_nonzero(is_between)
        return bool(n_between and np.count_nonzero(is_hidden) >= min_share * n_between)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_patches(number: Array, xyz: Array, normals: Array, reach: int, sums: Array) -> None:
    """Add up row, column, place, normal, curvature, and how often the last is known.

    number: (h, w). xyz, normals: (h * w, 3). reach: cells over which the curvature is taken.
    sums: (n, 10).
    """
    height, width = number.shape
    for v in range(height):
        for u in range(width):
            patch, here = number[v, u] - 1, v * width + u
            if patch < 0:
                continue
            sums[patch, 0] += v
            sums[patch, 1] += u
            for axis in range(3):
                sums[patch, 2 + axis] += xyz[here, axis]
                if normals[here, axis] == normals[here, axis]:
                    sums[patch, 5 + axis] += normals[here, axis]
            for dv, du in ((0, reach), (reach, 0)):
                if v + dv >= height or u + du >= width or number[v + dv, u + du] != patch + 1:
                    continue
                there, bend, square = here + dv * width + du, 0.0, 0.0
                for axis in range(3):
                    way = xyz[there, axis] - xyz[here, axis]
                    bend += (normals[there, axis] - normals[here, axis]) * way
                    square += way * way
                if bend == bend:
                    sums[patch, 8] += bend / square
                    sums[patch, 9] += 1


@njit(cache=True, nogil=True, error_model="numpy")
def _count_borders(
    number: Array, xyz: Array, normals: Array, tolerance: Array, reach: int, borders: Array
) -> None:
    """Count the pairs of neighbours that are in two patches, see `Patches.borders`.

    Two points tell convex from concave, each up to `reach` cells on its side of the border.
    number, tolerance: (h, w). xyz, normals: (h * w, 3).
    """
    height, width = number.shape
    for v in range(height):
        for u in range(width):
            for dv, du in ((0, 1), (1, 0)):
                if number[v, u] == 0 or v + dv >= height or u + du >= width:
                    continue
                one, other = number[v, u] - 1, number[v + dv, u + du] - 1
                if other < 0 or one == other:
                    continue
                borders[one, other, TOUCHING] += 1
                borders[other, one, TOUCHING] += 1
                first = _walk(number, normals, v, u, -dv, -du, reach)
                second = _walk(number, normals, v + dv, u + du, dv, du, reach)
                if first < 0 or second < 0:
                    continue
                is_concave = in_front(xyz, normals, first, second) > tolerance[v, u]
                step = xyz[(v + dv) * width + u + du, 2] - xyz[v * width + u, 2]
                for here, there, nearer in ((one, other, step), (other, one, -step)):
                    borders[here, there, SEEN] += 1
                    borders[here, there, CONCAVE] += is_concave
                    borders[here, there, NEARER] += nearer > 0.01


@njit(cache=True, nogil=True, error_model="numpy")
def _walk(number: Array, normals: Array, v: int, u: int, dv: int, du: int, reach: int) -> int:
    """Return the farthest point in a direction that is in the same patch and has a normal.

    Return its flat index, -1 = none.
    """
    height, width = number.shape
    for steps in range(reach, -1, -1):
        row, column = v + steps * dv, u + steps * du
        if row < 0 or column < 0 or row >= height or column >= width:
            continue
        there = row * width + column
        if number[row, column] == number[v, u] and normals[there, 0] == normals[there, 0]:
            return int(there)
    return -1
