"""What is support, what is over it, and what is out of view, against plain references."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Pose
from curiosight.teacher import SegmentationSettings
from curiosight.teacher.cloud.planes import Plane, Surface, noise_band
from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.settings import FLOOR, TABLE
from curiosight.teacher.supports.slab import (
    NOTHING,
    ON_DOUBTFUL,
    ON_FLOOR,
    ON_FURNITURE,
    ON_TABLE,
    on_supports,
)
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.supports.table_map import Table
from curiosight.teacher.supports.tops import Kind
from curiosight.teacher.things.bodies import Bodies, beside_table, connect_bodies
from curiosight.teacher.things.objects import _take_over
from curiosight.teacher.walls.headings import Headings, _sum_around, _vote
from curiosight.teacher.walls.surroundings import Surroundings
from curiosight.teacher.walls.wall_map import _are_in_view, _mark_within, recognise
from room import look
from scenes import CAMERA, kinect_noise, see

Mask = npt.NDArray[np.bool_]
SEED, NOISE = 6, SegmentationSettings().noise
UP = np.array([0.0, -np.cos(np.radians(25)), -np.sin(np.radians(25))])


@pytest.fixture(scope="module")
def points() -> Points:
    depth = see()[0].depth
    assert depth is not None
    return observe_points(kinect_noise(depth, np.random.default_rng(SEED)), CAMERA)


def floor_of(points: Points) -> Support:
    plane = Plane(UP, 1.0, np.zeros(points.depth.shape, np.bool_))
    return Support(plane, FLOOR, plane.distances(points))


def table_of(points: Points, rng: np.random.Generator) -> Support:
    """Return a table 10 cm over the floor, as if its map were noise."""
    floor = floor_of(points)
    extent = rng.random(points.depth.shape) < 0.7
    core = extent & (rng.random(points.depth.shape) < 0.5)
    plane = replace(floor.plane, offset=0.9)
    return Support(plane, TABLE, plane.distances(points), extent, core, extent)


def test_distances_are_those_of_the_points(points: Points) -> None:
    plane = floor_of(points).plane
    expected = points.xyz.astype(np.float64) @ plane.normal + plane.offset
    np.testing.assert_allclose(plane.distances(points), expected, atol=2e-6)


def test_surface_is_what_faces_a_direction_with_its_places(points: Points) -> None:
    free = np.random.default_rng(SEED).random(points.depth.shape) < 0.5
    band, cosine = noise_band(points.depth, 0.01, NOISE), points.normals @ UP.astype(np.float32)
    np.testing.assert_allclose(band, 0.01 + NOISE * points.depth**2, rtol=1e-6)
    expected = np.flatnonzero(free & (cosine > 0.2) & (cosine < 0.95))
    surface = Surface.facing(points, band, free, UP, 0.2, 0.95)
    assert len(np.setxor1d(surface.where, expected)) <= 2  # by rounding
    some = surface.at(np.arange(3, 40, 5))
    for one in (surface, some):
        v, u = np.unravel_index(one.where, free.shape)
        np.testing.assert_array_equal(one.xyz, points.xyz[v, u])
        np.testing.assert_array_equal(one.normals, points.normals[v, u])
        np.testing.assert_array_equal(one.area, points.area[v, u])
        np.testing.assert_array_equal(one.band, band[v, u])
    np.testing.assert_array_equal(some.where, surface.where[3:40:5])


def test_on_a_support_is_what_is_in_its_slab_and_extent_and_not_upright(points: Points) -> None:
    floor, table = floor_of(points), table_of(points, np.random.default_rng(SEED))
    expected = np.zeros(points.depth.shape, np.uint8)
    seat = replace(table, kind=Kind.FURNITURE, extent=table.extent & (points.depth < 2))
    lid = replace(table, kind=Kind.DOUBTFUL, extent=table.extent & (points.depth > 2.5))
    supports = {ON_FLOOR: floor, ON_TABLE: table, ON_FURNITURE: seat, ON_DOUBTFUL: lid}
    for kind, support in supports.items():
        slab = support.settings.slab + NOISE * points.depth**2
        is_in_slab = np.abs(support.heights) < slab
        facing_up = np.abs(points.normals @ UP.astype(np.float32))
        is_low = np.abs(support.heights) < slab / 2
        is_upright = np.where(np.isnan(facing_up), ~is_low, facing_up < 0.7)
        is_there = True if support.extent is None else support.extent
        expected[is_in_slab & ~is_upright & is_there] = kind
    found = on_supports(points, supports.values(), NOISE)
    assert set(np.unique(found)) == {NOTHING, *supports}
    assert np.count_nonzero(found != expected) <= 2


def test_bodies_end_at_steps_in_depth(points: Points) -> None:
    free = np.random.default_rng(SEED).random(points.depth.shape) < 0.95
    depth = points.depth
    step = 0.02 + 2 * NOISE * depth**2
    is_smooth = free.copy()
    is_smooth[:, 1:] &= np.abs(np.diff(depth, axis=1)) < step[:, 1:]
    is_smooth[1:] &= np.abs(np.diff(depth, axis=0)) < step[1:]
    bodies = connect_bodies(free, depth, NOISE)
    assert np.count_nonzero((bodies.number > 0) != is_smooth) <= 2
    assert bodies.n == bodies.number.max() + 1


def taken_over(
    free: Mask, bodies: Bodies, support: Support, points: Points, *, is_lowest: bool
) -> tuple[Mask, Mask]:
    """Return what is over a support, and what stays free, image by image."""
    slab = support.settings.slab + NOISE * points.depth**2
    heights = support.heights
    over = free & (heights > slab / 2) & (heights < support.settings.max_height)
    if support.extent is not None and support.core is not None:
        extent = support.extent & ~beside_table(bodies, support)[bodies.number]
        under = extent & (heights > -1.2) & (support.core | (heights > -slab))
        free = free & ~under
        over &= extent | is_lowest
    return over, free & ~over


@pytest.mark.parametrize("is_lowest", [True, False])
def test_points_over_a_support_are_taken_and_those_under_it_dropped(
    points: Points, is_lowest: bool
) -> None:
    floor, table = floor_of(points), table_of(points, np.random.default_rng(SEED))
    free = points.depth < 4
    bodies = connect_bodies(free, points.depth, NOISE)
    supports = [table] if is_lowest else [floor, table]
    nowhere = np.zeros(free.shape, np.bool_)
    around = Surroundings(
        points, supports, [], nowhere, SegmentationSettings(), nowhere, nowhere, free
    )
    carrier = np.full(free.shape, -1, np.int8)
    for place, support in reversed(list(enumerate(supports))):
        expected = taken_over(free, bodies, support, points, is_lowest=support is supports[0])
        _take_over(free, bodies, support, place, around, carrier)
        over = carrier == place
        assert over.any()
        for found, wanted in zip((over, free), expected, strict=True):
            assert np.count_nonzero(found != wanted) <= 2


def wall_at(distance: float, heading_deg: float = 0.0) -> Wall:
    """Return a wall, 2 m wide and 1 m high at the camera's height, that faces the camera."""
    angle = np.radians(heading_deg)
    normal = -np.array([np.sin(angle), 0.0, np.cos(angle)])
    axes = np.stack([np.cross([0.0, -1.0, 0.0], normal), [0.0, -1.0, 0.0]], axis=1)
    none = np.zeros((0, 0), np.bool_)
    return Wall(normal, distance, none, axes, np.array([-1.0, -0.5]), np.array([1.0, 0.5]))


def test_walls_that_points_are_near_are_in_view() -> None:
    rng = np.random.default_rng(SEED)
    points = observe_points(rng.uniform(0.5, 4.0, (480, 640)).astype(np.float32), CAMERA)
    free, band = np.ones(points.depth.shape, np.bool_), np.full_like(points.depth, 0.2)
    walls = [
        wall_at(distance, heading)
        for distance, heading in zip(rng.uniform(0.3, 5, 90), rng.uniform(0, 360, 90), strict=True)
    ]
    are_in_view = _are_in_view(walls, points)
    are_met = [wall.near(points, free, band, min_facing=0.0).any() for wall in walls]
    assert 10 < sum(are_met) < 60
    assert all(in_view or not met for in_view, met in zip(are_in_view, are_met, strict=True))
    # A corner of a wall can be just out of view, or too far.
    assert sum(are_in_view) - sum(are_met) < 20


def test_walls_out_of_view_stay_as_they_were(points: Points) -> None:
    free, band = np.ones(points.depth.shape, np.bool_), np.full_like(points.depth, 0.05)
    behind = wall_at(2.0, 180.0)
    (found,) = recognise(points, [behind], free=free, band=band)
    assert not found.inliers.any()
    assert found.inliers.shape == points.depth.shape
    assert found.offset == behind.offset


def test_points_within_the_band_of_a_plane_are_marked(points: Points) -> None:
    where = np.flatnonzero(points.depth < 3)[::3]
    band, xyz = noise_band(points.depth, 0.01, NOISE), points.xyz.reshape(-1, 3)
    found, expected = np.zeros((2, *band.shape), np.bool_)
    gap = np.abs(xyz[where] @ UP.astype(np.float32) + np.float32(1))
    expected.ravel()[where[gap < band.take(where) + 0.02]] = True
    _mark_within(xyz, where, np.array([*UP, 1.0], np.float32), band, found)
    assert expected.any()
    assert np.count_nonzero(found != expected) <= 2


@pytest.mark.parametrize("heading_deg", [0.0, 60.0, 130.0, 180.0, 290.0])
def test_tables_in_view_are_those_that_points_are_over(heading_deg: float) -> None:
    rng = np.random.default_rng(SEED)
    depth = rng.uniform(0.5, 4.0, (480, 640)).astype(np.float32)
    points = observe_points(depth, CAMERA)
    pose: Pose = look(heading_deg, distance=1.0, height=1.0, tilt_deg=20)
    inside = np.zeros((20, 30), np.float32)
    tables = [Table(0.7, np.eye(3)[:, :2], low, inside) for low in rng.uniform(-5, 5, (60, 2))]
    are_in_view = [table.is_in_view(points, pose, 4.0) for table in tables]
    are_met = [bool((table.inset_of(points, pose) == 0).any()) for table in tables]
    assert 3 < sum(are_met) < 40
    # A corner of a map can be in view and meet none of the random points.
    assert all(in_view or not met for in_view, met in zip(are_in_view, are_met, strict=True))
    assert sum(are_in_view) - sum(are_met) <= 3


def test_votes_are_weights_summed_per_cell() -> None:
    rng = np.random.default_rng(SEED)
    cell, weights = rng.integers(0, 50, 400), rng.random(400).astype(np.float32)
    votes = np.zeros(50)
    _vote(cell, weights, votes)
    np.testing.assert_allclose(votes, np.bincount(cell, weights, minlength=50))


def test_votes_are_summed_over_the_sectors_beside_and_the_row_before() -> None:
    votes = np.random.default_rng(SEED).random((12, 7))
    pairs = votes[:, 1:] + votes[:, :-1]
    sums = np.empty((12, 6))
    _sum_around(votes, sums)
    np.testing.assert_allclose(sums, pairs + np.roll(pairs, 1, axis=0) + np.roll(pairs, -1, axis=0))


def test_peak_that_fits_no_wall_gives_way_to_the_next(points: Points) -> None:
    band = noise_band(points.depth, 0.008, NOISE)
    surface = Surface.facing(points, band, points.depth < 4, UP, -0.3, 0.3)
    headings = Headings(surface, UP)
    heights, area = [], surface.area.astype(np.float64)
    while len(area) and len(heights) < 5:
        _, _, height = headings.peak(area)
        voters = headings.voters()
        assert area[voters].sum() == pytest.approx(height)
        heights.append(height)
        headings.keep(np.flatnonzero(~voters))
        area = area[~voters]
    assert len(heights) == 5
    assert all(first >= then > 0 for first, then in itertools.pairwise(heights))
