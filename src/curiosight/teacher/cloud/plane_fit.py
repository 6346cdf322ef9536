"""Fit of a plane to points near a first guess, by least squares in inverse depth.

1/z = n_x x/z + n_y y/z + n_z on a plane n·p = 1, so the fit is linear; and the noise of 1/z is
the same everywhere (`points.py`), so no point counts more than another.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]
# Added to the diagonal of a fit's sums, so that points on a line can be fitted too.
TINY = 1e-9


def fit_plane(
    xyz: Array,
    band: Array,
    where: Array,
    normal: Array,
    offset: float,
    *,
    margin: float = 0.0,
    max_points: int = 8000,
) -> tuple[Array, float] | None:
    """Fit a plane to points, thrice, within 3, 1.5 and 1 times their band of the last fit.

    xyz: (m, 3) and band: (m,) float32 metres, of which (n,) `where` are fitted; of more than
    `max_points`, evenly spaced ones. margin: metres, added to the band.
    normal, offset: where to begin; the side is kept.
    Return normal and offset; None when fewer than 50 points remain.
    """
    plane = np.array([*normal, offset])
    stride = 1 + len(where) // max_points
    if not _refine_plane(xyz, band, where, stride, margin, plane):
        return None
    return plane[:3], float(plane[3])


@njit(cache=True, nogil=True, error_model="numpy")
def _refine_plane(
    xyz: Array, band: Array, where: Array, stride: int, margin: float, plane: Array
) -> bool:
    """Improve (4,) `plane`, normal and offset, as `fit_plane` says; False = too few points."""
    sums = np.empty((3, 4))
    for slack in (3.0, 1.5, 1.0):
        _sum_rays(xyz, band, where, stride, margin, slack, plane, sums)
        if sums[2, 2] * stride < 50:
            return False
        x, y, z = _solve(sums)
        length = np.sqrt(x * x + y * y + z * z)
        if x * plane[0] + y * plane[1] + z * plane[2] < 0:
            length = -length
        plane[0], plane[1], plane[2], plane[3] = x / length, y / length, z / length, -1 / length
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_rays(
    xyz: Array,
    band: Array,
    where: Array,
    stride: int,
    margin: float,
    slack: float,
    plane: Array,
    sums: Array,
) -> None:
    """Set (3, 4) `sums` to those of (x/z, y/z, 1) times (x/z, y/z, 1, 1/z) near a plane.

    Near is within `slack` times band and margin. What is below the diagonal is not set.
    """
    a, b, c = np.float32(plane[0]), np.float32(plane[1]), np.float32(plane[2])
    d, factor, wider = np.float32(plane[3]), np.float32(slack), np.float32(margin)
    xx, xy, x1, xr, yy, y1, yr, n, r1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for place in range(0, len(where), stride):
        point = where[place]
        x, y, z = xyz[point, 0], xyz[point, 1], xyz[point, 2]
        if abs(x * a + y * b + z * c + d) < factor * (band[point] + wider):
            r = 1 / np.float64(z)
            x_ray, y_ray = x * r, y * r
            xx, xy, x1, xr = xx + x_ray * x_ray, xy + x_ray * y_ray, x1 + x_ray, xr + x_ray * r
            yy, y1, yr = yy + y_ray * y_ray, y1 + y_ray, yr + y_ray * r
            n, r1 = n + 1, r1 + r
    sums[0, 0], sums[0, 1], sums[0, 2], sums[0, 3] = xx, xy, x1, xr
    sums[1, 1], sums[1, 2], sums[1, 3], sums[2, 2], sums[2, 3] = yy, y1, yr, n, r1


@njit(cache=True, nogil=True, error_model="numpy")
def _solve(sums: Array) -> tuple[float, float, float]:
    """Return the x of A x = b, with A and b the columns of (3, 4) `sums`, A symmetric."""
    a, d, f = sums[0, 0] + TINY, sums[1, 1] + TINY, sums[2, 2] + TINY
    b, c, e = sums[0, 1], sums[0, 2], sums[1, 2]
    r, s, t = sums[0, 3], sums[1, 3], sums[2, 3]
    # The inverse is the matrix of the cofactors divided by the determinant.
    c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
    c11, c12, c22 = a * f - c * c, b * c - a * e, a * d - b * b
    per_determinant = 1 / (a * c00 + b * c01 + c * c02)
    x = (c00 * r + c01 * s + c02 * t) * per_determinant
    y = (c01 * r + c11 * s + c12 * t) * per_determinant
    z = (c02 * r + c12 * s + c22 * t) * per_determinant
    return x, y, z
