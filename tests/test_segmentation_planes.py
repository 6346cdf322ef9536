"""Supports, walls and clusters of scenes whose planes are known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from curiosight.frame import Frame
from curiosight.segmentation.clusters import euclidean_clusters
from curiosight.segmentation.planes import find_supports, horizontal_axes, noise_band
from curiosight.segmentation.points import Points, observe_points
from curiosight.segmentation.settings import SegmentationSettings
from curiosight.segmentation.supports import (
    KnownTable,
    above_footprint,
    choose_supports,
    share_below,
)
from curiosight.segmentation.up import CAMERA_UP_PRIOR, up_from_normals, ups_from_normals
from curiosight.segmentation.walls import find_walls
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
    floor, *_ = find_supports(points, up_at(tilt_deg), band=noise_band(points, 0.008, 0.0035))
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


def test_footprint_covers_what_stands_on_the_table_and_nothing_beside_it() -> None:
    aside = Box((1.0, 0.2, 0.15), (0.25, 0.25, 0.30), (40, 80, 200))
    frame, view = see((TABLE_TOP, ON_TABLE, aside), distance=1.6, height=1.4, tilt_deg=35)
    points = observe(frame)
    supports = choose_supports(points, up_at(35), SegmentationSettings(), scene="floor")
    inside = above_footprint(points, supports[1].plane)
    surface = view.surface[::2, ::2]
    assert inside[surface == 2].mean() > 0.99
    assert inside[surface == 3].mean() == 0


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
        band=noise_band(points, 0.008, 0.0035),
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


@given(arrays(np.float64, 3, elements=st.floats(-1, 1)).filter(lambda a: np.linalg.norm(a) > 0.1))
def test_horizontal_axes_are_level_and_at_right_angles(direction: Points3) -> None:
    up = direction / np.linalg.norm(direction)
    basis = np.stack([*horizontal_axes(up), up])
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-9)


def clusters_by_flooding(xyz: Points3, tolerance: float) -> npt.NDArray[np.int64]:
    """Number points by brute force: neighbours within the tolerance share a number."""
    near = np.linalg.norm(xyz[:, None] - xyz[None], axis=2) <= tolerance
    number = np.full(len(xyz), -1)
    for seed in range(len(xyz)):
        open_points = [seed] if number[seed] < 0 else []
        while open_points:
            point = open_points.pop()
            number[point] = seed
            open_points += list(np.flatnonzero(near[point] & (number < 0)))
    return number


def same_partition(a: npt.NDArray[np.int64], b: npt.NDArray[np.int64]) -> bool:
    n_pairs = len({*zip(a.tolist(), b.tolist(), strict=True)})
    return n_pairs == len({*a.tolist()}) == len({*b.tolist()})


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 150))
def test_clusters_equal_brute_force_where_voxels_are_tiny(seed: int, n_points: int) -> None:
    xyz = np.random.default_rng(seed).uniform(-1, 1, (n_points, 3))
    found = euclidean_clusters(xyz, leaf=1e-6, tolerance=0.2)
    assert same_partition(found, clusters_by_flooding(xyz, 0.2))


def test_voxels_leave_clusters_as_they_are() -> None:
    rng = np.random.default_rng(SEED)
    xyz = rng.uniform(0, 0.2, (6000, 3)).astype(np.float32)
    xyz[:, 0] += np.repeat(np.float32([0.0, 0.32, 0.75]), 2000)
    found = euclidean_clusters(xyz, leaf=0.06, tolerance=0.10)
    assert same_partition(found, np.repeat([0, 1, 2], 2000))
    assert set(euclidean_clusters(xyz, leaf=0.06, tolerance=0.5)) == {0}


def test_no_point_has_no_cluster() -> None:
    assert euclidean_clusters(np.empty((0, 3)), leaf=0.02, tolerance=0.03).shape == (0,)
