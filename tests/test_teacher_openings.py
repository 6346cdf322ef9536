"""What is seen through between two fronts in one plane, and what only hides a wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.teacher.cloud.planes import coordinates_on, noise_band
from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.walls.openings import find_openings
from curiosight.teacher.walls.walls import find_walls
from room import Box
from scenes import CAMERA, WALL, kinect_noise, see

TILT_DEG, HEIGHT = 15.0, 1.0
UP = np.array([0.0, -np.cos(np.radians(TILT_DEG)), -np.sin(np.radians(TILT_DEG))])
# Two fronts, 35 cm apart, that face the camera in one plane.
CARTON = Box((-0.60, 0.5, 0.4), (0.85, 0.5, 0.8), (150, 110, 60))
DRESSER = replace(CARTON, centre=(0.60, 0.5, 0.4))
BEFORE_GAP = Box((0.0, 0.0, 0.5), (0.32, 0.2, 1.0), (40, 80, 200))


def observe(*boxes: Box) -> Points:
    frame, view = see(boxes, distance=2.0, height=HEIGHT, tilt_deg=TILT_DEG)
    assert frame.depth is not None
    return observe_points(kinect_noise(view.depth, np.random.default_rng(0)), CAMERA)


def walls_of(points: Points) -> list[Wall]:
    nowhere = np.zeros(points.depth.shape, np.bool_)
    return find_walls(
        points,
        UP,
        free=(points.depth < 4) & (points.xyz @ UP.astype(np.float32) > 0.05 - HEIGHT),
        over_tables=nowhere,
        band=noise_band(points.depth, 0.008, 0.0035),
        border=nowhere,
    )


def widths(walls: list[Wall]) -> list[float]:
    """Return the metres that walls reach to the side, the widest first."""
    return sorted((float(wall.high[0] - wall.low[0]) for wall in walls), reverse=True)


def test_fronts_in_one_plane_are_no_wall_where_the_gap_is_seen_through() -> None:
    assert walls_of(observe(CARTON, DRESSER, WALL)) == []


def test_what_lies_a_little_behind_a_gap_tells_too() -> None:
    behind = Box((0.0, 0.6, 0.4), (0.34, 0.5, 0.8), (90, 90, 90))
    assert walls_of(observe(CARTON, DRESSER, behind, WALL)) == []


def test_gap_that_something_nearer_hides_is_bridged() -> None:
    assert widths(walls_of(observe(CARTON, DRESSER, BEFORE_GAP, WALL))) == pytest.approx(
        [2.05], abs=0.1
    )


def test_gap_without_a_reading_is_bridged() -> None:
    points = observe(CARTON, DRESSER)
    is_behind = points.depth > 2.4
    nothing = np.where(is_behind, np.float32(np.nan), points.depth)
    xyz = np.where(is_behind[..., None], np.float32(np.nan), points.xyz)
    assert widths(walls_of(replace(points, depth=nothing, xyz=xyz))) == pytest.approx(
        [2.05], abs=0.1
    )


def test_wall_goes_on_beside_an_open_door() -> None:
    left = Box((-1.20, 1.5, 1.25), (2.0, 0.1, 2.5), (190, 190, 170), is_salient=False)
    right = replace(left, centre=(1.20, 1.5, 1.25))
    far = replace(WALL, centre=(0.0, 2.6, 1.25))
    shown = widths(walls_of(observe(left, right, far)))
    # The view ends 2 m to the left and to the right of the door's middle.
    assert len([width for width in shown if width > 1.2]) == 2


def test_openings_are_where_enough_rays_end_behind_the_plane() -> None:
    rng = np.random.default_rng(1)
    depth = rng.uniform(1.0, 3.0, (480, 640)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.1] = np.nan
    points = observe_points(depth, CAMERA)
    normal = np.array([0.5, 0.1, -1.0]) / np.linalg.norm([0.5, 0.1, -1.0])
    along = np.cross(UP, normal) / np.linalg.norm(np.cross(UP, normal))
    axes, band = np.stack([along, UP], axis=1), noise_band(points.depth, 0.01, 0.003)
    rays = np.stack(np.broadcast_arrays(points.x, points.y[:, None], np.float32(1)), axis=-1)
    z = -1.9 / (rays @ normal)
    places = z[..., None] * (rays @ axes)
    cell = np.floor((places[..., 0] - 0.5) / 0.05)
    is_there = (z > 0) & (places[..., 1] > -0.6) & (places[..., 1] < 0.2)
    is_behind = points.xyz @ normal + 1.9 < -0.1 - band
    shares = [np.mean(is_behind[is_there & (cell == number)]) for number in range(20)]
    median = float(np.median(shares))
    to_plane, window = coordinates_on(axes, normal, 1.9), (0.5, -0.6, 0.2)
    found = find_openings(
        points, band, to_plane, window, 20, cell=0.05, margin=0.1, min_share=median
    )
    is_clear = np.abs(np.array(shares) - median) > 0.003
    assert np.count_nonzero(is_clear) >= 15
    np.testing.assert_array_equal(found[is_clear], (np.array(shares) > median)[is_clear])
