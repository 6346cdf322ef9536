"""One vertical plane of a frame: its fit, and the stretch of it that is one face."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.plane_fit import fit_plane
from curiosight.teacher.cloud.planes import Mask, Surface, coordinates_on, mask_of
from curiosight.teacher.cloud.points import Points, rows_at
from curiosight.teacher.cloud.ranks import ends
from curiosight.teacher.cloud.up import across
from curiosight.teacher.walls.openings import find_openings

Array = npt.NDArray[Any]

# Pieces of one wall are no farther apart than this, metres,
MAX_GAP = 0.45
# and no farther than this where the camera sees through between them.
MAX_OPENING = 0.22
# Less than this of a cell, square metres, does not fill it.
MIN_FILLED = 0.0014
# Side of the cells in which a face is looked for along its plane, metres.
CELL = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """Points on one vertical plane, without a wide gap; the rest as in `Wall`."""

    surface: Surface
    normal: Array
    offset: float
    axes: Array

    @property
    def places(self) -> Array:
        """(n, 2) metres along the axes."""
        places: Array = self.surface.xyz @ self.axes.astype(np.float32)
        return places

    def below_top(self, is_over_table: Mask, *, margin: float = 0.05) -> Self:
        """Return the face with points over a table only as high as it is elsewhere, if it is.

        is_over_table: (n,) bool.
        """
        height = self.places[:, 1]
        elsewhere = height[~is_over_table]
        if len(elsewhere) < 50:
            return self
        is_below = ~is_over_table | (height < ends(elsewhere, 0.02)[1] + margin)
        return replace(self, surface=self.surface.at(np.flatnonzero(is_below)))

    def diagonal(self) -> float:
        """Return the visible diagonal in metres, without the outermost 1 %."""
        if len(self.surface.where) == 0:
            return 0.0
        low, high = np.transpose([ends(place) for place in self.places.T])
        return float(np.linalg.norm(high - low))


def fit_face(
    points: Points, rest: Surface, up: Array, normal: Array, offset: float, *, band: Array
) -> tuple[Face | None, Mask]:
    """Fit a vertical plane near a first guess, and cut it to its longest run.

    band: (h, w) metres, see `noise_band`.
    Return the face, None where there is none, and which of the points are used up.
    """
    near = np.flatnonzero(rest.gap(normal, offset) < 0.08 + rest.band)
    near = near[rows_at(rest.normals, near) @ normal.astype(np.float32) > 0.85]
    fit = fit_plane(rest.xyz, rest.band, near, normal, offset, margin=0.02)
    if fit is None or abs(fit[0] @ up) > 0.15:
        return None, mask_of(near, rest.area.shape)
    gap = rest.gap(*fit)
    near = near[gap.take(near) < rest.band.take(near) + 0.02]
    plane = Face(rest.at(near), *fit, _axes_of(fit[0], up))
    along = rest.xyz @ plane.axes[:, 0].astype(np.float32)
    first, last = _longest_run(points, plane, band)
    in_run = (along >= first) & (along <= last)
    face = replace(plane, surface=plane.surface.at(np.flatnonzero(in_run.take(near))))
    return face, in_run & (gap < rest.band + 0.03)


def _axes_of(normal: Array, up: Array) -> Array:
    """Return the (3, 2) horizontal and upward directions of a wall."""
    return np.stack([across(up, normal), up], axis=1)


def _longest_run(points: Points, face: Face, band: Array) -> tuple[float, float]:
    """Return the ends along a face of the stretch without a gap that has the most area.

    What stands in the plane of a wall somewhere else is no part of it.
    """
    along, up = face.places.T
    low = float(along.min())
    index = ((along - low) / CELL).astype(np.int64)
    area = np.bincount(index, face.surface.area)
    # A few points stray into a gap.
    filled = np.flatnonzero(area > min(MIN_FILLED, area.max() / 2))
    steps = CELL * np.diff(filled)
    is_gap = steps > MAX_GAP
    if (~is_gap & (steps > MAX_OPENING)).any():
        to_plane = coordinates_on(face.axes, face.normal, face.offset)
        window = low, *ends(up)
        is_open = find_openings(points, band, to_plane, window, len(area), cell=CELL)
        is_open[filled] = False
        is_gap |= CELL * np.diff(np.cumsum(is_open)[filled]) > MAX_OPENING
    run_of_cell = np.full(len(area), -1)
    run_of_cell[filled] = np.cumsum([0, *is_gap])
    run = run_of_cell[index]
    chosen = along[run == np.argmax(np.bincount(run_of_cell[filled], area[filled]))]
    return float(chosen.min()), float(chosen.max())
