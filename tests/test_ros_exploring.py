"""Exploring, without ROS: where a robot may go, what became of it, when it ends."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest

from curiosight.explorer import Strategy, make_strategy
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Viewpoint
from curiosight.robot.ros.detections import detect
from curiosight.robot.ros.exploring import Exploring, GoTo, Phase, Reason, Rules, Stop
from curiosight.robot.ros.falling import Falling
from curiosight.robot.ros.goals import FloorMap, Place, views_from
from curiosight.robot.ros.missing import Quality, Seen, TopicSeen
from curiosight.robot.ros.squares import Squares

HOME = Place(9.0, 9.0, 0.0)


def test_spots_are_ranked_by_how_salient_they_are() -> None:
    saliency = np.zeros((60, 80), np.float32)
    saliency[5:15, 10:30] = 0.7
    saliency[30:50, 40:50] = 0.9
    saliency[58, 2] = 1.0  # too small
    found = detect(saliency, min_share=0.01)
    assert [one.box for one in found] == [(40, 30, 10, 20), (10, 5, 20, 10)]
    assert [one.score for one in found] == pytest.approx([0.9, 0.7])
    assert detect(np.zeros((60, 80), np.float32)) == []


def test_spots_that_touch_at_a_corner_are_one() -> None:
    saliency = np.zeros((20, 20), np.float32)
    saliency[:10, :10] = saliency[10:, 10:] = 1
    assert [one.box for one in detect(saliency)] == [(0, 0, 20, 20)]


def test_squares_keep_their_numbers_and_their_errors() -> None:
    squares = Squares(2.0)
    first, second = squares.at(0.1, 0.1), squares.at(-0.1, 3.9)
    assert (first, second, squares.at(1.9, 1.9)) == (0, 1, 0)
    assert squares.centre(second) == (-1.0, 3.0)
    for error in (0.8, 0.6):
        squares.note(first, error)
    squares.note(second, None)
    assert squares.error() == pytest.approx(0.7)
    assert squares[second].error is None
    assert squares[second].n_looks == 1


def test_grid_tells_percent_of_fall_and_where_it_lies() -> None:
    squares = Squares(2.0)
    assert squares.grid() is None
    falling, rising = squares.at(5.0, 1.0), squares.at(1.0, 3.0)
    for number in range(11):
        squares.note(falling, 0.9 - 0.05 * number)
        squares.note(rising, 0.1 + 0.05 * number)
    squares.at(3.0, 1.0)
    grid = squares.grid()
    assert grid is not None
    assert grid.origin == (0.0, 0.0)
    np.testing.assert_array_equal(grid.values, [[-1, -1, 50], [0, -1, -1]])


def test_falling_ends_after_its_patience_and_anew_with_each_region() -> None:
    falling = Falling(patience=3, min_fall=0.05)
    for error in (0.9, 0.8, 0.78, 0.76):
        falling.note(0, error)
    assert not falling.has_stopped
    falling.note(1, 0.85)  # a new region
    for _ in range(2):
        falling.note(1, 0.84)
    assert not falling.has_stopped
    falling.note(0, None)
    assert falling.has_stopped


def free_floor() -> FloorMap:
    """Return two rooms of 2 x 2 m, with a wall between, and the unknown beyond."""
    cells = np.full((24, 48), -1, np.int8)
    cells[2:22, 2:22] = 0
    cells[2:22, 26:46] = 0
    return FloorMap(cells, 0.1, Place(-1.0, 2.0, 0.0))


def test_places_are_free_clear_and_joined_to_the_robot() -> None:
    places = free_floor().reachable((-0.5, 2.5), clearance=0.3, spacing=0.5)
    assert len(places) >= 9
    assert places[:, 0].min() >= -0.8 + 0.2
    assert places[:, 0].max() <= 1.2 - 0.2
    assert (
        np.abs(places[:, None] - places[None]).max(axis=2)[np.triu_indices(len(places), 1)].min()
        > 0.1
    )
    right = free_floor().reachable((3.0, 3.0), clearance=0.3, spacing=0.5)
    assert right[:, 0].min() >= 1.6


def test_no_place_is_clear_where_the_rooms_are_narrow() -> None:
    assert len(free_floor().reachable((0.0, 3.0), clearance=1.5, spacing=0.5)) == 0


def test_turned_map_turns_its_places() -> None:
    cells = np.zeros((10, 30), np.int8)
    turned = FloorMap(cells, 0.1, Place(0.0, 0.0, math.pi / 2))
    places = turned.reachable((-0.5, 1.0), clearance=0.1, spacing=0.5)
    assert places[:, 1].max() > 2
    assert places[:, 0].min() >= -1
    assert places[:, 0].max() <= 0


def test_views_look_in_all_directions_from_where_the_robot_stands() -> None:
    T_base_camera = np.eye(4)
    T_base_camera[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    T_base_camera[0, 3] = 0.2
    squares = Squares(1.0)
    views, stands = views_from(np.array([[0.5, 0.5]]), squares, T_base_camera, z=0.1)
    assert [view.region for view in views] == [0, 0, 0, 0]
    for view in views:
        pose, place = view.T_world_camera, stands[view.index]
        assert pose is not None
        heading = math.cos(place.yaw), math.sin(place.yaw), 0.0
        np.testing.assert_allclose(pose[:3, 2], heading, atol=1e-12)
        np.testing.assert_allclose(
            pose[:3, 3], [0.5 + 0.2 * heading[0], 0.5 + 0.2 * heading[1], 0.1]
        )


def exploring(rules: Rules | None = None, home: Place | None = HOME) -> Exploring:
    squares = Squares(1.0)
    places = np.array([[x + 0.5, 0.5] for x in range(4)])
    views, stands = views_from(places, squares, np.eye(4), n_headings=2)
    return Exploring(_strategy, views, stands, squares, home, rules or Rules(looks=2), 0.0)


def _strategy(views: tuple[Viewpoint, ...]) -> Strategy:
    return make_strategy("random", views, np.random.default_rng(0))


def drive(explorer: Exploring, now: float, *, looks: Iterable[float] = (0.5, 0.5)) -> GoTo:
    """Go to the next goal, and look there."""
    command = explorer.next(now)
    assert isinstance(command, GoTo)
    explorer.answered(command.number, True)
    explorer.arrived(command.number, now + 5)
    for error in looks:
        explorer.look(0, Outcome(error), now + 6)
    return command


def test_goals_are_driven_looked_at_and_timed() -> None:
    explorer = exploring()
    command = drive(explorer, 10.0)
    assert explorer.phase is Phase.CHOOSING
    assert explorer.n_reached == 1
    assert explorer.travels == [5.0]
    assert command.place.x in (0.5, 1.5, 2.5, 3.5)


def test_looks_on_the_way_are_not_those_of_the_goal() -> None:
    explorer = exploring()
    command = explorer.next(0.0)
    assert isinstance(command, GoTo)
    explorer.answered(command.number, True)
    explorer.look(0, Outcome(0.5), 1.0)
    explorer.arrived(command.number, 5.0)
    explorer.look(0, Outcome(0.5), 4.9)  # was taken before
    explorer.look(0, Outcome(0.5), 5.1)
    assert explorer.phase is Phase.LOOKING
    explorer.look(0, Outcome(0.5), 5.2)
    assert explorer.phase is Phase.CHOOSING


@pytest.mark.parametrize("is_refused", [True, False])
def test_goals_that_are_not_reached_are_left_alone(is_refused: bool) -> None:
    explorer = exploring()
    seen = []
    for now in range(4):
        command = explorer.next(float(now))
        assert isinstance(command, GoTo)
        seen.append(command.place.x)
        explorer.answered(command.number, not is_refused)
        if not is_refused:
            explorer.arrived(command.number, now + 0.5, failure="not reached (error 9000)")
    assert sorted(seen) == [0.5, 1.5, 2.5, 3.5]  # both headings of a place are given up at once
    assert explorer.n_failed == 4
    home = explorer.next(5.0)
    assert isinstance(home, GoTo)
    assert home.place == HOME
    explorer.answered(home.number, True)
    explorer.arrived(home.number, 9.0)
    assert explorer.ending is not None
    assert explorer.ending.reason is Reason.NOWHERE_TO_GO
    assert explorer.ending.is_home


def test_goal_that_others_cancelled_is_tried_again() -> None:
    explorer = exploring()
    command = explorer.next(0.0)
    assert isinstance(command, GoTo)
    explorer.answered(command.number, True)
    explorer.arrived(command.number, 1.0, failure="cancelled by others", by_others=True)
    assert explorer.left_alone == {}
    assert explorer.n_failed == 1


@pytest.mark.parametrize(("is_accepted", "after_s"), [(True, 121.0), (False, 11.0)])
def test_drive_without_end_or_answer_is_stopped(is_accepted: bool, after_s: float) -> None:
    explorer = exploring()
    command = explorer.next(0.0)
    assert isinstance(command, GoTo)
    if is_accepted:
        explorer.answered(command.number, True)
    assert explorer.next(after_s - 2) is None
    assert explorer.next(after_s) == Stop(command.number)
    assert len(explorer.left_alone) == 2
    explorer.arrived(command.number, 130.0)  # too late
    assert explorer.n_reached == 0


def test_it_ends_when_the_error_stops_falling_and_goes_home() -> None:
    explorer = exploring(Rules(looks=1, patience=5))
    n_goals = 0
    for now in range(0, 200, 10):
        command = explorer.next(float(now))
        assert isinstance(command, GoTo)
        explorer.answered(command.number, True)
        explorer.arrived(command.number, now + 5.0)
        if command.place == HOME:
            break
        n_goals += 1
        explorer.look(0, Outcome(0.5), now + 6.0)
    assert n_goals == 6  # the first look begins to count
    assert explorer.ending is not None
    assert explorer.ending.reason is Reason.ERROR_STOPPED_FALLING
    assert explorer.ending.is_home
    assert "the robot is home" in explorer.ending.text


def test_it_ends_when_its_time_is_up_even_where_home_cannot_be_reached() -> None:
    explorer = exploring(Rules(looks=1, max_s=30.0))
    drive(explorer, 10.0, looks=(0.5,))
    home = explorer.next(31.0)
    assert isinstance(home, GoTo)
    assert explorer.why() == "home, as its time is up"
    explorer.answered(home.number, False)
    assert explorer.ending is not None
    assert explorer.ending.reason is Reason.OUT_OF_TIME
    assert not explorer.ending.is_home
    assert "the way home: refused by the navigation" in explorer.ending.text


def test_goals_where_nothing_is_compared_end_it() -> None:
    explorer = exploring(home=None)
    for now in range(0, 500, 100):
        drive(explorer, float(now), looks=())
        assert explorer.next(now + 10.0) is None
        assert explorer.phase is Phase.LOOKING
        assert explorer.next(now + 25.0) is None
        assert explorer.phase is Phase.CHOOSING
    assert explorer.next(1000.0) is None
    assert explorer.ending is not None
    assert explorer.ending.reason is Reason.NOWHERE_TO_GO
    assert "no frame could be compared" in explorer.ending.text


def test_cancelling_stops_the_drive() -> None:
    explorer = exploring()
    command = explorer.next(0.0)
    assert isinstance(command, GoTo)
    assert explorer.cancel() == Stop(command.number)
    assert explorer.ending is not None
    assert explorer.ending.reason is Reason.CANCELED
    assert explorer.next(1.0) is None


def test_navigation_that_comes_back_is_asked_again() -> None:
    explorer = exploring()
    command = explorer.next(0.0)
    assert isinstance(command, GoTo)
    explorer.answered(command.number, True)
    explorer.interrupted()
    again = explorer.next(3.0)
    assert isinstance(again, GoTo)
    assert again.number > command.number
    assert explorer.left_alone == {}
    explorer.lost_navigation()
    assert explorer.ending is not None
    assert explorer.ending.reason is Reason.NO_NAVIGATION


def test_strategy_may_be_changed_on_the_way() -> None:
    explorer = exploring()
    drive(explorer, 0.0)
    made: list[int] = []

    def sweep(views: tuple[Viewpoint, ...]) -> Strategy:
        made.append(len(views))
        return make_strategy("sweep:all", views, np.random.default_rng(0))

    explorer.change_strategy(sweep)
    drive(explorer, 10.0)
    assert made == [8]


BEST, SURE = Quality("best_effort", "volatile"), Quality("reliable", "volatile")
LATCHED = Quality("reliable", "transient_local")


def topic(**fields: object) -> TopicSeen:
    known: dict[str, object] = {
        "name": "/image", "what": "colour", "kind": "sensor_msgs/msg/Image", "asked": BEST,
        "kinds": ["sensor_msgs/msg/Image"], "offers": [BEST], "n": 5, "silent_s": 0.1,
    }  # fmt: skip
    return TopicSeen(**known | fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({}, None),
        ({"kinds": []}, "no publisher on /image (colour); of this type there is /other"),
        (
            {"kinds": ["sensor_msgs/msg/CompressedImage"]},
            "/image (colour) is sensor_msgs/msg/CompressedImage, not sensor_msgs/msg/Image",
        ),
        (
            {"asked": SURE, "silent_s": None, "n": 0},
            "QoS does not fit on /image (colour): reliability best_effort is offered, reliable "
            "asked for",
        ),
        (
            {"asked": LATCHED, "offers": [SURE], "silent_s": None},
            "QoS does not fit on /image (colour): durability volatile is offered, "
            "transient_local asked for",
        ),
        (
            {"policies": ["DEADLINE"], "silent_s": None},
            "QoS does not fit on /image (colour): deadline differs",
        ),
        ({"silent_s": None}, "nothing comes on /image (colour), though it has a publisher"),
        ({"silent_s": 3.2}, "/image (colour) has been silent for 3 s"),
        ({"silent_s": 60.0, "is_once": True}, None),
        (
            {"ahead_s": -1e6},
            "/image (colour) is stamped 1000000 s behind this node's clock: use_sim_time?",
        ),
    ],
)
def test_what_is_wrong_with_a_topic_is_said(fields: dict[str, object], said: str | None) -> None:
    assert topic(**fields).missing(["/other", "/image"]) == said


def test_what_is_missing_is_listed() -> None:
    seen = Seen(
        [topic(), topic(name="/depth", what="depth", kinds=[])],
        apart_s=0.5,
        tf="no tf from map to camera: nothing comes on /tf or /tf_static",
        refused={
            "/curiosight/saliency": "durability volatile is offered, transient_local asked for"
        },
        lacks={"no depth within 20 ms": 4},
    )
    missing = seen.missing()
    assert missing == [
        "no publisher on /depth (depth)",
        "stamps of colour and depth are 0.500 s apart, 0.02 s at most are allowed (max_stamp_gap)",
        "no tf from map to camera: nothing comes on /tf or /tf_static",
        "QoS does not fit on /curiosight/saliency, which somebody wants to read: durability "
        "volatile is offered, transient_local asked for",
        "4 frames taught nothing: no depth within 20 ms",
    ]
    assert Seen([topic()], apart_s=0.01).missing() == []
