"""Whole homes: what is seen in them and through their doors, and moving through them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.config import load_config
from curiosight.datasets import KnowsPlaces, check_dataset, known_places, open_dataset
from curiosight.errors import DataError
from curiosight.evaluation import HeldOut, describe_tests
from curiosight.experiments.command_file import GivenCommand
from curiosight.experiments.components import make_learner
from curiosight.experiments.exploring import Exploration, Mode
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.rendering import render_room
from curiosight.frame import Camera, Frame, Label, Viewpoint
from curiosight.rooms import Look
from curiosight.rooms.home import HomeViews, parse_home
from curiosight.rooms.home import views as home_views
from curiosight.rooms.home.renderer import MAX_PARTS
from curiosight.rooms.viewpoints import camera_pose
from curiosight.teacher import CallTeacher
from curiosight.worlds import check_world, open_source
from curiosight.worlds.room_world import RoomWorld

SOURCE = "home:5,rooms=2,views=4,change=6:rearrange=1:room=1"
SMALL = Camera(160, 120, 131.0, 131.0, 79.5, 59.5)


@pytest.fixture(scope="module")
def changing() -> HomeViews:
    return HomeViews(parse_home(SOURCE))


def variant(like: HomeViews, **changes: Any) -> HomeViews:
    """Return other views of the same home, which is neither drawn nor lit again."""
    return HomeViews(replace(like._settings, **{"change": None, **changes}), like=like)


@pytest.fixture(scope="module")
def views(changing: HomeViews) -> HomeViews:
    return variant(changing)


def small_look(views: HomeViews, pose: np.ndarray, seed: int = 0) -> Look:
    return views.look_from(pose, "look", np.random.default_rng(seed), camera=SMALL)


def test_a_drive_leads_through_all_doors_at_camera_rate(views: HomeViews) -> None:
    drive = variant(views, path="drive", views=None)
    assert {drive.place(index) for index in range(len(drive))} == {0, 1, 2}
    assert all(drive.free_space.contains(pose[:2, 3]) for pose in drive.poses)
    places = np.array([pose[:3, 3] for pose in drive.poses])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.5 / 30 + 1e-9
    ahead = np.array([pose[:3, 2] for pose in drive.poses])
    turns = np.degrees(np.arccos(np.clip((ahead[1:] * ahead[:-1]).sum(1), -1, 1)))
    assert turns.max() < 60 / 30 + 0.01
    assert drive.seconds_of(60) == 2.0
    assert str(drive.test_views(3).settings) == "home:5,rooms=2,views=3,split=test"
    few = variant(views, path="drive", views=7)
    np.testing.assert_array_equal(few.poses, drive.poses[:7])


def test_an_orbit_looks_at_one_table_from_around_it(views: HomeViews) -> None:
    orbit = variant(views, path="orbit", views=40, height=1.4, tilt=None)
    assert len(orbit) == 40
    origins = np.array([pose[:3, 3] for pose in orbit.poses])
    rays = np.array([pose[:3, 2] for pose in orbit.poses])
    # The point nearest to all optical axes is the table's middle.
    across = np.eye(3) - rays[:, :, None] * rays[:, None]
    middle = np.linalg.solve(across.sum(0), np.einsum("kij,kj->i", across, origins))
    off = np.linalg.norm(np.einsum("kij,kj->ki", across, middle - origins), axis=1)
    assert off.max() < 0.15
    assert 0.2 < middle[2] < 1.2
    angles = np.degrees(np.unwrap(np.arctan2(*(origins - middle)[:, 1::-1].T)))
    assert abs(angles[-1] - angles[0]) > 150
    RoomWorld(orbit, np.zeros(40, int)).move_to(Viewpoint(0, 0, orbit.poses[0]))


def test_views_keep_the_contract_of_a_recording(views: HomeViews) -> None:
    check_dataset(views)
    assert views.ids == tuple(f"{index:06}" for index in range(8))
    assert isinstance(views, KnowsPlaces)
    assert [views.place(index) for index in range(8)] == [0, 0, 0, 0, 1, 1, 1, 1]
    assert all(views.free_space.contains(pose[:2, 3]) for pose in views.poses)
    assert len(views.outlines) == 3


def test_one_sees_through_the_doors(views: HomeViews) -> None:
    """From a room straight through its doorway: the corridor's other wall, or the next room."""
    home = views.home
    for lot in home.plan.lots:
        inside, before = lot.before_door(1.0), lot.before_door(0.0)
        heading = np.degrees(np.arctan2(*(before - inside)[::-1]))
        look = small_look(views, camera_pose(*inside, heading, height=1.0, tilt_deg=0))
        middle = look.ids[50:70, 70:90] // MAX_PARTS
        width = np.ptp(home.plan.corridor.outline[:, 1])
        is_wall = middle == home.n_rooms
        assert is_wall.any()
        depth = look.true_depth[50:70, 70:90][is_wall]
        assert depth.max() == pytest.approx(1.0 + 0.2 + width, abs=0.05)
        assert depth.min() > 1.2 - 0.05
        assert not (look.truth[50:70, 70:90][is_wall] == Label.SALIENT).any()
        assert np.isfinite(look.true_depth).all()
        assert (look.ids % MAX_PARTS > 0).all()  # no ray slips out between the rooms


def test_from_the_corridor_one_sees_into_a_room(views: HomeViews) -> None:
    lot = views.home.plan.lots[1]
    outside, before = lot.before_door(-0.9), lot.before_door(0.0)
    heading = np.degrees(np.arctan2(*(before - outside)[::-1]))
    pose = camera_pose(*outside, heading, height=1.0, tilt_deg=0)
    assert views.home.place_of(pose[:2, 3]) == 2
    look = small_look(views, pose)
    assert np.bincount((look.ids // MAX_PARTS).ravel(), minlength=3)[1] > 0.1 * look.ids.size


def test_the_way_leads_through_the_doors(views: HomeViews) -> None:
    check_world(RoomWorld(views, np.zeros(8, int)), n_captures=2)
    with RoomWorld(views, np.zeros(8, int)) as world:
        here, there = world.views[0], world.views[4]
        assert here.T_world_camera is not None
        assert there.T_world_camera is not None
        world.move_to(here)
        seconds = world.move_to(there)
        start, goal = here.T_world_camera[:2, 3], there.T_world_camera[:2, 3]
        doors = [lot.before_door(0.0) for lot in views.home.plan.lots]
        stops = [start, *doors, goal]
        # A door is .9 to 1 m wide: the way may pass beside its middle.
        shortest = sum(np.linalg.norm(b - a) for a, b in pairwise(stops)) - 1.5
        assert seconds > shortest / 0.5
        route = views.free_space.route(start, goal)
        length = np.linalg.norm(np.diff(route, axis=0), axis=1).sum()
        assert seconds < (1.1 * length + 0.2) / 0.5 + 180 / 60
        outside = camera_pose(*(views.outlines[0].min(0) - 1), 0, height=1, tilt_deg=10)
        with pytest.raises(ValueError, match="in a wall, in furniture or too close"):
            world.move_to(Viewpoint(-1, 0, outside))


def test_test_views_are_others_in_the_same_frame(views: HomeViews) -> None:
    tests = views.test_views(2)
    assert str(tests.settings) == "home:5,rooms=2,views=2,split=test"
    assert tests.home is views.home
    assert [tests.place(index) for index in range(4)] == [0, 0, 1, 1]
    mine, theirs = ({pose.tobytes() for pose in v.poses} for v in (views, tests))
    assert not mine & theirs
    assert not {*views.ids} & {*tests.ids}


def test_the_same_source_gives_the_same_bytes(views: HomeViews) -> None:
    again = open_source("home:5,rooms=2,views=4")
    assert isinstance(again, HomeViews)
    np.testing.assert_array_equal(again.poses, views.poses)
    # One where no other room is in view, which would have to be lit, too.
    index = next(index for index in range(4) if views.look(index).ids.max() < MAX_PARTS)
    frame, other = views[index], again[index]
    assert frame.rgb.tobytes() == other.rgb.tobytes()
    assert frame.depth.tobytes() == other.depth.tobytes()
    assert views.ground_truth(index).tobytes() == again.ground_truth(index).tobytes()


def test_a_recording_tells_the_room_of_each_frame(views: HomeViews, tmp_path: Path) -> None:
    some = HomeViews(views._settings, [views.poses[0], views.poses[5]], like=views)
    list(render_room(some, "tum", OutputFolder(tmp_path / "out", "render", Path("home"))))
    lines = (tmp_path / "out/places.txt").read_text().splitlines()
    recording = open_dataset(tmp_path / "out")
    assert lines == [f"{id} {place}" for id, place in zip(recording.ids, (0, 1), strict=True)]
    np.testing.assert_allclose(recording.poses, some.poses, atol=1e-6)
    assert known_places(recording) == known_places(some) == (0, 1)
    (tmp_path / "out/places.txt").write_text(f"{recording.ids[1]} 7\n")
    assert known_places(recording) == (-1, 7)
    (tmp_path / "out/places.txt").write_text("kitchen\n")
    with pytest.raises(DataError, match="write lines `<id> <number>`"):
        known_places(recording)


def test_a_room_that_changes_its_looks_cannot_be_learned(views: HomeViews) -> None:
    number = views.home.unlearnable
    poses = views.poses[4 * number : 4 * number + 4]
    extra = variant(views, views=20).poses[20 * number : 20 * number + 20]
    errors = {}
    for is_unlearnable in (False, True):
        shown = variant(views, unlearnable=is_unlearnable)
        looks = [small_look(shown, pose, seed) for seed, pose in enumerate([*extra, *poses])]
        truth = {id(look.frame): look.truth for look in looks}

        def label(frame: Frame, truth: dict[int, np.ndarray] = truth) -> np.ndarray:
            return truth[id(frame)]

        learner = make_learner(load_config("default"), CallTeacher(label))
        tested = [(look.frame, look.truth) for look in looks[20:]]
        tests = HeldOut(learner, describe_tests(learner, tested))
        curve = []
        for look in looks[:20]:
            learner.observe(look.frame)
            curve.append(tests.overall_error())
        errors[is_unlearnable] = curve
    assert errors[True][-1] >= 0.8 * errors[True][0]
    assert errors[False][-1] < 0.8 * errors[True][-1]


def test_an_exploration_is_tested_on_the_home_as_it_is(
    changing: HomeViews, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(home_views, "N_TEST_VIEWS", 1)
    config = load_config("default")
    explorer = replace(config.explorer, strategy="chronological", n_steps=9)
    config = replace(config, explorer=explorer, teacher=replace(config.teacher, n_survey_frames=3))
    given = GivenCommand("explore", "1", "home")

    def begun(name: str, mode: Mode = "new") -> Exploration:
        out = OutputFolder(tmp_path / name, "explore", Path("home"), goes_on=mode == "resumed")
        keeping = Keeping(every_looks=7, max_share=1.0)
        return Exploration(config, changing, out, given=given, mode=mode, keeping=keeping)

    run = begun("whole")
    sources = [str(run.tests.truth.dataset.path) for _ in run]  # type: ignore[attr-defined]
    assert ["change" in source for source in sources] == 6 * [False] + 3 * [True]
    summary = run.finish()
    assert summary["test_source"].endswith("change=6:rearrange=1:room=1")

    # Ended after the change, it goes on in the home as it is then, with its noise of each look.
    for step, _ in begun("ended"):
        if step.index == 7:
            break
    again = begun("ended", "resumed")
    assert [step.index for step, _ in again] == [7, 8]
    assert again.finish() == summary
    assert not again.is_other_than_before
    for name in ("steps.csv", "model.npz"):
        assert (tmp_path / "ended" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_a_change_moves_the_things_of_its_room_after_its_look(
    changing: HomeViews, views: HomeViews
) -> None:
    assert changing.n_before_change == 6
    home, after = changing.home, changing.home.after
    assert after is not None
    names = [[one.name for one in h.standing(0)] for h in (home, after)]
    assert names[0] == names[1]
    before, then = ([one.polygon.tolist() for one in h.standing(1)] for h in (home, after))
    assert before != then
    pose = changing.poses[5]
    look = changing.look_from(pose, "look", np.random.default_rng(0), n_looks=6)
    assert (look.true_depth != views.true_depth(5)).mean() > 0.01
    assert all(after.free_space.contains(pose[:2, 3]) for pose in changing.poses)
    tests = changing.own_test_views(is_after=True)
    assert str(tests.settings) == ("home:5,rooms=2,views=12,split=test,change=6:rearrange=1:room=1")
    other = tests.look_from(pose, "look", np.random.default_rng(0))
    assert look.frame.rgb.tobytes() == other.frame.rgb.tobytes()
