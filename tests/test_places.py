"""Places: rooms that a door joins, seen from spots in them, with poses and by looks alone."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Camera, Frame, Pose
from curiosight.frame.level import ground_axes
from curiosight.learner import places as module
from curiosight.learner.linking import join_linked, keep_numbers, seen_by_each_other, shared_likes
from curiosight.learner.looks import BINS, HIGH, LOOK_SIZE, LOW, RANGES, Looks, look_of
from curiosight.learner.places import MAX_LOOKS_PER_SPOT, Places
from curiosight.learner.sight import CELL, Sight, cell_of

UP = np.array([0.0, 0.0, 1.0])
CAMERA = Camera(64, 48, 40.0, 40.0, 31.5, 23.5)
ROOM, WALL, DOOR = 4.0, 0.2, 0.8
DOORS = (2.0, 0.6)  # where each wall between two rooms has its door's middle
N_HEADINGS = 6


def pose(x: float, y: float, heading: float) -> Pose:
    """Return that of a level camera 1 m over the floor; heading in radians from the x axis."""
    forward = np.array([np.cos(heading), np.sin(heading), 0])
    down = -UP
    T = np.eye(4)
    T[:3, :3] = np.stack([np.cross(down, forward), down, forward], axis=1)
    T[:3, 3] = x, y, 1.0
    return T


def distance_to_wall(start: npt.NDArray, direction: npt.NDArray) -> float:
    """Return how far a level ray goes in a row of rooms that doors join."""
    for distance in np.arange(0.02, 12, 0.02):
        x, y = start + distance * direction
        room, along = divmod(x, ROOM + WALL)
        is_in_wall = along > ROOM and abs(y - DOORS[min(int(room), 1)]) > DOOR / 2
        if not 0 < y < ROOM or not 0 < x < 3 * ROOM + 2 * WALL or is_in_wall:
            return float(distance)
    return 12.0


def view(room: int, x: float, y: float, heading: float) -> Sight:
    """Return what is seen in a room; its colours are the room's, its light is its own."""
    T = pose(room * (ROOM + WALL) + x, y, heading)
    directions = (np.arange(64) - CAMERA.cx) / CAMERA.fx
    rays = T[:2, 2] + directions[:, None] * T[:2, 0]
    depth = np.array([distance_to_wall(T[:2, 3], ray) for ray in rays], np.float32)
    colours = np.array([(180, 80, 80), (80, 160, 80), (80, 80, 190)])
    chance = np.random.default_rng(int(1e6 * (x + 4 * y + heading)))
    brightness = chance.uniform(0.5, 1.2)
    rgb = np.clip(chance.normal(brightness * colours[room], 25, (48, 64, 3)), 0, 255)
    rgb = rgb.astype(np.uint8)
    frame = Frame("0", rgb, np.tile(depth, (48, 1)), CAMERA, T)
    return Sight.of(frame, look_of(rgb), UP)


@pytest.fixture(scope="module")
def sights() -> list[tuple[int, Sight]]:
    """Views of three rooms in a row, all around from spots of each."""
    rng = np.random.default_rng(0)
    spots = [(room, *rng.uniform(0.5, 3.5, 2)) for room in range(3) for _ in range(8)]
    return [
        (room, view(room, x, y, 2 * np.pi * k / N_HEADINGS))
        for room, x, y in spots
        for k in range(N_HEADINGS)
    ]


def without_pose(sight: Sight) -> Sight:
    return Sight(sight.look)


@pytest.mark.parametrize("order", ["room by room", "at random"])
def test_rooms_that_a_door_joins_are_places(sights, order: str) -> None:
    chance = np.random.default_rng(1)
    indices = np.arange(len(sights)) if order == "room by room" else chance.permutation(len(sights))
    places = Places()
    spots = np.array([places.add(sights[index][1]) for index in indices])
    rooms = np.array([sights[index][0] for index in indices])
    found = places.place_of_spot[spots]
    assert places.n_places == 3
    assert all(len(set(found[rooms == room])) == 1 for room in range(3))
    assert places.n_views.tolist() == [48, 48, 48]


def test_a_pose_tells_the_place_also_where_nobody_stood(sights) -> None:
    places = Places()
    spots = [(room, places.add(sight)) for room, sight in sights]
    room_of_place = {int(places.place_of_spot[spot]): room for room, spot in spots}
    for room in range(3):
        new = view(room, 2.1, 1.3, 0.4)
        weights = places.locate(new.T_world_camera, new.look)
        assert weights.sum() == pytest.approx(1)
        assert room_of_place[int(weights.argmax())] == room
        assert weights.max() > 0.9


def test_a_look_tells_the_place_where_there_is_no_pose_or_one_of_another_world(sights) -> None:
    places = Places()
    for _, sight in sights:
        places.add(sight)
    for room, sight in sights[:: len(sights) // 9]:
        there = places.locate(sight.T_world_camera, sight.look).argmax()
        other = pose((2 - room) * (ROOM + WALL) + 2 + (room == 1) * 4, 2, 0)
        assert places.locate(None, sight.look).argmax() == there
        assert places.locate(other, sight.look).argmax() == there


def test_views_without_poses_are_of_places_that_look_alike(sights) -> None:
    places = Places()
    spots = np.array([places.add(without_pose(sight)) for _, sight in sights])
    found, rooms = places.place_of_spot[spots], np.array([room for room, _ in sights])
    assert all(len(set(rooms[found == place])) == 1 for place in set(found))


def test_no_more_places_than_allowed(sights) -> None:
    places = Places(max_places=2)
    for _, sight in sights:
        places.add(sight)
        assert places.n_places <= 2
    with pytest.raises(ValueError, match="max_places: expected 1 or more, got 0"):
        Places(0)


def test_nothing_known_is_no_place() -> None:
    assert Places().locate(np.eye(4), np.zeros(LOOK_SIZE, np.uint8)).shape == (0,)


def test_memory_of_a_spot_is_bounded(sights) -> None:
    places = Places()
    for _ in range(5):
        for _, sight in sights[:N_HEADINGS]:
            places.add(sight)
    assert len(places.state_arrays()["places_looks"]) == MAX_LOOKS_PER_SPOT


def test_spots_have_an_end_beyond_which_the_nearest_counts(sights, monkeypatch) -> None:
    monkeypatch.setattr(module, "MAX_SPOTS", 5)
    places = Places(4)
    spots = [places.add(sight) for _, sight in sights]
    assert set(spots) == set(range(5))
    assert len(places.place_of_spot) == 5
    assert places.n_views.sum() == len(sights)
    n_cells = len(places.state_arrays()["places_cells"])
    far = Sight(sights[0][1].look, pose(500.0, 1.0, 0.0), sights[0][1].rays, UP)
    assert places.add(far) in range(5)
    assert len(places.state_arrays()["places_cells"]) == n_cells


def test_what_is_restored_tells_the_same(sights) -> None:
    places, again = Places(), Places()
    for _, sight in sights[:60]:
        places.add(sight)
    again.restore(places.state_arrays())
    for _, sight in sights[60:]:
        weights = places.locate(sight.T_world_camera, sight.look)
        np.testing.assert_array_equal(again.locate(sight.T_world_camera, sight.look), weights)
        assert places.add(sight) == again.add(sight)
    np.testing.assert_array_equal(places.place_of_spot, again.place_of_spot)


@pytest.mark.parametrize("name", ["places_seen", "places_views", "places_spot_of_look"])
def test_damaged_places_are_refused(sights, name: str) -> None:
    places = Places()
    places.add(sights[0][1])
    arrays = dict(places.state_arrays())
    arrays[name] = np.append(arrays[name], arrays[name].dtype.type(9999))
    with pytest.raises(ValueError, match="places"):
        Places().restore(arrays)
    del arrays[name]
    with pytest.raises(ValueError, match=name):
        Places().restore(arrays)


def test_a_camera_sees_the_free_cells_before_it() -> None:
    axes = ground_axes(UP)
    sight = view(0, 0.6, 2.0, 0.0)
    seen = {tuple(cell) for cell in sight.cells(axes).tolist()}

    def cell(x: float, y: float) -> tuple[int, int]:
        return cell_of(pose(x, y, 0), axes)

    assert cell(0.6, 2.0) in seen
    assert cell(2.5, 2.0) in seen
    assert cell(0.6 - 2 * CELL, 2.0) not in seen
    assert cell(6.0, 0.7) not in seen, "behind the wall"


def test_looks_of_the_same_colours_are_alike() -> None:
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (60, 80, 3), np.uint8)
    one, flipped, other = look_of(rgb), look_of(rgb[:, ::-1]), look_of(np.zeros_like(rgb))
    alike = Looks(np.stack([one, flipped, other])).likeness(one)
    assert alike[0] == pytest.approx(1, abs=1e-3)
    assert alike[1] > 0.95 > 0.5 > alike[2]


def test_links_are_joined_by_their_average() -> None:
    links = np.full((5, 5), 0.05)
    links[:2, :2] = links[2:, 2:] = 0.6
    assert join_linked(links, 0.1, 9).tolist() in ([0, 0, 1, 1, 1], [1, 1, 0, 0, 0])
    assert set(join_linked(links, 0.1, 1).tolist()) == {0}
    assert set(join_linked(links, 0.01, 9).tolist()) == {0}
    assert join_linked(np.ones((1, 1)), 0.1, 9).tolist() == [0]


def test_spots_see_each_other_by_plain_sets() -> None:
    rng = np.random.default_rng(0)
    sees = [np.unique(rng.integers(0, 30, 12)) for _ in range(6)]
    own = rng.integers(0, 30, 6)
    links = seen_by_each_other(sees, own, 30)
    for i, one in enumerate(sees):
        for j, two in enumerate(sees):
            common = len(set(one) & set(two)) / len(set(one) | set(two))
            direct = own[j] in one or own[i] in two
            assert links[i, j] == pytest.approx(1 if direct else common)


def test_views_share_those_most_like_them_by_plain_sets() -> None:
    rng = np.random.default_rng(0)
    alike = rng.random((12, 12))
    alike = (alike + alike.T) / 2
    links = shared_likes(alike)
    nearest = [
        sorted((j for j in range(12) if j != i), key=lambda j: -alike[i, j])[:5] for i in range(12)
    ]
    for i in range(12):
        for j in range(12):
            shared = len({i, *nearest[i]} & {j, *nearest[j]}) / 6
            mutual = ((j in nearest[i]) + (i in nearest[j])) / 2
            assert links[i, j] == pytest.approx(max(shared, mutual))


def test_numbers_stay_with_most_of_their_members() -> None:
    groups = np.array([0, 0, 0, 1, 1, 2])
    before = np.array([1, 1, 0, 0, 0, -1])
    weights = np.ones(6, np.int64)
    assert keep_numbers(groups, before, weights).tolist() == [1, 1, 1, 0, 0, 2]
    none_yet = np.full(6, -1)
    assert keep_numbers(groups, none_yet, weights).tolist() == groups.tolist()
    # A number that nobody keeps is taken over: there are no gaps.
    assert keep_numbers(np.zeros(3, np.int64), np.array([2, 1, 0]), np.ones(3)).tolist() == [0] * 3


def test_look_counts_colours_as_opencv_does() -> None:
    image = np.random.default_rng(4).integers(0, 256, (120, 160, 3), np.uint8)
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB)
    lab[..., 1:] = np.clip(lab[..., 1:], LOW, HIGH)
    counts = cv2.calcHist([lab], [0, 1, 2], None, BINS, RANGES).ravel()
    expected = np.rint(255 * np.sqrt(counts / counts.sum())).astype(np.uint8)
    np.testing.assert_array_equal(look_of(image), expected)


def test_kept_looks_are_compared_as_the_plain_formula_says() -> None:
    rng = np.random.default_rng(9)
    expected = rng.integers(0, 90, (40, LOOK_SIZE)).astype(np.uint8)
    kept = Looks(expected[:3])
    for look in expected[3:]:
        kept.append(look)
    kept.remove(5)
    kept.replace(7, expected[0])
    expected = np.delete(expected, 5, axis=0)
    expected[7] = expected[0]
    np.testing.assert_array_equal(kept.array(), expected)
    assert len(kept) == 39
    one, many = expected[11].astype(float), expected.astype(float)
    alike = many @ one / (np.linalg.norm(many, axis=1) * np.linalg.norm(one))
    np.testing.assert_allclose(kept.likeness(expected[11]), alike, rtol=1e-5)
    assert kept.likeness(expected[11]).argmax() == 11


@pytest.mark.parametrize("axis", range(3))
def test_axes_of_the_ground_hardly_turn_with_noise(axis: int) -> None:
    rng = np.random.default_rng(0)
    for sign in (-1, 1):
        ups = sign * np.eye(3)[axis] + rng.normal(0, 0.02, (50, 3))
        axes = [ground_axes(up / np.linalg.norm(up)) for up in ups]
        assert np.ptp(axes, axis=0).max() < 0.2
