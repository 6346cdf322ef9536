"""Replayed recordings as worlds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from curiosight.datasets.dataset import Dataset
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.regions import time_regions
from curiosight.explorer.strategies import Chronological, Iac
from curiosight.frame import Camera, Frame, Pose, Viewpoint
from curiosight.worlds.check import check_world
from curiosight.worlds.replay import ReplayWorld
from curiosight.worlds.travel import Odometer, straight_ways, travel
from curiosight.worlds.world import World
from room import poses_around


class TinyRecording:
    """Hold frames in memory: frame i is all of grey i, seen from (i, 0, 0)."""

    name = "tiny"
    camera = None
    has_depth = False
    remarks: tuple[str, ...] = ()

    def __init__(self, n_frames: int = 10) -> None:
        self.ids = [str(index) for index in range(n_frames)]
        self.poses: list[Pose | None] = [np.eye(4) for _ in range(n_frames)]
        for index, pose in enumerate(self.poses):
            pose[0, 3] = index
        self.poses[3] = None
        self.read: list[int] = []

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        self.read.append(index)
        rgb = np.full((4, 6, 3), index, np.uint8)
        return Frame(self.ids[index], rgb, T_world_camera=self.poses[index])

    def has_ground_truth(self, index: int) -> bool:
        return False

    def ground_truth(self, index: int) -> None:
        return None


def replay(dataset: Dataset, **options) -> ReplayWorld:
    return ReplayWorld(dataset, time_regions(len(dataset), 5).of_view, **options)


def look(world: World, viewpoint: Viewpoint) -> Frame:
    world.move_to(viewpoint)
    return world.capture()


def test_replay_keeps_the_contract() -> None:
    with replay(TinyRecording()) as world:
        check_world(world)


def test_replay_shows_each_viewpoints_frame() -> None:
    dataset = TinyRecording()
    with replay(dataset) as world:
        assert [view.index for view in world.views] == list(range(10))
        assert [view.region for view in world.views] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
        assert world.views[3].T_world_camera is None
        assert world.views[4].T_world_camera is dataset.poses[4]
        assert [look(world, view).rgb[0, 0, 0] for view in world.views] == list(range(10))


def test_a_move_costs_the_way_and_the_turn() -> None:
    dataset = TinyRecording()
    dataset.poses[1][:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    with replay(dataset) as world:
        first, turned, there, unposed = world.views[0], world.views[1], *world.views[2:4]
        assert world.move_to(first) == 0.0
        assert world.move_to(turned) == pytest.approx(1 / 0.5 + 90 / 60)
        assert world.move_to(turned) == 0.0
        assert world.move_to(unposed) == 0.0
        assert world.move_to(there) == 0.0


def test_nothing_is_seen_before_the_first_move() -> None:
    with replay(TinyRecording()) as world, pytest.raises(ValueError, match="`move_to` before"):
        world.capture()


def test_replay_of_a_part_keeps_the_recordings_numbers() -> None:
    with replay(TinyRecording(), indices=[8, 2]) as world:
        assert [(view.index, view.region) for view in world.views] == [(8, 4), (2, 1)]
        assert look(world, world.views[0]).id == "8"


@pytest.mark.parametrize("looks_ahead", [True, False])
def test_looking_ahead_changes_no_frame(looks_ahead: bool) -> None:
    with replay(TinyRecording()) as world:
        strategy = Iac(world.views, np.random.default_rng(0))
        if looks_ahead:
            world.upcoming = strategy.upcoming
        for _ in range(100):
            viewpoint = strategy.choose()
            assert look(world, viewpoint).id == str(viewpoint.index)
            strategy.update(viewpoint, Outcome(0.5))


def test_upcoming_frames_are_decoded_once() -> None:
    dataset = TinyRecording()
    with replay(dataset) as world:
        strategy = Chronological(world.views)
        world.upcoming = strategy.upcoming
        for _ in range(30):
            look(world, strategy.choose())
    assert sorted(dataset.read) == list(range(10))


def test_bad_arguments_are_named() -> None:
    dataset = TinyRecording()
    with pytest.raises(ValueError, match="regions: expected one for each of 10 frames, got 9"):
        ReplayWorld(dataset, np.zeros(9, int))
    with pytest.raises(ValueError, match="indices: expected frames from 0 to 9"):
        replay(dataset, indices=[10])


class BrokenWorld:
    """Show a grey image everywhere; its views are for the tests to spoil."""

    def __init__(self, views: Sequence[Viewpoint], frame: object = None, cost: float = 0.0) -> None:
        self.views = views
        self.cost = cost
        self.frame = frame or Frame("0", np.zeros((4, 6, 3), np.uint8), T_world_camera=np.eye(4))

    def move_to(self, viewpoint: Viewpoint) -> float:
        return self.cost

    def capture(self) -> Frame:
        return self.frame  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("world", "complaint"),
    [
        (BrokenWorld([]), "at least one viewpoint"),
        (BrokenWorld([Viewpoint(1, 0), Viewpoint(1, 1)]), "index of its own"),
        (BrokenWorld([Viewpoint(0, -2)]), "region -1 or more"),
        (BrokenWorld([Viewpoint(0, 0, 2 * np.eye(4))]), "rigid pose at viewpoint 0"),
        (BrokenWorld([Viewpoint(0, 0, np.diag([-1.0, 1, 1, 1]))]), "rigid pose"),
        (BrokenWorld([Viewpoint(0, 0)], frame="picture"), "expected a Frame, got str"),
        (BrokenWorld([Viewpoint(0, 0)], cost=-1.0), "0 or more, got -1.0"),
        (BrokenWorld([Viewpoint(0, 0)], cost=float("nan")), "finite seconds"),
        (BrokenWorld([Viewpoint(7, 0, np.diag([-1.0, -1, 1, 1]))]), "viewpoint 7's pose"),
    ],
)
def test_contract_check_finds_what_is_broken(world: World, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        check_world(world)


class SteadyWorld(BrokenWorld):
    """Look from one pose at a wall of one depth, some of it without a reading."""

    def __init__(
        self, pose: Pose | None = None, *, depth: float = 2.0, missing: float = np.nan
    ) -> None:
        image = np.full((4, 6), depth, np.float32)
        image[0] = missing
        camera = Camera(6, 4, 5.0, 5.0, 2.5, 1.5)
        rgb = np.zeros((4, 6, 3), np.uint8)
        frame = Frame("here", rgb, image, camera, np.eye(4) if pose is None else pose)
        super().__init__([Viewpoint(0, 0, np.eye(4)), Viewpoint(1, 0, np.eye(4))], frame)


def test_a_robot_need_not_stand_quite_where_it_was_sent() -> None:
    check_world(SteadyWorld(pose(0.01, 1.0)))
    with pytest.raises(ValueError, match=r"viewpoint 0's pose within 0\.05 m"):
        check_world(SteadyWorld(pose(0.2, 0.0)))
    with pytest.raises(ValueError, match="got 0 m and 20 degrees off"):
        check_world(SteadyWorld(pose(0.0, 20.0)))
    check_world(SteadyWorld(pose(0.2, 20.0)), max_metres_off=0.3, max_degrees_off=30)
    with pytest.raises(ValueError, match=r"0\.005 m and 3 degrees"):
        check_world(SteadyWorld(pose(0.01, 1.0)), max_metres_off=0.005)


@pytest.mark.parametrize("missing", [0.0, -1.0, np.inf])
def test_no_reading_is_nan_and_nothing_else(missing: float) -> None:
    check_world(SteadyWorld())
    with pytest.raises(ValueError, match="depth of here: expected positive metres, NaN where"):
        check_world(SteadyWorld(missing=missing))


@pytest.mark.parametrize("depth", [2000.0, 0.002])
def test_depth_is_in_metres(depth: float) -> None:
    with pytest.raises(ValueError, match=r"expected metres, with a median between 0\.05 and 50"):
        check_world(SteadyWorld(depth=depth))


@pytest.mark.parametrize("cost", [None, "3 s", [1.0], True, 1j, float("inf")])
def test_cost_is_a_number_of_seconds(cost: object) -> None:
    world = SteadyWorld()
    world.cost = cost  # type: ignore[assignment]
    with pytest.raises(ValueError, match=r"move_to: expected finite seconds, 0 or more, got "):
        check_world(world)


@pytest.mark.parametrize("cost", [0, 2, np.float32(1.5), np.int64(3)])
def test_cost_is_a_number_of_any_type(cost: float) -> None:
    world = SteadyWorld()
    world.cost = cost
    check_world(world)


@pytest.mark.parametrize(
    "view",
    [
        None,
        Viewpoint(0, None),  # type: ignore[arg-type]
        Viewpoint([0], 0),  # type: ignore[arg-type]
        Viewpoint(0, 0, "here"),  # type: ignore[arg-type]
        Viewpoint(0, 0, np.eye(3)),
    ],
)
def test_strange_views_are_told_from_views(view: Viewpoint) -> None:
    with pytest.raises(ValueError, match="views: expected"):
        check_world(BrokenWorld([view]))
    with pytest.raises(ValueError, match="views: expected a sequence of viewpoints, got NoneType"):
        check_world(BrokenWorld(None))  # type: ignore[arg-type]


def pose(x: float, turn_deg: float) -> np.ndarray:
    """Stand at (x, 0, 0) and turn about the vertical."""
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    return np.array([[c, 0, s, x], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("turn_deg", [0, 1e-7, 30, 90, 179, 180])
def test_travel_is_distance_and_turn(turn_deg: float) -> None:
    metres, degrees = travel(pose(1, 10), pose(3, 10 + turn_deg))
    assert metres == pytest.approx(2)
    assert degrees == pytest.approx(turn_deg, abs=1e-9)


def test_odometer_sums_and_passes_over_unknown_poses() -> None:
    odometer = Odometer()
    for T_world_camera in (None, pose(0, 0), None, pose(2, 90), pose(1, 0), None):
        odometer.add(T_world_camera)
    assert odometer.metres == pytest.approx(3)
    assert odometer.degrees == pytest.approx(180)


def test_straight_ways_are_those_of_travel_one_by_one() -> None:
    poses = poses_around(7)
    views = [Viewpoint(index, 0, pose) for index, pose in enumerate([*poses, None])]
    metres, degrees = straight_ways(views[2], views)
    assert (metres[-1], degrees[-1]) == (0, 0), "nobody knows"
    for number, pose in enumerate(poses):
        expected = travel(poses[2], pose)
        assert (metres[number], degrees[number]) == pytest.approx(expected, abs=1e-9)
    assert (metres[2], degrees[2]) == (0, pytest.approx(0, abs=1e-6))
    assert [part.tolist() for part in straight_ways(views[-1], views[:2])] == [[0, 0], [0, 0]]
    assert [len(part) for part in straight_ways(views[0], [])] == [0, 0]
