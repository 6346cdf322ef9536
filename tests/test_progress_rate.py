"""What views would show, what a look is worth, and where progress-rate goes for it."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.explorer.check import check_strategy
from curiosight.explorer.outcome import MAX_RANGE, Outcome, Seen
from curiosight.explorer.outlook import N_ACROSS, Outlook
from curiosight.explorer.paths import Alikeness, plan_path
from curiosight.explorer.progress_rate import ProgressRate
from curiosight.explorer.worth import Learnability, Worth
from curiosight.frame import Camera, Frame, Label, Pose, Viewpoint

CAMERA = Camera(64, 48, 52.5, 52.5, 31.5, 23.5)
EVERYWHERE = np.ones(1, np.bool_)
FIRST = np.arange(1)


def at(x: float, *, turned_deg: float = 0.0) -> Pose:
    """Return a camera that looks along z, beside the origin, turned to its right."""
    pose, angle = np.eye(4), np.radians(turned_deg)
    pose[:3, :3] = [
        [np.cos(angle), 0, np.sin(angle)],
        [0, 1, 0],
        [-np.sin(angle), 0, np.cos(angle)],
    ]
    pose[0, 3] = x
    return pose


def wall(pose: Pose, depth: float, label: Label) -> Seen:
    """Return what a camera sees of a wall at right angles to its axis."""
    readings = np.full((48, 64), depth, np.float32)
    frame = Frame("wall", np.zeros((48, 64, 3), np.uint8), readings, CAMERA, pose)
    seen = Seen.of(frame, np.full((48, 64), label, np.uint8))
    assert seen is not None
    return seen


def test_seen_are_the_points_in_range_in_the_world() -> None:
    pose = at(2.0, turned_deg=90)
    points = wall(pose, 1.5, Label.SALIENT).points
    assert len(points) == 64 * 48
    np.testing.assert_allclose(points[:, 0], 3.5, atol=1e-5)  # along x from 2
    assert np.ptp(points[:, 2]) == pytest.approx(63 / 52.5 * 1.5, rel=1e-4)
    assert len(wall(pose, MAX_RANGE + 0.1, Label.SALIENT).points) == 0


def test_a_view_knows_what_another_from_the_same_place_saw() -> None:
    outlook = Outlook([at(0), at(0, turned_deg=180), None])
    outlook.add(wall(at(0), 2.0, Label.SALIENT), at(0), np.ones(3, np.bool_))
    assert outlook.is_known(FIRST)[0].mean() > 0.95
    np.testing.assert_allclose(outlook.depth[0][outlook.is_known(FIRST)[0]], 2.0, atol=1e-5)
    assert outlook.is_salient(FIRST)[0][outlook.is_known(FIRST)[0]].all()
    assert not outlook.is_known(np.array([1, 2])).any()  # it looks away; nobody knows where that is
    np.testing.assert_allclose(outlook.n_seen[0][outlook.is_known(FIRST)[0]], 1.0, atol=1e-5)


def test_half_a_turn_shows_half_of_it() -> None:
    outlook = Outlook([at(0, turned_deg=35)])
    outlook.add(wall(at(0), 2.0, Label.NOT_SALIENT), at(0), EVERYWHERE)
    known = outlook.is_known(FIRST)[0].reshape(-1, N_ACROSS).mean(axis=0)
    assert (known[:10] > 0.7).all()
    assert (known[-10:] == 0).all()


def test_the_same_surface_from_the_side_is_less_seen() -> None:
    other_side = at(-2.5, turned_deg=60)
    outlook = Outlook([at(0)])
    outlook.add(wall(at(0), 2.0, Label.SALIENT), other_side, EVERYWHERE)
    assert outlook.n_seen[0].max() < 0.6


def test_what_is_nearer_hides_what_was_known() -> None:
    outlook = Outlook([at(0)])
    for depth, label in ((3.0, Label.NOT_SALIENT), (1.0, Label.SALIENT), (3.0, Label.NOT_SALIENT)):
        outlook.add(wall(at(0), depth, label), at(0), EVERYWHERE)
    middle = outlook.depth[0] == 1.0
    assert middle.mean() > 0.9
    np.testing.assert_allclose(outlook.n_seen[0][middle], 1.0, atol=1e-5)
    assert outlook.is_salient(FIRST)[0][middle].all()


def test_things_are_worth_more_and_less_each_time() -> None:
    worth = Worth()
    fresh = []
    for label in (Label.SALIENT, Label.NOT_SALIENT):
        outlook = Outlook([at(0)])
        of_label = [worth.of(outlook, np.arange(1))[0][0]]
        for _ in range(3):
            outlook.add(wall(at(0), 2.0, label), at(0), EVERYWHERE)
            of_label.append(worth.of(outlook, np.arange(1))[0][0])
        fresh.append(of_label)
    salient, other = fresh
    assert salient[0] == other[0] == pytest.approx(np.sqrt(worth.unknown))
    assert salient[1] > salient[0] > other[1]
    assert salient[1] > salient[2] > salient[3]
    assert worth.of(outlook, np.arange(1))[1][0] == 0  # it shows no thing


def test_only_what_is_hardly_predicted_is_worth_less() -> None:
    learnability = Learnability(3)
    for _ in range(12):
        for region, error in enumerate((0.2, 0.35, 0.95)):
            learnability.add(region, error)
    good, fair, bad = learnability.of_regions()
    assert good == fair == 1
    assert bad < 0.2
    learnability.forget(2)
    assert learnability.of_regions()[2] > 0.5


def views(n_regions: int, n_each: int) -> list[Viewpoint]:
    """Return views in rooms 10 m apart."""
    return [
        Viewpoint(region * 100 + number, region, at(10.0 * region + 0.2 * number))
        for region in range(n_regions)
        for number in range(n_each)
    ]


def straight(start: Viewpoint, goals: list[Viewpoint]) -> np.ndarray:
    assert start.T_world_camera is not None
    return np.array([abs(goal.T_world_camera[0, 3] - start.T_world_camera[0, 3]) for goal in goals])


def looked(
    strategy: ProgressRate, errors: dict[int, float], n_looks: int, *, is_blind: bool = False
) -> list[int]:
    """Let a strategy look; return the regions. Errors are those of each region.

    is_blind: without depth, so that each view may show anything.
    """
    regions = []
    for _ in range(n_looks):
        view = strategy.choose()
        regions.append(view.region)
        seen = None if is_blind else wall(view.T_world_camera, 2.0, Label.SALIENT)
        strategy.update(view, Outcome(errors[view.region], seen=seen))
    return regions


def test_it_keeps_the_contract() -> None:
    check_strategy(lambda given, rng: ProgressRate(given, rng))


def test_every_room_is_tried_and_none_is_hopped_to_and_fro() -> None:
    strategy = ProgressRate(views(4, 20), np.random.default_rng(0), ways=straight)
    regions = looked(strategy, dict.fromkeys(range(4), 0.4), 60)
    assert set(regions) == {0, 1, 2, 3}
    n_hops = np.count_nonzero(np.diff(regions))
    assert n_hops <= 20


@pytest.mark.parametrize(("apart", "longest", "shortest"), [(30.0, 15, 15), (0.3, 5, 1)])
def test_stays_are_as_long_as_the_way_asks(apart: float, longest: int, shortest: int) -> None:
    given = [
        Viewpoint(region * 100 + number, region, at(apart * region + 0.1 * number))
        for region in range(4)
        for number in range(20)
    ]
    strategy = ProgressRate(given, np.random.default_rng(0), ways=straight)
    regions = np.array(looked(strategy, dict.fromkeys(range(4), 0.4), 120))
    stays = np.diff(np.flatnonzero(np.diff(regions)))
    assert stays.max() <= longest
    assert np.median(stays) >= shortest
    assert set(regions) == {0, 1, 2, 3}


def test_looks_that_others_chose_make_no_stay_shorter() -> None:
    given = views(4, 20)
    strategy = ProgressRate(given, np.random.default_rng(0), ways=straight)
    for view in (given[index] for index in (0, 20, 40, 60, 1, 21, 41, 61)):  # from room to room
        seen = wall(view.T_world_camera, 2.0, Label.SALIENT)
        strategy.update(view, Outcome(0.4, 10.0, seen=seen))
    regions = np.array(looked(strategy, dict.fromkeys(range(4), 0.4), 90))
    stays = np.diff(np.flatnonzero(np.diff(regions)))
    assert np.median(stays) == 15


def test_where_there_is_one_region_it_looks_at_one_view_after_the_other() -> None:
    strategy = ProgressRate(views(1, 30), np.random.default_rng(0), ways=straight)
    seen = set()
    for _ in range(40):
        view = strategy.choose()
        seen.add(view.index)
        strategy.update(view, Outcome(0.4, seen=wall(view.T_world_camera, 2.0, Label.SALIENT)))
    assert len(seen) >= 15


def test_a_room_that_cannot_be_learned_is_left_alone() -> None:
    strategy = ProgressRate(views(4, 60), np.random.default_rng(0), ways=straight)
    regions = looked(strategy, {0: 0.3, 1: 0.97, 2: 0.3, 3: 0.3}, 160, is_blind=True)
    assert regions[:60].count(1) >= 5
    assert regions[80:].count(1) <= 80 / 4 / 2


def test_a_room_that_has_changed_is_new() -> None:
    strategy = ProgressRate(views(2, 20), np.random.default_rng(0), ways=straight)
    looked(strategy, {0: 0.3, 1: 0.3}, 60)
    before = strategy.progress_of(0)
    view = next(view for view in views(2, 20) if view.region == 0)
    strategy.update(view, Outcome(0.9, has_changed=True))
    after = strategy.progress_of(0)
    assert before is not None
    assert after is not None
    assert after > 2 * before
    assert after == pytest.approx(1, abs=0.1)


def test_it_says_why_it_goes() -> None:
    strategy = ProgressRate(views(3, 20), np.random.default_rng(0), ways=straight)
    assert strategy.reasons() is None
    regions = looked(strategy, dict.fromkeys(range(3), 0.4), 40)
    decision = strategy.reasons()
    assert decision is not None
    assert decision.chosen == regions[-1]
    assert len(decision.candidates) == 3
    (chosen,) = (one for one in decision.candidates if one.region == decision.chosen)
    assert chosen.expected_gain is not None
    assert chosen.expected_gain >= 0.6 * max(one.expected_gain or 0 for one in decision.candidates)
    assert chosen.score == max(one.score for one in decision.candidates)
    assert decision.text.startswith("nearest of ")


def test_a_path_takes_in_what_is_on_the_way_and_not_twice_the_same() -> None:
    places = np.array([4.0, 2.0, 2.05, 9.0])
    between = np.abs(places[:, None] - places[None])
    alikeness = Alikeness([at(x) for x in places])

    def plan(values: list[float], n_looks: int) -> list[int]:
        return plan_path(
            np.array(values),
            places,  # from 0
            between,
            lambda number: alikeness.between(np.arange(4), number),
            n_looks=n_looks,
            patience=1.0,
        )

    path = plan([1.0, 1.0, 1.0, 1.0], 4)
    assert path == [1, 2, 0, 3]  # one way, no turning back
    assert 3 in plan([1.0, 0.0, 0.0, 9.0], 2)


def test_a_path_ends_where_nothing_is_worth_its_seconds() -> None:
    places = np.array([0.0, 1.0, 2.0, 3.0])
    between = np.abs(places[:, None] - places)
    values = np.array([1.0, 0.05, 1.0, 1.0])
    path = plan_path(values, places, between, lambda chosen: np.zeros(4), n_looks=4, patience=1.0)
    assert path == [0, 2, 3]


def test_views_are_alike_that_stand_and_look_alike() -> None:
    alikeness = Alikeness([at(0), at(0.3), at(0, turned_deg=90), at(5), None])
    same, near, turned, far, unknown = alikeness.between(np.arange(5), 0)
    assert same == 1
    assert 0.9 < near < 1
    assert turned == pytest.approx(0, abs=1e-9)
    assert far < 0.01
    assert unknown == 0
