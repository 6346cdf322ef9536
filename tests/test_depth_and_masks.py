"""Depth says what is an object, masks of another program say where it ends."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from command import refusal, succeed
from curiosight.config import load_config
from curiosight.datasets import open_dataset
from curiosight.experiments.components import make_teacher
from curiosight.frame import Frame, Label
from curiosight.teacher import Survey, Teacher, TemporalTeacher, Verdict
from curiosight.teacher.depth_and_masks import InstanceMasks, regions_of
from curiosight.teacher.segmented import Segmentation
from room import Box, View
from scenes import ON_TABLE, TABLE_TOP, WALL, see

Array = npt.NDArray[Any]
Capsys = pytest.CaptureFixture[str]
RED, BLUE = (200, 40, 40), (40, 80, 200)
# On the floor before the camera, faces and tops flush.
LEFT = Box((-0.2, 0.6, 0.2), (0.4, 0.4, 0.4), RED)
RIGHT = Box((0.2, 0.6, 0.2), (0.4, 0.4, 0.4), BLUE)
# Too long together to be one object; their tops are too small to carry something.
LONG = (
    Box((-0.3, 0.6, 0.25), (0.6, 0.11, 0.5), RED),
    Box((0.3, 0.6, 0.3), (0.6, 0.11, 0.6), BLUE),
)


# The image ends in the first; the other stands beside it, whole.
CUT = Box((-1.6, 0.6, 0.2), (0.6, 0.2, 0.4), BLUE)
BESIDE = Box((-1.15, 0.6, 0.175), (0.3, 0.2, 0.35), RED)


def look_at(*boxes: Box) -> tuple[Frame, View]:
    return see((WALL, *boxes), distance=2.2)


def masks_of(view: View) -> Array:
    """(H, W) int32: a number for everything, the floor and the wall, 1 and 2, too."""
    return np.maximum(view.surface + 1, 0).astype(np.int32)


def segment(frame: Frame, masks: Array | None = None, **options: Any) -> Segmentation:
    found = None if masks is None else (lambda _: masks)
    return Teacher(Survey(), masks=found, **options).segment(frame)


def agreement(found: Segmentation, view: View, box: int) -> float:
    """Return the overlap (IoU) of a box, by its place in the view, with what is most of it."""
    is_box, instances = view.surface == box, found.instances()
    most = np.bincount(instances[is_box & (instances > 0)]).argmax()
    is_found = instances == most
    return np.count_nonzero(is_box & is_found) / np.count_nonzero(is_box | is_found)


def test_flush_things_on_the_floor_are_parted_along_masks() -> None:
    frame, view = look_at(LEFT, RIGHT)
    alone, found = segment(frame), segment(frame, masks_of(view))
    assert len(alone.objects) == 1
    assert len(found.objects) == 2
    assert agreement(found, view, 2) > 0.95
    assert agreement(found, view, 3) > 0.95
    assert np.array_equal(found.labels, alone.labels)


def test_two_things_that_are_too_large_together_are_two_objects() -> None:
    frame, view = look_at(*LONG)
    alone, found = segment(frame), segment(frame, masks_of(view))
    assert [cluster.verdict for cluster in alone.clusters] == [Verdict.LARGE]
    assert len(found.objects) == 2
    assert np.mean(found.labels[view.surface >= 2] == Label.SALIENT) > 0.95
    assert np.mean(found.labels[view.surface <= 1] == Label.SALIENT) < 0.005


def test_a_thing_beside_one_that_the_image_cuts_is_an_object_where_its_mask_shows_it_whole() -> (
    None
):
    frame, view = look_at(CUT, BESIDE)
    alone, found = segment(frame), segment(frame, masks_of(view))
    assert not alone.objects
    assert len(found.objects) == 1
    # All but its foot, which is in the floor's slab.
    assert np.mean(found.labels[view.surface == 3] == Label.SALIENT) > 0.92
    assert np.mean(found.labels[view.surface == 2] == Label.SALIENT) < 0.02


def test_a_mask_that_reaches_the_border_of_the_image_shows_nothing_whole() -> None:
    frame, view = look_at(CUT, BESIDE)
    masks = masks_of(view)
    masks[masks == 3] = 4
    assert not segment(frame, masks).objects


@pytest.mark.parametrize("boxes", [(LEFT,), LONG, (TABLE_TOP, ON_TABLE)])
def test_masks_of_the_background_make_no_objects(boxes: tuple[Box, ...]) -> None:
    frame, view = look_at(*boxes)
    alone = segment(frame)
    for masks in (np.ones_like(masks_of(view)), (view.surface <= 1).astype(np.int32)):
        found = segment(frame, masks)
        assert np.array_equal(found.labels, alone.labels)
        assert np.array_equal(found.instances(), alone.instances())


@given(st.integers(0, 2**16), st.integers(1, 40), st.sampled_from([8, 24, 60]))
@settings(max_examples=12, deadline=None)
def test_whatever_masks_say_depth_says_what_is_none(seed: int, n_masks: int, size: int) -> None:
    frame, _ = look_at(LEFT, RIGHT, TABLE_TOP, ON_TABLE)
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, n_masks + 1, (480 // size + 1, 640 // size + 1))
    masks = np.kron(coarse, np.ones((size, size), int))[:480, :640].astype(np.int32)
    alone, found = segment(frame), segment(frame, masks)
    is_none = alone.labels == Label.NOT_SALIENT
    assert np.array_equal(found.labels == Label.NOT_SALIENT, is_none)
    was_salient = alone.labels == Label.SALIENT
    assert (found.labels[was_salient] == Label.SALIENT).all()


def test_rough_masks_still_tell_how_many_objects_there_are() -> None:
    frame, view = look_at(LEFT, RIGHT)
    square = np.ones((9, 9), np.uint8)
    for spoil in (cv2.erode, cv2.dilate):
        masks = np.zeros(view.surface.shape, np.int32)
        for number in (2, 3):
            masks[spoil((view.surface == number).astype(np.uint8), square) > 0] = number
        found = segment(frame, masks)
        assert len(found.objects) == 2
        assert min(agreement(found, view, 2), agreement(found, view, 3)) > 0.9


def test_what_a_mask_has_forgotten_is_an_object_of_its_own_but_a_rim_is_none() -> None:
    frame, view = look_at(LEFT, RIGHT)
    only_left = np.where(view.surface == 2, 1, 0).astype(np.int32)
    assert len(segment(frame, only_left).objects) == 2
    all_but_a_rim = cv2.erode((view.surface >= 2).astype(np.uint8), np.ones((13, 13), np.uint8))
    assert len(segment(frame, all_but_a_rim.astype(np.int32)).objects) == 1


def test_what_is_too_small_to_be_one_stays_with_its_object() -> None:
    frame, view = look_at(LEFT)
    v, u = np.nonzero(view.surface == 2)
    masks = (view.surface == 2).astype(np.int32)
    masks[v.min() : v.min() + 14, u.min() : u.min() + 14] = 2
    found = segment(frame, masks)
    assert np.array_equal(found.instances() > 0, segment(frame).instances() > 0)
    assert len(found.objects) == 1


def test_holes_of_depth_inside_a_mask_belong_to_its_object() -> None:
    frame, view = look_at(LEFT)
    assert frame.depth is not None
    v, u = (int(places.mean()) for places in np.nonzero(view.surface == 2))
    hole = np.zeros(view.surface.shape, bool)
    hole[v : v + 30, u : u + 40] = True
    beside = np.zeros_like(hole)
    beside[v : v + 30, :40] = True
    depth = frame.depth.copy()
    depth[hole | beside] = np.nan
    holed = replace(frame, depth=depth)
    found = segment(holed, masks_of(view))
    assert (segment(holed).labels[hole] == Label.UNAVAILABLE).all()
    assert (found.labels[hole] == Label.SALIENT).all()
    assert (found.labels[beside] == Label.UNAVAILABLE).all()
    assert len(np.unique(found.instances()[view.surface == 2])) <= 2  # its own, and none


def test_a_mask_of_what_depth_does_not_see_is_not_of_what_stands_before_it() -> None:
    frame, view = look_at(LEFT)
    assert frame.depth is not None
    is_window = np.zeros(view.surface.shape, bool)
    is_window[: np.nonzero(view.surface == 2)[0].min() + 6, 150:400] = True
    depth = np.where(is_window & (view.surface != 2), np.nan, frame.depth).astype(np.float32)
    masks = np.where(is_window, 9, masks_of(view)).astype(np.int32)
    found = segment(replace(frame, depth=depth), masks)
    assert (found.labels[view.surface == 2] == Label.SALIENT).any()
    assert (found.labels[np.isnan(depth)] == Label.UNAVAILABLE).all()


def test_a_camera_on_its_side_sees_the_same() -> None:
    frame, view = look_at(LEFT, RIGHT)
    assert frame.depth is not None
    assert frame.camera is not None
    camera = replace(frame.camera, width=480, height=640, cx=239.5, cy=319.5)
    turned = Frame("view", np.rot90(frame.rgb), np.rot90(frame.depth).copy(), camera)
    masks = np.rot90(masks_of(view))
    teacher = Teacher(Survey(up_camera=np.array([-1.0, 0, 0])), masks=lambda _: masks)
    found = teacher.segment(turned)
    assert len(found.objects) == 2
    upright = segment(frame, masks_of(view))
    assert np.array_equal(np.rot90(found.labels, -1), upright.labels)


def test_memory_of_views_keeps_what_masks_tell() -> None:
    frame, view = see((WALL, LEFT, RIGHT), distance=2.2, with_pose=True)
    depth = np.where(np.indices(view.surface.shape)[1] % 64 < 6, np.nan, frame.depth)
    holed = replace(frame, depth=depth.astype(np.float32))
    teacher = TemporalTeacher(Teacher(Survey(), masks=lambda _: masks_of(view)))
    found = teacher.segment(holed)
    assert len(found.objects) == 2
    assert (found.labels[np.isnan(depth) & (view.surface >= 2)] == Label.SALIENT).mean() > 0.9


def test_instances_are_read_from_numbers_and_from_plain_masks() -> None:
    numbers = np.array([[0, 7, 7, 300, 0, 7]], np.uint16)
    assert regions_of(numbers).tolist() == [[0, 1, 1, 2, 0, 1]]
    assert regions_of(numbers + 1).tolist() == [[1, 2, 2, 3, 1, 2]]  # no pixel is 0
    for one in (255, 1):
        plain = np.array([[0, one, one, 0, one]], np.uint8)
        assert regions_of(plain).tolist() == [[0, 1, 1, 0, 2]]
    codes = np.array([[255, 125, 75, 0, 255]], np.uint8)
    assert regions_of(codes).tolist() == [[1, 0, 0, 0, 2]]
    assert not regions_of(np.zeros((2, 3), np.uint8)).any()


def test_frames_without_a_good_mask_are_told_by_depth_alone(tmp_path: Path) -> None:
    frame, view = look_at(LEFT, RIGHT)
    cv2.imwrite(str(tmp_path / "view.png"), masks_of(view).astype(np.uint16))
    cv2.imwrite(str(tmp_path / "small.png"), np.eye(20, dtype=np.uint8))
    (tmp_path / "torn.png").write_bytes(b"no image")
    teacher = Teacher(Survey(), masks=InstanceMasks(tmp_path))
    assert len(teacher.segment(frame).objects) == 2
    assert teacher.segment(frame).lacks is None
    for id, reason in (
        ("small", "the mask is not of the image's size"),
        ("torn", "the mask cannot be read"),
        ("other", "there is no mask"),
    ):
        found = teacher.segment(replace(frame, id=id))
        assert (found.lacks, found.problem) == (reason, None)
        assert np.array_equal(found.labels, segment(frame).labels)


@pytest.fixture(scope="module")
def masks(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Masks of all frames of the room but two."""
    folder = tmp_path_factory.mktemp("masks")
    for path in sorted((room / "ground_truth").iterdir())[:-2]:
        (folder / path.name).write_bytes(path.read_bytes())
    return folder


def test_the_teacher_is_scored_and_says_what_it_had_no_masks_for(
    room: Path, masks: Path, tmp_path: Path, capsys: Capsys
) -> None:
    source = f"depth+masks:{masks}"
    arguments = ("score-teacher", room, "--teacher", source, "--out", tmp_path / "out")
    outcome = succeed(capsys, *arguments)
    told = "2 of 8 frames are told by depth alone: there is no mask, first 000006"
    assert f"warning: {told}" in outcome.err
    assert f'source = "{source}"' in (tmp_path / "out/config.toml").read_text()


def test_with_poses_memory_hears_of_the_masks(room: Path, masks: Path) -> None:
    config = load_config(overrides={"teacher.source": f"depth+masks:{masks}"})
    teacher = make_teacher(config, open_dataset(room), temporal=True)
    assert isinstance(teacher, TemporalTeacher)
    assert isinstance(teacher.teacher.masks, InstanceMasks)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--teacher depth+masks:nowhere", "nowhere: is no folder"),
        ("--teacher depth+masks:", "teacher: expected depth, depth+masks:FOLDER"),
        ("--teacher depth+boxes:x", "teacher: expected depth, depth+masks:FOLDER"),
        ("--teacher depth+masks:MASKS --preset paper", "pipeline 'paper'"),
    ],
)
def test_unusable_options(
    options: str, words: str, room: Path, masks: Path, tmp_path: Path, capsys: Capsys
) -> None:
    given = options.replace("MASKS", str(masks)).split()
    assert words in refusal(capsys, "learn", room, *given, "--out", tmp_path / "x")
