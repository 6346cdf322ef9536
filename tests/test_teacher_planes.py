"""Supports and walls of scenes whose planes are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from curiosight.frame import Frame
from curiosight.teacher.cloud.plane_fit import _solve, _sum_rays, fit_plane
from curiosight.teacher.cloud.planes import (
    NEAR_HEIGHT,
    _find_level,
    _find_peak,
    _leave_out,
    _mark_inliers,
    _some_near,
    find_supports,
    horizontal_axes,
    noise_band,
)
from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.up import (
    CAMERA_UP_PRIOR,
    _between,
    _sum_facing,
    _vote,
    across,
    up_from_normals,
    ups_from_normals,
)
from curiosight.teacher.cloud.wall import Faces, Wall
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.footprint import above_footprint
from curiosight.teacher.supports.supports import (
    KnownTable,
    _mark_level,
    choose_supports,
    share_below,
)
from curiosight.teacher.walls.walls import find_walls
from room import ROOM, Box
from scenes import CAMERA, ON_TABLE, TABLE_TOP, WALL, kinect_noise, see

Points3 = npt.NDArray[np.float64]
SEED = 3


def up_at(tilt_deg: float) -> npt.NDArray[np.float64]:
    """Up in the frame of a camera that looks `tilt_deg` down."""
    tilt = np.radians(tilt_deg)
    return np.array([0.0, -np.cos(tilt), -np.sin(tilt)])


def observe(frame: Frame, *, noisy: bool = True) -> Points:
    assert frame.depth is not None
    rng = np.random.default_rng(SEED)
    return observe_points(kinect_noise(frame.depth, rng) if noisy else frame.depth, CAMERA)


def angle_deg(a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.mark.parametrize("tilt_deg", [10.0, 25.0, 50.0])
def test_floor_is_found_with_its_height_and_tilt(tilt_deg: float) -> None:
    points = observe(see(ROOM, distance=2.0, height=1.1, tilt_deg=tilt_deg)[0])
    floor, *_ = find_supports(points, up_at(tilt_deg), band=noise_band(points.depth, 0.008, 0.0035))
    assert angle_deg(floor.normal, up_at(tilt_deg)) < 0.5
    assert floor.offset == pytest.approx(1.1, abs=0.01)


def test_table_and_floor_are_two_supports_lowest_first() -> None:
    points = observe(see((TABLE_TOP, WALL), distance=1.6, height=1.4, tilt_deg=35)[0])
    supports = choose_supports(points, up_at(35), SegmentationSettings(), scene="floor")
    assert [support.is_table for support in supports] == [False, True]
    offsets = [support.plane.offset for support in supports]
    assert offsets == pytest.approx([1.4, 1.4 - 0.72], abs=0.01)


def test_lid_of_a_box_is_no_support() -> None:
    box = Box((0.0, 0.0, 0.2), (0.4, 0.4, 0.4), (90, 90, 90))
    points = observe(see((box, WALL), height=1.3, tilt_deg=35)[0])
    supports = choose_supports(points, up_at(35), SegmentationSettings(), scene="floor")
    assert len(supports) == 1


def test_hidden_floor_lies_where_the_recording_says() -> None:
    points = observe(see((TABLE_TOP,), distance=0.5, height=1.2, tilt_deg=60)[0])
    supports = choose_supports(
        points, up_at(60), SegmentationSettings(), scene="floor", camera_height=1.2
    )
    assert [support.is_table for support in supports] == [False, True]
    assert supports[0].plane.offset == pytest.approx(1.2, abs=0.02)


def test_sliver_of_a_table_counts_only_at_a_known_height() -> None:
    sliver = Box((0.6, 0.3, 0.70), (0.45, 0.40, 0.04), (150, 110, 60), is_salient=False)
    points = observe(see((sliver, WALL), height=1.4, tilt_deg=35)[0])
    up = up_at(35)
    unknown = choose_supports(points, up, SegmentationSettings(), scene="floor", camera_height=1.4)
    table = KnownTable(1.4 - 0.72, np.ones(points.depth.shape, np.float32))
    known = choose_supports(
        points, up, SegmentationSettings(), scene="floor", camera_height=1.4, known_tables=[table]
    )
    assert [support.is_table for support in unknown] == [False]
    assert [support.is_table for support in known] == [False, True]


def test_seats_as_high_as_a_known_table_are_no_table() -> None:
    small = Box((-0.95, 0.3, 0.70), (0.75, 0.45, 0.04), (150, 110, 60), is_salient=False)
    seats = [Box((x, 0.3, 0.70), (0.45, 0.45, 0.04), (40, 80, 200)) for x in (-0.2, 0.4, 1.0)]
    points = observe(see((small, *seats, WALL), distance=2.0, height=1.4, tilt_deg=35)[0])
    is_left = np.where(points.xyz[..., 0] < -0.5, np.float32(0.3), np.float32(-1))
    supports = choose_supports(
        points,
        up_at(35),
        SegmentationSettings(),
        scene="floor",
        camera_height=1.4,
        known_tables=[KnownTable(1.4 - 0.72, is_left)],
    )
    assert [support.core is not None for support in supports] == [False, True]


def test_footprint_covers_what_stands_on_the_table_and_nothing_beside_it() -> None:
    aside = Box((1.0, 0.2, 0.15), (0.25, 0.25, 0.30), (40, 80, 200))
    frame, view = see((TABLE_TOP, ON_TABLE, aside), distance=1.6, height=1.4, tilt_deg=35)
    points = observe(frame)
    supports = choose_supports(points, up_at(35), SegmentationSettings(), scene="floor")
    (inside,) = above_footprint(points, supports[1].plane, [0.05])
    surface = view.surface[::2, ::2]
    assert inside[surface == 2].mean() > 0.99
    assert inside[surface == 3].mean() == 0


def test_level_points_near_a_known_height_are_marked() -> None:
    points = observe(see((TABLE_TOP, WALL), distance=1.6, height=1.4, tilt_deg=35)[0])
    plane = np.array([*up_at(35), 1.4 - 0.72], np.float32)
    extent = np.random.default_rng(SEED).random(points.depth.shape) < 0.6
    is_near = np.abs(points.xyz @ plane[:3] + plane[3]) < 0.06 + 0.0035 * points.depth**2
    expected = extent & is_near & (points.normals @ plane[:3] > 0.9)
    is_level = np.empty(extent.shape, np.bool_)
    grid = points.depth, points.x, points.y, points.normals
    _mark_level(*grid, extent, plane, 0.0035, is_level)
    assert expected.any()
    assert np.count_nonzero(is_level != expected) <= 2


def test_share_below_tells_floor_from_table() -> None:
    points = observe(see((TABLE_TOP, WALL), distance=1.6, height=1.4, tilt_deg=35)[0])
    floor, table = (
        support.plane
        for support in choose_supports(points, up_at(35), SegmentationSettings(), scene="floor")
    )
    assert share_below(points, floor) == 0
    assert share_below(points, table) > 0.2


def walls_of(points: Points, **options: float) -> list[float]:
    """Distances of the walls that `find_walls` finds above the floor, 25° tilt assumed."""
    up = up_at(25)
    free = points.xyz @ up.astype(np.float32) > -0.95
    border = np.zeros(points.depth.shape, np.bool_)
    found = find_walls(
        points,
        up,
        free=free,
        over_tables=np.zeros_like(border),
        band=noise_band(points.depth, 0.008, 0.0035),
        border=border,
        **options,
    )
    return [wall.offset for wall in found]


def test_wall_is_found_with_its_distance_and_boxes_are_none() -> None:
    points = observe(see()[0])
    # The wall's front is at y = 2.9, the camera at y = -1.9.
    assert walls_of(points) == pytest.approx([4.8], abs=0.05)


def test_wall_needs_its_diagonal() -> None:
    panel = Box((0.0, 0.5, 0.45), (0.9, 0.1, 0.9), (90, 90, 90))
    points = observe(see((panel,))[0])
    assert walls_of(points) == []
    assert walls_of(points, min_diagonal=1.0) == pytest.approx([2.35], abs=0.03)


def test_corner_has_two_walls() -> None:
    side = Box((1.1, 1.0, 1.25), (0.2, 5.0, 2.5), (190, 190, 170), is_salient=False)
    back = Box((0.0, 1.5, 1.25), (12.0, 0.2, 2.5), (190, 190, 170), is_salient=False)
    points = observe(see((side, back))[0])
    assert sorted(walls_of(points)) == pytest.approx([1.0, 3.3], abs=0.05)


@pytest.mark.parametrize("tilt_deg", [-10.0, 0.0, 25.0, 60.0])
def test_up_of_one_frame_is_what_most_surface_faces(tilt_deg: float) -> None:
    points = observe(see(ROOM, distance=2.6, height=1.1, tilt_deg=tilt_deg)[0])
    keep = points.area > 0
    up = up_from_normals(points.normals[keep], points.area[keep], prior=CAMERA_UP_PRIOR)
    assert up is not None
    assert angle_deg(up, up_at(tilt_deg)) < 1.5


def test_up_is_unknown_where_nothing_is_horizontal() -> None:
    points = observe(see((WALL,), distance=-1.0, height=1.2, tilt_deg=0)[0])
    keep = points.area > 0
    assert up_from_normals(points.normals[keep], points.area[keep], prior=CAMERA_UP_PRIOR) is None


def test_candidates_for_up_are_apart_and_begin_with_the_largest() -> None:
    rng = np.random.default_rng(SEED)
    directions = [up_at(25), up_at(60), up_at(-10)]
    normals = np.repeat(directions, (300, 200, 100), axis=0)
    normals += rng.normal(0, 0.01, normals.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = list(ups_from_normals(normals, np.ones(len(normals))))
    assert [angle_deg(a, b) < 1 for a, b in zip(found, directions, strict=True)] == [True] * 3


def test_normals_are_summed_around_a_direction_and_counted_per_cell() -> None:
    rng = np.random.default_rng(SEED)
    normals = rng.normal(size=(500, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    area = np.maximum(rng.uniform(-0.5, 1, 500), 0).astype(np.float32)
    normals[area == 0] = np.nan
    has_area, up = area > 0, up_at(25).astype(np.float32)
    is_near = has_area & (normals @ up > 0.6)
    total = np.zeros(3)
    _sum_facing(normals, area, up, 0.6, total)
    np.testing.assert_allclose(total, area[is_near] @ normals[is_near], rtol=1e-5)
    axes = np.stack(horizontal_axes(up_at(25))).astype(np.float32) / np.float32(0.07)
    rows, columns = np.floor(normals[has_area] @ axes.T + 16).astype(int).T
    expected, votes = np.zeros((2, 33, 33))
    np.add.at(expected, (rows, columns), area[has_area])
    _vote(normals[has_area], area[has_area], axes, votes)
    np.testing.assert_allclose(votes, expected, rtol=1e-5)
    is_between = has_area & (normals @ up > -0.2) & (normals @ up < 0.6)
    some, area_of_some = _between(normals, area, up, -0.2, 0.6)
    np.testing.assert_array_equal(some, normals[is_between])
    np.testing.assert_array_equal(area_of_some, area[is_between])
    normal = np.cross(up_at(25), up_at(60))
    np.testing.assert_allclose(across(up_at(25), up_at(60)), normal / np.linalg.norm(normal))


@given(arrays(np.float64, 3, elements=st.floats(-1, 1)).filter(lambda a: np.linalg.norm(a) > 0.1))
def test_horizontal_axes_are_level_and_at_right_angles(direction: Points3) -> None:
    up = direction / np.linalg.norm(direction)
    basis = np.stack([*horizontal_axes(up), up])
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-9)


def random_points(rng: np.random.Generator, n: int) -> npt.NDArray[np.float32]:
    """(n, 3) points in view of a camera."""
    return rng.uniform((-1, -1, 0.5), (1, 1, 3), (n, 3)).astype(np.float32)


@pytest.mark.parametrize("n_points", [400, 30_000])
def test_fit_recovers_a_plane_among_outliers(n_points: int) -> None:
    rng = np.random.default_rng(SEED)
    normal = np.array([0.1, -0.9, -0.42])
    normal /= np.linalg.norm(normal)
    xyz = random_points(rng, n_points)
    xyz[:, 1] = -(xyz[:, 0] * normal[0] + xyz[:, 2] * normal[2] + 1.1) / normal[1]
    is_outlier = rng.random(n_points) < 0.2
    xyz[is_outlier, 1] -= rng.uniform(0.05, 0.5, is_outlier.sum())
    band, where = np.full(n_points, 0.01, np.float32), np.arange(n_points)
    fit = fit_plane(xyz, band, where, np.array([0.12, -0.9, -0.42]), 1.11)
    assert fit is not None
    assert angle_deg(fit[0], normal) < 0.05
    assert fit[1] == pytest.approx(1.1, abs=1e-3)


@pytest.mark.parametrize(("n_points", "is_enough"), [(49, False), (50, True)])
def test_fit_needs_fifty_points(n_points: int, is_enough: bool) -> None:
    band, where = np.full(60, 0.1, np.float32), np.arange(n_points)
    xyz = random_points(np.random.default_rng(SEED), 60)
    xyz[:, 2] = 1
    fit = fit_plane(xyz, band, where, np.array([0.0, 0.0, -1.0]), 1.0)
    assert (fit is not None) == is_enough


def test_fit_takes_points_on_a_line() -> None:
    xyz = np.stack([np.linspace(-1, 1, 80), np.zeros(80), np.full(80, 1.5)], axis=1)
    band, where = np.full(80, 0.02, np.float32), np.arange(80)
    fit = fit_plane(xyz.astype(np.float32), band, where, np.array([0.0, 0.0, -1.0]), 1.5)
    assert fit is not None
    assert np.abs(xyz @ fit[0] + fit[1]).max() < 1e-6


def test_sums_of_rays_are_those_of_the_points_near_the_plane() -> None:
    rng = np.random.default_rng(SEED)
    xyz, band = random_points(rng, 900), rng.uniform(0, 0.5, 900).astype(np.float32)
    plane, where = np.array([0.6, 0.0, -0.8, 1.2]), rng.permutation(900)[:600]
    is_near = np.abs(xyz @ plane[:3] + plane[3]) < 2 * (band + 0.1)
    x, y, z = xyz[where[::3]][is_near[where[::3]]].astype(np.float64).T
    rows = np.stack([x / z, y / z, np.ones(len(z)), 1 / z], axis=1)
    sums = np.zeros((3, 4))
    _sum_rays(xyz, band, where, 3, 0.1, 2.0, plane, sums)
    np.testing.assert_allclose(sums, np.triu(rows.T @ rows)[:3], rtol=1e-6)


def test_solution_is_that_of_the_sums() -> None:
    rows = np.random.default_rng(SEED).normal(size=(30, 4))
    sums = (rows.T @ rows)[:3]
    expected = np.linalg.solve(sums[:, :3], sums[:, 3])
    np.testing.assert_allclose(_solve(np.triu(sums)), expected, rtol=1e-6)


def some_heights() -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """(h, w) metres, NaN = none, about two levels, and bands of some centimetres."""
    rng = np.random.default_rng(SEED)
    heights = rng.choice([-1.2, -0.5], (40, 30), p=[0.7, 0.3]) + rng.normal(0, 0.02, (40, 30))
    heights[rng.random(heights.shape) < 0.2] = np.nan
    return heights.astype(np.float32), rng.uniform(0, 0.02, (40, 30)).astype(np.float32)


def test_heights_are_those_of_what_is_level_and_in_range() -> None:
    points = observe(see(ROOM)[0])
    up = up_at(25).astype(np.float32)
    is_level = (points.normals @ up > 0.9) & (points.depth < 2.5)
    found = np.empty_like(points.depth)
    _find_level(points.depth, points.x, points.y, points.normals, up, 0.9, 2.5, found)
    assert 0.05 < is_level.mean() < 0.9
    assert np.count_nonzero(np.isfinite(found) != is_level) <= 2  # by rounding
    is_known = np.isfinite(found)
    np.testing.assert_allclose(found[is_known], (points.xyz @ up)[is_known], atol=1e-5)


def test_peak_is_the_fullest_three_steps_of_height() -> None:
    heights, area = some_heights()
    known, low = np.isfinite(heights), float(np.nanmin(heights))
    steps = np.floor((heights[known].astype(float) - low) / 0.02).astype(int)
    sums = np.convolve(np.bincount(steps, area[known]), np.ones(3), "same")
    height, most = _find_peak(heights, area, 0.02)
    assert height == pytest.approx(low + (np.argmax(sums) + 0.5) * 0.02)
    assert most == pytest.approx(sums.max(), rel=1e-6)
    assert _find_peak(np.full_like(heights, np.nan), area, 0.02) == (0.0, 0.0)


@pytest.mark.parametrize("max_points", [10_000, 100])
def test_near_a_height_is_what_its_band_says(max_points: int) -> None:
    heights, band = some_heights()
    where = np.flatnonzero(np.abs(heights + np.float32(1.2)) < np.float32(NEAR_HEIGHT) + band)
    stride = 1 + len(where) // max_points
    found = _some_near(heights, band, -1.2, max_points)
    np.testing.assert_array_equal(found, where[::stride])


@pytest.mark.parametrize("slack", [-1.0, 1.5])
def test_inliers_are_near_a_height_and_a_plane_and_both_are_left_out(slack: float) -> None:
    heights, band = some_heights()
    gap, area = np.random.default_rng(SEED).random((2, *heights.shape)).astype(np.float32) / 20
    is_near = np.abs(heights + np.float32(1.2)) < np.float32(NEAR_HEIGHT) + band
    inliers = np.empty(heights.shape, np.bool_)
    visible = _mark_inliers(heights, band, -1.2, gap, area, inliers)
    np.testing.assert_array_equal(inliers, is_near & (gap < band))
    assert visible == pytest.approx(area[inliers].sum(), rel=1e-5)
    left = np.where(is_near | (gap <= np.float32(slack) * band), np.nan, heights)
    _leave_out(heights, band, -1.2, gap, slack)
    np.testing.assert_array_equal(heights, left)


def test_near_a_wall_is_what_is_free_and_before_it() -> None:
    points = observe(see()[0])
    rng = np.random.default_rng(SEED)
    normal = np.array([0.0, -0.4, -1.0]) / np.hypot(0.4, 1.0)
    axes = np.stack([[1.0, 0.0, 0.0], np.cross(normal, [1.0, 0.0, 0.0])], axis=1)
    none = np.zeros(points.depth.shape, np.bool_)
    wall = Wall(normal, 2.3, none, axes, np.array([-0.7, -0.6]), np.array([0.4, 0.9]))
    free, band = rng.random(none.shape) < 0.7, noise_band(points.depth, 0.2, 0.01)
    is_near = free & (np.abs(wall.distance(points.xyz)) < band)
    places = points.xyz @ axes
    is_before = ((places > wall.low - 0.1) & (places < wall.high + 0.1)).all(axis=-1)
    assert 0 < np.count_nonzero(is_near & is_before) < np.count_nonzero(is_near)
    faces_elsewhere = np.abs(points.normals @ normal) < 0.7
    found = wall.near(points, free, band, min_facing=0.7)
    np.testing.assert_array_equal(found, is_near & is_before & ~faces_elsewhere)
    assert 0 < np.count_nonzero(found) < np.count_nonzero(is_near & is_before)
    is_behind = wall.distance(points.xyz) <= 0
    gap = np.abs(wall.distance(points.xyz))
    sides = is_before, is_behind, gap < 0.1, gap < 0.2
    other = replace(wall, offset=1.9)
    where = np.arange(points.depth.size)
    counts = Faces.of([other, wall]).count_sides(points, where, 0.1)
    np.testing.assert_array_equal(counts[1], [np.count_nonzero(side) for side in sides])
    assert counts[0, 1] == np.count_nonzero(other.distance(points.xyz) <= 0) > counts[1, 1]
