"""Which way is up, however the camera is held: on its side, upside down, overhead, or in doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Camera, Frame, Label, Pose
from curiosight.teacher import Segmentation, Survey, Teacher, TemporalTeacher, survey_recording
from curiosight.teacher.memory.places import neighbourhoods
from curiosight.teacher.supports.tops import Kind
from curiosight.teacher.turning import (
    TurnedTeacher,
    rotation_of,
    turn_frame,
    turn_segmentation,
    turns_upright,
)
from room import ROOM, Box, View, look, render
from scenes import TABLE_TOP, WALL, kinect_noise

WIDE = Camera(320, 240, 262.5, 262.5, 159.5, 119.5)
HIGH = Camera(240, 320, 262.5, 262.5, 119.5, 159.5)
HEADINGS_DEG = (-30.0, 0.0, 30.0)
# Things of 6 to 12 cm on a table that is larger than the view.
BOARD = Box((0.0, 0.0, 0.70), (6.0, 6.0, 0.04), (150, 110, 60), is_salient=False)
ON_BOARD = (
    Box((0.10, 0.05, 0.77), (0.12, 0.08, 0.10), (200, 40, 40)),
    Box((-0.15, -0.05, 0.75), (0.08, 0.08, 0.06), (40, 80, 200)),
    Box((0.0, 0.18, 0.78), (0.07, 0.10, 0.12), (40, 170, 60)),
)
PICTURE = Box((0.1, 2.88, 1.4), (0.6, 0.04, 0.4), (10, 10, 10), is_salient=False)
SIDES = {1: "right", 2: "down", 3: "left"}


def record(
    boxes: tuple[Box, ...], poses: list[Pose], *, n_turns: int = 0, has_poses: bool = True
) -> tuple[list[Frame], list[View]]:
    """Return what a camera sees that takes so many quarter turns, against the clock, to mend."""
    rng = np.random.default_rng(0)
    camera = HIGH if n_turns % 2 else WIDE
    frames, views = [], []
    for number, pose in enumerate(poses):
        rolled = pose.copy()
        rolled[:3, :3] = pose[:3, :3] @ rotation_about_view(-90 * n_turns)
        view = render(camera, rolled, boxes)
        depth = kinect_noise(view.depth, rng)
        known = rolled if has_poses else None
        frames.append(Frame(f"view-{number}", view.rgb, depth, camera, known))
        views.append(view)
    return frames, views


def rotation_about_view(degrees: float) -> npt.NDArray[np.float64]:
    """Return the turn of a camera about its axis, with the clock as the camera sees it."""
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    return np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])


def teach(frames: list[Frame], up: str = "auto") -> tuple[Survey, list[Segmentation]]:
    survey = survey_recording(frames, up=up)  # type: ignore[arg-type]
    return survey, [Teacher(survey).segment(frame) for frame in frames]


def scores(found: list[Segmentation], views: list[View]) -> tuple[float, float, float]:
    """Return precision and recall of what is salient, and the share of the rest that is known."""
    labels = np.concatenate([one.labels.ravel() for one in found])
    truth = np.concatenate([view.ground_truth.ravel() for view in views])
    near = np.concatenate([(view.depth < 3.5).ravel() for view in views])
    is_salient, is_thing = (labels == Label.SALIENT)[near], (truth == 255)[near]
    n_right = np.count_nonzero(is_salient & is_thing)
    known = np.count_nonzero((labels[near] == Label.NOT_SALIENT) & ~is_thing)
    return (
        n_right / max(1, np.count_nonzero(is_salient)),
        n_right / np.count_nonzero(is_thing),
        known / np.count_nonzero(~is_thing),
    )


@pytest.mark.parametrize("has_poses", [True, False])
@pytest.mark.parametrize("n_turns", [1, 2, 3])
def test_camera_on_its_side_sees_what_an_upright_one_sees(n_turns: int, has_poses: bool) -> None:
    poses = [look(heading) for heading in HEADINGS_DEG]
    upright = scores(teach(record(ROOM, poses, has_poses=has_poses)[0])[1], record(ROOM, poses)[1])
    frames, views = record(ROOM, poses, n_turns=n_turns, has_poses=has_poses)
    survey, found = teach(frames)
    rolled = scores(found, views)
    assert upright[0] > 0.97
    assert upright[1] > 0.9
    assert rolled[0] > upright[0] - 0.02
    assert rolled[1] > upright[1] - 0.05
    assert rolled[2] > upright[2] - 0.05
    if has_poses:
        assert survey.up_world is not None
        assert survey.up_world[2] > np.cos(np.radians(1))
        assert survey.floor_height == pytest.approx(0, abs=0.03)


@pytest.mark.parametrize("has_poses", [True, False])
@pytest.mark.parametrize("tilt_deg", [60.0, 75.0, 90.0])
def test_table_below_the_camera_carries_things(tilt_deg: float, has_poses: bool) -> None:
    away = 0.8 / np.tan(np.radians(tilt_deg))
    poses = [
        look(heading, distance=away, height=1.52, tilt_deg=tilt_deg) for heading in HEADINGS_DEG
    ]
    frames, views = record((BOARD, *ON_BOARD), poses, has_poses=has_poses)
    survey, found = teach(frames)
    assert survey.scene == "table"
    precision, recall, known = scores(found, views)
    assert precision > 0.95
    assert recall > 0.85
    assert known > 0.97


def test_camera_that_also_looks_up_knows_up_from_its_poses() -> None:
    tilts_deg = (30.0, 20.0, -35.0, 40.0, -50.0, 25.0)
    poses = [look(8.0 * n - 20, tilt_deg=tilt) for n, tilt in enumerate(tilts_deg)]
    survey, found = teach(record(ROOM, poses)[0])
    assert survey.up_world is not None
    assert survey.up_world[2] > np.cos(np.radians(1))
    for tilt, segmentation in zip(tilts_deg, found, strict=True):
        assert tilt < 0 or segmentation.objects
        assert tilt > 0 or not (segmentation.labels == Label.SALIENT).any()


@pytest.mark.parametrize("has_poses", [True, False])
@pytest.mark.parametrize("on_wall", [(), (PICTURE,)])
def test_wall_that_fills_the_view_leaves_up_in_doubt(
    on_wall: tuple[Box, ...], has_poses: bool
) -> None:
    poses = [look(distance=-1.4 - 0.1 * n, height=1.3, tilt_deg=0.0) for n in range(3)]
    high = replace(WALL, size=(12.0, 0.2, 6.0))
    frames, _ = record((high, *on_wall), poses, has_poses=has_poses)
    _, found = teach(frames)
    for segmentation in found:
        assert segmentation.problem is not None
        assert "not clear which way is up" in segmentation.problem
        assert not (segmentation.labels == Label.NOT_SALIENT).any()
    told, upright = teach(frames, up="up")
    assert told.doubt is None
    assert {one.problem for one in upright} == {"no support plane is in view"}
    _, overhead = teach(frames, up="towards")
    for segmentation in overhead:
        assert segmentation.problem is None
        assert np.mean(segmentation.labels == Label.NOT_SALIENT) > (0.85 if on_wall else 0.97)


@pytest.mark.parametrize("n_turns", [1, 2, 3])
def test_how_the_camera_is_held_can_be_said(n_turns: int) -> None:
    # Nothing stands here: a floor and a wall could be each other.
    frames, views = record((WALL,), [look()], n_turns=n_turns, has_poses=False)
    survey, (found,) = teach(frames, up=SIDES[n_turns])
    normal = found.supports[0].plane.normal
    assert turns_upright(normal) == n_turns
    is_floor = (views[0].surface == 0) & (views[0].depth < 3.5)
    assert np.mean(found.labels[is_floor] == Label.NOT_SALIENT) > 0.98
    tracked = TemporalTeacher(Teacher(survey))
    for _ in range(2):
        assert turns_upright(tracked.segment(frames[0]).supports[0].plane.normal) == n_turns


def test_way_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="up: expected one of auto, up, down, left, right"):
        survey_recording([], up="sideways")  # type: ignore[arg-type]


def test_far_waves_do_not_tip_the_floor() -> None:
    # A low robot's stereo camera: what is far bends by decimetres.
    poses = [look(heading, distance=3.0, height=0.25, tilt_deg=8.0) for heading in HEADINGS_DEG]
    far_wall = replace(WALL, centre=(0.0, 7.0, 2.0), size=(14.0, 0.2, 4.0))
    frames, views = record((*ROOM[:3], far_wall), poses, has_poses=False)
    v, u = np.mgrid[:240, :320]
    waves = 0.02 * np.sin(u / 9.0) + 0.03 * np.sin(v / 7.0) + 0.0003 * (v - 120)
    for place, frame in enumerate(frames):
        assert frame.depth is not None
        bent = np.where(frame.depth > 4, frame.depth + waves * frame.depth**2, frame.depth)
        frames[place] = replace(frame, depth=bent.astype(np.float32))
    _, found = teach(frames)
    for segmentation, view, pose in zip(found, views, poses, strict=True):
        up = pose[2, :3]
        assert segmentation.supports[0].plane.normal @ up > np.cos(np.radians(1.5))
        is_floor = (view.surface == 0) & (view.depth < 3.5)
        assert np.mean(segmentation.labels[is_floor] == Label.NOT_SALIENT) > 0.95
        assert np.mean(segmentation.labels[is_floor] == Label.SALIENT) < 0.01


@pytest.mark.parametrize("metres", [100.0, 5000.0])
def test_survey_leaves_out_a_pose_far_from_all_others(metres: float) -> None:
    boxes = (*ROOM[:3], TABLE_TOP, WALL)
    frames, _ = record(boxes, [look(heading, height=1.4) for heading in (-30, -10, 0, 10, 30)])
    lost = frames[2].T_world_camera.copy()  # type: ignore[union-attr]
    lost[:3, 3] += metres
    expected = survey_recording([*frames[:2], *frames[3:]])
    survey = survey_recording([*frames[:2], replace(frames[2], T_world_camera=lost), *frames[3:]])
    assert survey.floor_height == expected.floor_height
    assert [table.height for table in survey.tables] == [t.height for t in expected.tables]
    # With its pose alone the frame is taught as one that knows no floor.
    assert survey.camera_height(lost) is None
    assert Teacher(survey).segment(replace(frames[2], T_world_camera=lost)).supports


def test_of_two_places_far_apart_the_one_seen_more_is_surveyed() -> None:
    boxes = (*ROOM[:3], TABLE_TOP, WALL)
    frames, _ = record(boxes, [look(heading, height=1.4) for heading in (-30, -10, 10, 30)])
    elsewhere = []
    for frame in frames[:3]:
        pose = frame.T_world_camera.copy()  # type: ignore[union-attr]
        pose[:3, 3] += [3000, 2000, 0]
        elsewhere.append(replace(frame, T_world_camera=pose))
    survey = survey_recording([*elsewhere, *frames])
    assert survey.floor_height == pytest.approx(0, abs=0.03)
    tables = [table.height for table in survey.tables if table.kind is Kind.TABLE]
    assert tables == pytest.approx([0.72], abs=0.03)
    for frame, alike in zip(elsewhere, frames, strict=False):
        assert survey.camera_height(frame.T_world_camera) is None
        assert survey.camera_height(alike.T_world_camera) == pytest.approx(1.4, abs=0.03)
        assert Teacher(survey).segment(frame).supports[0].plane.inliers.any()


def test_camera_that_travels_far_has_maps_of_places() -> None:
    boxes = (*ROOM[:3], WALL)
    frames, _ = record(boxes, [look()] * 12)
    travelled = []
    for number, frame in enumerate(frames):
        pose = frame.T_world_camera.copy()  # type: ignore[union-attr]
        pose[:3, 3] += [15.0 * number, 12.0 * number, 0]
        travelled.append(replace(frame, T_world_camera=pose))
    survey = survey_recording(travelled)
    # Over the 100 metres to the middle a twentieth of a degree is this much.
    assert survey.floor_height == pytest.approx(0, abs=0.09)
    assert max((table.inset.size for table in survey.tables), default=0) < 100_000


def test_neighbourhoods_are_parted_at_the_widest_gap() -> None:
    places = np.array([[0.0, 0, 0], [900, 0, 0], [3, 1, 0], [905, 2, 0], [0, -70, 0]])
    parts = neighbourhoods(places)
    assert sorted(part.tolist() for part in parts) == [[0, 2], [1, 3], [4]]
    assert neighbourhoods(places[:0])[0].tolist() == []


@pytest.mark.parametrize("n_turns", [0, 1, 2, 3])
def test_turned_camera_sees_the_same_points(n_turns: int) -> None:
    pose = look(20.0)
    camera = replace(WIDE, cx=150.0, cy=100.0, depth_window=(10, 20, 300, 200))
    view = render(camera, pose)
    frame = Frame("view", view.rgb, view.depth, camera, pose)
    turned = turn_frame(frame, n_turns)
    assert turned.camera is not None
    assert turned.T_world_camera is not None
    again = render(turned.camera, turned.T_world_camera)
    np.testing.assert_allclose(turned.depth, again.depth, atol=1e-4)
    np.testing.assert_array_equal(turned.rgb, again.rgb)
    back = turn_frame(turned, -n_turns)
    assert back.camera == camera
    np.testing.assert_allclose(back.T_world_camera, pose, atol=1e-12)


@pytest.mark.parametrize("n_turns", [1, 2, 3])
def test_what_is_found_turns_with_the_image(n_turns: int) -> None:
    (frame,), _ = record((*ROOM, TABLE_TOP), [look(height=1.3)], has_poses=False)
    teacher = Teacher()
    found = teacher.segment(frame)
    sideways = turn_frame(frame, -n_turns)
    turned = TurnedTeacher(teacher, n_turns).segment(sideways)
    np.testing.assert_array_equal(turned.labels, np.rot90(found.labels, -n_turns))
    for one in turned.objects:
        inside = turned.cluster_of_pixel == 1 + turned.clusters.index(one)
        v, u = np.nonzero(inside)
        assert np.abs(np.array(one.box) - [u.min(), v.min(), u.max() + 1, v.max() + 1]).max() < 4
    assert turns_upright(turned.supports[0].plane.normal) == n_turns
    again = turn_segmentation(turned, n_turns)
    np.testing.assert_array_equal(again.cluster_of_pixel, found.cluster_of_pixel)
    for wall, expected in zip(again.walls, found.walls, strict=True):
        np.testing.assert_allclose(wall.axes, expected.axes, atol=1e-9)
    held = Teacher(Survey(up_camera=rotation_of(-n_turns) @ found.supports[0].plane.normal))
    alike = held.segment(sideways)
    sure = held.confidence(sideways, alike)
    assert sure.shape == alike.labels.shape
    assert sure[alike.labels == Label.NOT_SALIENT].mean() > 0.8
