"""Points and normals against plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.ndimage import distance_transform_cdt

from curiosight.segmentation.points import (
    _distance_to_edge,
    _fit_normals,
    cell_of_pixel,
    observe_points,
)
from room import kinect
from scenes import kinect_noise, see

CAMERA = kinect(160, 120)


def plane_depth(normal: npt.NDArray[np.float64], offset: float) -> npt.NDArray[np.float32]:
    """Depth of normal·p = offset in every pixel of CAMERA."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    return np.asarray(offset / (normal[0] * x + normal[1] * y + normal[2]), np.float32)


def edges_by_loop(inverse: npt.NDArray[np.float32], max_bend: float) -> npt.NDArray[np.bool_]:
    height, width = inverse.shape
    edges = ~np.isfinite(inverse)
    for v, u in np.argwhere(~edges):
        limit = max_bend + 0.004 * inverse[v, u] ** 2
        if 0 < u < width - 1:
            bend = inverse[v, u - 1] + inverse[v, u + 1] - 2 * inverse[v, u]
            edges[v, u] |= abs(bend) > limit
        if 0 < v < height - 1:
            bend = inverse[v - 1, u] + inverse[v + 1, u] - 2 * inverse[v, u]
            edges[v, u] |= abs(bend) > limit
    return edges


def test_points_lie_on_their_rays_and_on_the_plane() -> None:
    normal = np.array([0.2, 0.6, 0.77])
    normal /= np.linalg.norm(normal)
    points = observe_points(plane_depth(normal, 1.5), CAMERA)
    assert np.abs(points.xyz @ normal - 1.5).max() < 1e-4
    u = points.xyz[..., 0] / points.depth * CAMERA.fx + CAMERA.cx
    np.testing.assert_allclose(u, np.broadcast_to(np.arange(0, 160, 2), u.shape), atol=1e-3)


@pytest.mark.parametrize("tilt", [(0.0, 0.0, 1.0), (0.3, 0.5, 0.8), (-0.5, 0.1, 0.6)])
def test_normals_of_an_exact_plane_are_its_own(tilt: tuple[float, float, float]) -> None:
    normal = np.array(tilt) / np.linalg.norm(tilt)
    points = observe_points(plane_depth(normal, 1.2), CAMERA)
    known = np.isfinite(points.normals[..., 0])
    assert known.mean() > 0.8
    assert (points.normals[known] @ -normal).min() > 0.9999


def test_area_of_a_plane_adds_up_to_its_true_size() -> None:
    depth = plane_depth(np.array([0.0, 0.0, 1.0]), 2.0)
    points = observe_points(depth, CAMERA)
    inner = points.area > 0
    per_pixel = 4 * 2.0**2 / (CAMERA.fx * CAMERA.fy)
    # Seen aslant at the image's rim, the pixel covers more than straight ahead, never less.
    assert points.area[inner].min() == pytest.approx(per_pixel, rel=1e-3)
    assert (points.area[~inner] == 0).all()


def test_normals_equal_a_least_squares_fit_in_each_window() -> None:
    rng = np.random.default_rng(0)
    normal = np.array([0.1, 0.5, 0.86])
    depth = kinect_noise(plane_depth(normal, 1.4), rng)
    depth[40:44, 60:66] = np.nan
    inverse = (1 / depth).astype(np.float32)
    v_axis = ((np.arange(120) - CAMERA.cy) / CAMERA.fy).astype(np.float32)
    u_axis = ((np.arange(160) - CAMERA.cx) / CAMERA.fx).astype(np.float32)
    to_edge = _distance_to_edge(inverse, 0.05, 5)
    normals = _fit_normals(inverse, u_axis, v_axis, to_edge)
    for v, u in rng.integers((0, 0), (120, 160), (60, 2)):
        r = to_edge[v, u] - 1
        if r < 1:
            assert np.isnan(normals[v, u]).all()
            continue
        y, x = np.meshgrid(v_axis[v - r : v + r + 1], u_axis[u - r : u + r + 1], indexing="ij")
        rows = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=1)
        fit, *_ = np.linalg.lstsq(rows, inverse[v - r : v + r + 1, u - r : u + r + 1].ravel())
        np.testing.assert_allclose(normals[v, u], -fit / np.linalg.norm(fit), atol=2e-4)


def test_noise_of_a_kinect_tilts_normals_by_few_degrees() -> None:
    normal = np.array([0.0, 0.6, 0.8])
    depth = kinect_noise(plane_depth(normal, 1.4), np.random.default_rng(1))
    normals = observe_points(depth, CAMERA).normals
    cosine = normals[np.isfinite(normals[..., 0])] @ -normal
    assert np.degrees(np.arccos(np.median(cosine))) < 5


def test_distance_to_edge_is_the_chessboard_distance() -> None:
    rng = np.random.default_rng(2)
    depth = see()[0].depth
    assert depth is not None
    depth = depth[::4, ::4].copy()
    depth[rng.random(depth.shape) < 0.01] = np.nan
    inverse = (1 / depth).astype(np.float32)
    is_inside = ~edges_by_loop(inverse, 0.01)
    is_inside[[0, -1]] = False
    is_inside[:, [0, -1]] = False
    expected = np.minimum(distance_transform_cdt(is_inside, "chessboard"), 6)
    np.testing.assert_array_equal(_distance_to_edge(inverse, 0.01, 6), expected)


def test_holes_and_depth_steps_have_no_normal() -> None:
    depth = plane_depth(np.array([0.0, 0.0, 1.0]), 1.5)
    depth[:, 80:] = 2.0
    depth[20:30, 20:30] = np.nan
    points = observe_points(depth, CAMERA)
    assert np.isnan(points.normals[:, 39:41, 0]).all()
    assert np.isnan(points.normals[10:15, 10:15, 0]).all()
    assert np.isnan(points.xyz[10:15, 10:15]).all()


def test_pixels_take_the_cell_around_them_that_is_closest_in_depth() -> None:
    rng = np.random.default_rng(4)
    depth = rng.uniform(1, 2, (11, 14)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = np.nan
    coarse = np.ascontiguousarray(depth[::2, ::2])
    cells = cell_of_pixel(coarse, depth, 2)
    for (v, u), cell in np.ndenumerate(cells):
        rows = sorted({v // 2, min((v + 1) // 2, 5)})
        columns = sorted({u // 2, min((u + 1) // 2, 6)})
        gaps = {7 * r + c: abs(float(coarse[r, c] - depth[v, u])) for r in rows for c in columns}
        known = {place: gap for place, gap in gaps.items() if np.isfinite(gap)}
        assert cell in gaps
        if known:
            assert gaps[cell] == min(known.values())


def test_pixels_without_a_reading_take_the_cell_to_the_upper_left() -> None:
    depth = np.full((4, 4), np.nan, np.float32)
    cells = cell_of_pixel(np.ascontiguousarray(depth[::2, ::2]), depth, 2)
    assert cells.tolist() == [[0, 0, 1, 1], [0, 0, 1, 1], [2, 2, 3, 3], [2, 2, 3, 3]]
