"""Where a robot can stand in a room, the ways between, and where it looks from."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.frame import is_rigid
from curiosight.rooms.arrangement import corners
from curiosight.rooms.free_space import ROBOT_RADIUS, FreeSpace
from curiosight.rooms.viewpoints import camera_pose, distance_to_wall, draw_poses

SQUARE = corners(np.array([0.0, 0.0, 4.0, 4.0]))
L_SHAPE = np.array([(0, 0), (6, 0), (6, 2), (2, 2), (2, 6), (0, 6)], float)


def place(x: float, y: float) -> np.ndarray:
    return np.array([x, y], float)


def test_the_robot_keeps_its_radius_from_walls_and_furniture() -> None:
    space = FreeSpace(SQUARE, [corners(np.array([1.0, 1.0, 2.0, 2.0]))], radius=0.3)
    for x, y, is_free in (
        (0.5, 0.5, True),
        (0.2, 2.0, False),
        (1.5, 1.5, False),
        (2.2, 1.5, False),
        (2.4, 1.5, True),
        (-1.0, 2.0, False),
        (9.0, 2.0, False),
    ):
        assert space.contains(place(x, y)) == is_free, (x, y)
    assert space.area == pytest.approx(3.4**2 - (1.6**2 - 0.3**2 * (4 - np.pi)), rel=0.04)


def test_of_a_room_in_pieces_the_largest_counts() -> None:
    space = FreeSpace(SQUARE, [corners(np.array([1.0, -1.0, 1.5, 5.0]))])
    assert space.contains(place(3, 2))
    assert not space.contains(place(0.5, 2))


def test_ways_are_straight_or_lead_around() -> None:
    space = FreeSpace(L_SHAPE, [])
    assert space.way(place(1, 1), place(5, 1)) == pytest.approx(4)
    around = space.way(place(5, 1), place(1, 5))
    by_hand = 2 * np.hypot(
        3 + ROBOT_RADIUS, 1 - ROBOT_RADIUS
    )  # touching the corner at the robot's radius
    assert by_hand - 0.1 < around < 1.1 * by_hand
    assert space.way(place(1, 5), place(5, 1)) == pytest.approx(around)


def test_ways_to_many_places_are_those_to_each() -> None:
    space = FreeSpace(L_SHAPE, [])
    places = space.draw_places(30, np.random.default_rng(1))
    expected = [space.way(places[0], goal) for goal in places]
    np.testing.assert_allclose(space.ways(places[0], places), expected, rtol=1e-12)


def test_drawn_places_are_free_and_everywhere() -> None:
    space = FreeSpace(L_SHAPE, [])
    drawn = space.draw_places(500, np.random.default_rng(0))
    # Half a cell of jitter may lead a little closer to a wall.
    assert drawn.min() > ROBOT_RADIUS - 0.05
    assert (drawn[:, 0] > 4).any()
    assert (drawn[:, 1] > 4).any()
    assert not ((drawn > 2).all(1)).any()


def test_a_full_room_is_refused() -> None:
    with pytest.raises(ValueError, match="free floor"):
        FreeSpace(SQUARE, [SQUARE]).draw_places(1, np.random.default_rng(0))


def test_a_place_in_a_wall_is_named() -> None:
    with pytest.raises(ValueError, match=r"got \(0\.10, 2\.00\): in a wall, in furniture"):
        FreeSpace(SQUARE, []).check(place(0.1, 2))


def test_a_level_camera_looks_along_its_heading() -> None:
    pose = camera_pose(1, 2, 90, height=1.2, tilt_deg=0)
    assert is_rigid(pose)
    np.testing.assert_allclose(pose[:3, 3], (1, 2, 1.2))
    np.testing.assert_allclose(pose[:3, 2], (0, 1, 0), atol=1e-12)  # forward
    np.testing.assert_allclose(pose[:3, 0], (1, 0, 0), atol=1e-12)  # right
    np.testing.assert_allclose(pose[:3, 1], (0, 0, -1), atol=1e-12)  # down


def test_tilt_looks_down_and_roll_turns_the_image() -> None:
    tilted = camera_pose(0, 0, 0, height=1, tilt_deg=30)
    np.testing.assert_allclose(tilted[:3, 2], (np.cos(np.pi / 6), 0, -0.5), atol=1e-12)
    rolled = camera_pose(0, 0, 0, height=1, tilt_deg=30, roll_deg=90)
    assert is_rigid(rolled)
    np.testing.assert_allclose(rolled[:3, 2], tilted[:3, 2])
    np.testing.assert_allclose(rolled[:3, 0], tilted[:3, 1], atol=1e-12)


def test_poses_stand_free_with_room_ahead() -> None:
    space = FreeSpace(L_SHAPE, [])
    rng = np.random.default_rng(3)
    poses = draw_poses(50, space, L_SHAPE, rng, height=0.8, tilt_deg=20)
    for pose in poses:
        assert is_rigid(pose)
        assert pose[2, 3] == pytest.approx(0.8, abs=0.05)
        assert np.degrees(np.arcsin(-pose[2, 2])) == pytest.approx(20, abs=2.5)
        heading = float(np.degrees(np.arctan2(pose[1, 2], pose[0, 2])))
        assert distance_to_wall(L_SHAPE, pose[:2, 3], heading) >= 1.6
    again = draw_poses(50, space, L_SHAPE, np.random.default_rng(3), height=0.8, tilt_deg=20)
    np.testing.assert_array_equal(poses, again)


@pytest.mark.parametrize(
    ("heading", "metres"), [(0, 5), (90, 5), (180, 1), (270, 1), (45, np.sqrt(2))]
)
def test_distance_to_the_wall_ahead(heading: float, metres: float) -> None:
    assert distance_to_wall(L_SHAPE, place(1, 1), heading) == pytest.approx(metres)


def test_straight_ways_are_clear_where_every_half_cell_of_them_is_free() -> None:
    obstacles = [corners(np.array([1.0, 1.0, 2.0, 2.0])), corners(np.array([2.6, 0.5, 2.9, 3.0]))]
    space = FreeSpace(SQUARE, obstacles, radius=0.1)
    places = space.draw_places(80, np.random.default_rng(1))
    for start in places[:10]:
        expected = [is_clear(space, start, goal, places) for goal in places]
        np.testing.assert_array_equal(space._are_clear(start, places), expected)
        assert 10 < sum(expected) < 70


def is_clear(
    space: FreeSpace, start: np.ndarray, goal: np.ndarray, goals: np.ndarray, cell: float = 0.05
) -> bool:
    longest = max(np.linalg.norm(one - start) for one in goals)
    shares = np.linspace(0, 1, 2 + int(longest / (0.5 * cell)))
    return all(space.contains(start + share * (goal - start)) for share in shares)
