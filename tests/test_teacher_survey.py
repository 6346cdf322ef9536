"""What a recording tells as a whole: its scene, its vertical, its floor and tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from curiosight.frame import Frame
from curiosight.teacher import SegmentationSettings, Survey, Teacher, survey_recording
from curiosight.teacher.supports.tops import Kind
from curiosight.teacher.things.verdicts import Cluster
from room import ROOM, Box
from scenes import ON_TABLE, TABLE_TOP, WALL, kinect_noise, see

# Tilts the world's axes, as a recording does whose first camera is its world.
R_tilted = Rotation.from_euler("xyz", (100, -15, 30), degrees=True).as_matrix()
UP = R_tilted @ np.array([0.0, 0.0, 1.0])
SEAT = Box((0.0, 0.3, 0.44), (0.40, 0.40, 0.04), (150, 110, 60))
ON_SEAT = Box((0.0, 0.3, 0.52), (0.12, 0.12, 0.12), (40, 80, 200))


def record(
    boxes: tuple[Box, ...],
    tilts_deg: tuple[float, ...],
    height: float,
    headings_deg: tuple[float, ...] = (),
) -> list[Frame]:
    """Return noisy frames with poses in a tilted world."""
    rng = np.random.default_rng(0)
    frames = []
    headings_deg = headings_deg or (0.0,) * len(tilts_deg)
    for heading_deg, tilt_deg in zip(headings_deg, tilts_deg, strict=True):
        frame, view = see(
            boxes, heading_deg=heading_deg, height=height, tilt_deg=tilt_deg, with_pose=True
        )
        assert frame.T_world_camera is not None
        pose = frame.T_world_camera.copy()
        pose[:3] = R_tilted @ pose[:3]
        frames.append(replace(frame, depth=kinect_noise(view.depth, rng), T_world_camera=pose))
    return frames


def stool_with_a_box(settings: SegmentationSettings) -> tuple[Survey, tuple[Cluster, ...]]:
    """Return what a recording of a box on a stool tells, and the objects of one of its frames."""
    legs = [
        Box((x, y, 0.21), (0.04, 0.04, 0.42), (90, 90, 90))
        for x in (-0.17, 0.17)
        for y in (0.13, 0.47)
    ]
    frames = record((SEAT, *legs, ON_SEAT, WALL), (25, 30, 35, 40), 1.2)
    survey = survey_recording(frames, settings)
    return survey, Teacher(survey, settings).segment(frames[2]).objects


def without_poses(frames: list[Frame]) -> list[Frame]:
    return [replace(frame, T_world_camera=None) for frame in frames]


def cut_to_table(frame: Frame, surface: npt.NDArray[np.int64]) -> Frame:
    """Remove all depth but the table's and its objects', as some data sets' makers do."""
    assert frame.depth is not None
    return replace(frame, depth=np.where(surface > 0, frame.depth, np.float32(np.nan)))


def angle_deg(a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


def test_gravity_and_floor_come_from_posed_frames() -> None:
    survey = survey_recording(record((*ROOM[:3], TABLE_TOP, WALL), (20, 30, 40, 50), 1.4))
    assert survey.scene == "floor"
    assert survey.up_world is not None
    assert angle_deg(survey.up_world, UP) < 1
    assert survey.floor_height == pytest.approx(0, abs=0.03)
    tables = [table.height for table in survey.tables if table.kind is Kind.TABLE]
    assert tables == pytest.approx([0.72], abs=0.03)
    assert survey.supports() == {"floor": 1, "table": 1}


def test_camera_height_needs_a_pose_and_a_floor() -> None:
    pose = np.eye(4)
    pose[2, 3] = 1.5
    survey = Survey("floor", np.array([0.0, 0.0, 1.0]), 0.3)
    assert survey.camera_height(pose) == pytest.approx(1.2)
    assert survey.camera_height(None) is None
    assert Survey("floor").camera_height(pose) is None


def test_floor_seen_in_some_frames_is_known_in_all() -> None:
    near = replace(ON_TABLE, centre=(0.15, 0.0, 0.80))
    frames = record((TABLE_TOP, near), (20, 30, 40), 1.3)
    hidden, _ = see((TABLE_TOP, near), distance=0.5, height=1.3, tilt_deg=55, with_pose=True)
    assert hidden.T_world_camera is not None
    pose = hidden.T_world_camera.copy()
    pose[:3] = R_tilted @ pose[:3]
    teacher = Teacher(survey_recording(frames), SegmentationSettings(stride=2))
    found = teacher.segment(replace(hidden, T_world_camera=pose))
    assert [support.is_table for support in found.supports] == [False, True]
    assert [cluster.support_height for cluster in found.objects] == pytest.approx([0.72], abs=0.05)


def test_small_tops_are_parts_of_objects_by_option() -> None:
    settings = SegmentationSettings(min_table_area=0.25, min_table_diagonal=0.7)
    survey, objects = stool_with_a_box(settings)
    assert survey.tables == ()
    tallest = max(objects, key=lambda cluster: cluster.box[3] - cluster.box[1])
    assert tallest.support_height == pytest.approx(0, abs=0.03)


def test_stool_carries_a_thing_but_may_be_a_lid() -> None:
    survey, objects = stool_with_a_box(SegmentationSettings())
    assert [table.height for table in survey.tables] == pytest.approx([0.46], abs=0.03)
    assert [table.kind for table in survey.tables] == [Kind.DOUBTFUL]
    assert [cluster.support_height for cluster in objects] == pytest.approx([0.46], abs=0.03)


@pytest.mark.parametrize("has_sides", [True, False])
def test_pouf_and_low_table_that_carry_nothing_are_things(has_sides: bool) -> None:
    top = Box((0.0, 0.0, 0.38), (0.62, 0.52, 0.04), (150, 110, 60))
    legs = [
        Box((x, y, 0.18), (0.04, 0.04, 0.36), (90, 90, 90))
        for x in (-0.28, 0.28)
        for y in (-0.23, 0.23)
    ]
    body = Box((0.0, 0.0, 0.18), (0.62, 0.52, 0.36), (150, 110, 60))
    boxes = (top, body, WALL) if has_sides else (top, *legs, WALL)
    headings = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)
    frames = record(boxes, (30.0,) * 6, 1.3, headings)
    survey = survey_recording(frames)
    assert [table.kind for table in survey.tables] == [Kind.THING]
    assert len(Teacher(survey).segment(frames[0]).objects) == 1


def test_auto_sees_a_floor() -> None:
    survey = survey_recording(without_poses(record(ROOM, (20, 25, 30), 1.0)))
    assert (survey.scene, survey.up_world, survey.floor_height) == ("floor", None, None)


def test_auto_sees_a_table_where_something_stands_lower() -> None:
    legs = [Box((x, 0.9, 0.2), (0.1, 0.1, 0.4), (90, 90, 90)) for x in (-0.5, 0.0, 0.5)]
    far = replace(WALL, centre=(0.0, 2.0, 0.3), size=(3.0, 0.1, 0.6))
    views = [see((TABLE_TOP, far, *legs), height=1.6, tilt_deg=t) for t in (25, 30)]
    frames = [cut_to_table(frame, view.surface) for frame, view in views]
    assert survey_recording(frames).scene == "table"


def test_auto_sees_a_table_where_depth_ends_with_it() -> None:
    views = [see((TABLE_TOP, ON_TABLE), height=1.2, distance=0.9, tilt_deg=t) for t in (30, 35)]
    frames = [cut_to_table(frame, view.surface) for frame, view in views]
    survey = survey_recording(frames)
    assert survey.scene == "table"
    found = Teacher(survey).segment(frames[0])
    assert [support.is_table for support in found.supports] == [True]
    assert len(found.objects) == 1


@pytest.mark.parametrize("scene", ["floor", "table"])
def test_a_scene_can_be_demanded(scene: str) -> None:
    assert survey_recording(without_poses(record(ROOM, (25,), 1.0)), scene=scene).scene == scene


def test_unknown_scene_is_refused() -> None:
    with pytest.raises(ValueError, match="scene: expected one of auto, floor, table"):
        survey_recording([], scene="desk")


def test_recording_that_shows_nothing_is_a_floor() -> None:
    frame, _ = see()
    blank = replace(frame, depth=np.full_like(frame.depth, np.nan))
    survey = survey_recording([blank, Frame("colour", frame.rgb)])
    assert (survey.scene, survey.up_world, survey.floor_height) == ("floor", None, None)


def test_frames_with_a_problem_tell_nothing() -> None:
    frames = record(ROOM, (20, 25, 30), 1.0)
    assert survey_recording(frames).up_world is not None
    broken = [replace(frame, problem="the file is cut off") for frame in frames]
    assert survey_recording(broken).up_world is None
