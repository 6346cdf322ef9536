"""Points and normals against plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_cdt

from curiosight.teacher.cloud.local_planes import (
    _distance_to_edge,
    _mark_smooth,
    _sum_up,
    fit_local_planes,
)
from curiosight.teacher.cloud.points import look_up, observe_points, spread
from curiosight.teacher.cloud.ranks import ends, median
from room import kinect
from scenes import kinect_noise, see

CAMERA = kinect(160, 120)


def plane_depth(normal: npt.NDArray[np.float64], offset: float) -> npt.NDArray[np.float32]:
    """Depth of normal·p = offset in every pixel of CAMERA."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    return np.asarray(offset / (normal[0] * x + normal[1] * y + normal[2]), np.float32)


def smooth_by_loop(inverse: npt.NDArray[np.float32], max_bend: float) -> npt.NDArray[np.bool_]:
    smooth = np.isfinite(inverse)
    smooth[[0, -1]] = False
    smooth[:, [0, -1]] = False
    for v, u in np.argwhere(smooth):
        limit = max_bend + 0.004 * inverse[v, u] ** 2
        for dv, du in ((0, 1), (1, 0)):
            bend = inverse[v - dv, u - du] + inverse[v + dv, u + du] - 2 * inverse[v, u]
            smooth[v, u] &= not abs(bend) > limit
    return smooth


def mark_smooth(inverse: npt.NDArray[np.float32], max_bend: float) -> npt.NDArray[np.uint8]:
    is_smooth = np.zeros(inverse.shape, np.uint8)
    _mark_smooth(inverse, max_bend, is_smooth)
    return is_smooth


def scene_inverse(rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Inverse depth of a room with holes."""
    depth = see()[0].depth
    assert depth is not None
    depth = depth[::4, ::4].copy()
    depth[rng.random(depth.shape) < 0.01] = np.nan
    return np.asarray(1 / depth, np.float32)


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
    to_edge = _distance_to_edge(mark_smooth(inverse, 0.05), 5).astype(int)
    normals, area = fit_local_planes(inverse, u_axis, v_axis, 4, 0.05)
    pixel = 1 / (CAMERA.fx * CAMERA.fy)
    for v, u in rng.integers((0, 0), (120, 160), (60, 2)):
        r = to_edge[v, u] - 1
        if r < 1:
            assert np.isnan(normals[v, u]).all()
            assert area[v, u] == 0
            continue
        y, x = np.meshgrid(v_axis[v - r : v + r + 1], u_axis[u - r : u + r + 1], indexing="ij")
        rows = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=1)
        fit, *_ = np.linalg.lstsq(rows, inverse[v - r : v + r + 1, u - r : u + r + 1].ravel())
        np.testing.assert_allclose(normals[v, u], -fit / np.linalg.norm(fit), atol=2e-4)
        ray = np.array([u_axis[u], v_axis[v], 1])
        cosine = fit @ ray / np.linalg.norm(fit) / np.linalg.norm(ray)
        expected = pixel * depth[v, u] ** 2 / max(cosine, 0.1)
        assert area[v, u] == pytest.approx(expected, rel=1e-3)


def test_noise_of_a_kinect_tilts_normals_by_few_degrees() -> None:
    normal = np.array([0.0, 0.6, 0.8])
    depth = kinect_noise(plane_depth(normal, 1.4), np.random.default_rng(1))
    normals = observe_points(depth, CAMERA).normals
    cosine = normals[np.isfinite(normals[..., 0])] @ -normal
    assert np.degrees(np.arccos(np.median(cosine))) < 5


def test_smooth_is_where_no_second_difference_is_large() -> None:
    inverse = scene_inverse(np.random.default_rng(2))
    is_smooth = mark_smooth(inverse, 0.01)
    assert 0.3 < is_smooth.mean() < 0.98
    np.testing.assert_array_equal(is_smooth, smooth_by_loop(inverse, 0.01))


def test_distance_to_edge_is_the_chessboard_distance() -> None:
    is_smooth = mark_smooth(scene_inverse(np.random.default_rng(2)), 0.01)
    expected = np.minimum(distance_transform_cdt(is_smooth, "chessboard"), 6)
    np.testing.assert_array_equal(_distance_to_edge(is_smooth, 6), expected)


def test_integral_images_are_sums_of_sums() -> None:
    inverse = scene_inverse(np.random.default_rng(3))
    height, width = inverse.shape
    x, y = np.linspace(-0.5, 0.5, width), np.linspace(-0.4, 0.3, height)
    weights = np.stack([np.ones(inverse.shape), *np.meshgrid(x, y)], axis=-1)
    products = np.nan_to_num(inverse)[..., None] * weights
    expected = products.cumsum(axis=0).cumsum(axis=1)
    sums = np.zeros((height + 1, width + 1, 3))
    for v in range(height):
        _sum_up(inverse[v], x.astype(np.float32), np.float32(y[v]), sums[v], sums[v + 1])
    np.testing.assert_allclose(sums[1:, 1:], expected, rtol=1e-5, atol=1e-3)
    assert not sums[:, 0].any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 90), (90, 1), (2, 2), (5, 5), (61, 83)])
def test_images_of_any_size_have_points_and_few_normals(shape: tuple[int, int]) -> None:
    points = observe_points(np.full(shape, 1.5, np.float32), kinect(shape[1], shape[0]))
    assert np.isfinite(points.xyz).all()
    assert (points.depth == 1.5).all()
    has_normal = np.isfinite(points.normals[..., 0])
    assert not has_normal[[0, -1]].any()
    assert not has_normal[:, [0, -1]].any()
    np.testing.assert_array_equal(has_normal, points.area > 0)


@pytest.mark.parametrize("value", [np.nan, 0.0, np.inf, -1.0])
def test_what_is_no_distance_has_no_normal(value: float) -> None:
    points = observe_points(np.full((60, 80), value, np.float32), kinect(80, 60))
    assert np.isnan(points.normals).all()
    assert not points.area.any()


def test_holes_and_depth_steps_have_no_normal() -> None:
    depth = plane_depth(np.array([0.0, 0.0, 1.0]), 1.5)
    depth[:, 80:] = 2.0
    depth[20:30, 20:30] = np.nan
    points = observe_points(depth, CAMERA)
    assert np.isnan(points.normals[:, 39:41, 0]).all()
    assert np.isnan(points.normals[10:15, 10:15, 0]).all()
    assert np.isnan(points.xyz[10:15, 10:15]).all()


def spread_cells(
    depth: npt.NDArray[np.float32], stride: int, max_depth: float = np.inf
) -> npt.NDArray[np.int32]:
    """Number of the grid's cell that each pixel takes, -1 = none; fewer than 255 cells."""
    coarse = np.ascontiguousarray(depth[::stride, ::stride])
    cells = np.arange(coarse.size, dtype=np.int32).reshape(coarse.shape)
    packed = cells + ((cells // 2) << 8) + ((cells // 3) << 16)
    low, middle, high = spread(packed, coarse, depth, stride, max_depth=max_depth, beyond=0xFF)
    number = np.where(low == 0xFF, -1, low.astype(np.int32))
    np.testing.assert_array_equal(middle, np.where(number < 0, 0, number // 2))
    np.testing.assert_array_equal(high, np.where(number < 0, 0, number // 3))
    return number


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 12), st.integers(1, 4))
def test_pixels_take_the_cell_around_them_that_is_closest_in_depth(
    seed: int, height: int, width: int, stride: int
) -> None:
    rng = np.random.default_rng(seed)
    depth = rng.uniform(1, 2, (height, width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = np.nan
    coarse = depth[::stride, ::stride]
    n_rows, n_columns = coarse.shape
    for (v, u), cell in np.ndenumerate(spread_cells(depth, stride)):
        if np.isnan(depth[v, u]):
            assert cell == -1
            continue
        rows = {v // stride, min(-(-v // stride), n_rows - 1)}
        columns = {u // stride, min(-(-u // stride), n_columns - 1)}
        gaps = {
            n_columns * r + c: abs(float(coarse[r, c]) - float(depth[v, u]))
            for r in rows
            for c in columns
        }
        known = [gap for gap in gaps.values() if np.isfinite(gap)]
        assert cell in gaps
        if known:
            assert gaps[cell] == pytest.approx(min(known), abs=1e-6)


def test_pixels_take_the_cell_to_the_upper_left_where_all_are_alike() -> None:
    cells = spread_cells(np.full((4, 4), 1.5, np.float32), 2)
    assert cells.tolist() == [[0, 0, 1, 1], [0, 0, 1, 1], [2, 2, 3, 3], [2, 2, 3, 3]]


def test_pixels_beyond_the_range_take_none() -> None:
    depth = np.linspace(1, 3, 48, dtype=np.float32).reshape(6, 8)
    np.testing.assert_array_equal(spread_cells(depth, 2, max_depth=2.0) == -1, depth > 2)


def test_look_up_finds_the_cell_below_each_point() -> None:
    rng = np.random.default_rng(5)
    cells = rng.random((7, 9)).astype(np.float32)
    depth = rng.uniform(0.5, 1.5, (120, 160)).astype(np.float32)
    depth[30, 40] = np.nan
    points = observe_points(depth, CAMERA)
    axes = np.linalg.qr([[1.0, 0.1], [0.2, 0.9], [-0.3, 0.4]])[0]
    corner, side = points.xyz[31, 41] @ axes - 0.35, 0.1
    found = look_up(cells, points, axes, corner, side)
    place = np.nan_to_num((points.xyz.astype(float) @ axes - corner) / side, nan=-1)
    column, row = np.moveaxis(np.floor(place).astype(int), -1, 0)
    is_on_map = (column >= 0) & (column < 9) & (row >= 0) & (row < 7)
    assert 0.1 < is_on_map.mean() < 0.9
    np.testing.assert_array_equal(found[is_on_map], cells[row[is_on_map], column[is_on_map]])
    assert (found[~is_on_map] == -np.inf).all()


@pytest.mark.parametrize("n", [1, 7, 100, 5000])
def test_ends_leave_a_share_of_the_values_outside(n: int) -> None:
    values = np.random.default_rng(6).permutation(n).astype(np.float32)
    assert ends(values, 0.02) == (int(0.02 * n), n - 1 - int(0.02 * n))


def test_points_at_flat_indices_are_those_of_the_grid() -> None:
    points = observe_points(plane_depth(np.array([0.1, 0.2, 0.97]), 1.5), CAMERA)
    where = np.array([0, 161, 4000])
    v, u = np.unravel_index(where, points.depth.shape)
    np.testing.assert_array_equal(points.xyz_at(where), points.xyz[v, u])
    np.testing.assert_array_equal(points.normals_at(where), points.normals[v, u])


@pytest.mark.parametrize("n", [1, 2, 7, 100])
def test_median_is_numpys(n: int) -> None:
    values = np.random.default_rng(7).random(n).astype(np.float32)
    assert median(values) == pytest.approx(float(np.median(values)))
