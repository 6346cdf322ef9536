"""What the teacher finds does not depend on the size of the images."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.frame import Camera, Frame, Label, Pose
from curiosight.teacher import SegmentationSettings, Teacher, TemporalTeacher, survey_recording
from curiosight.teacher.cloud.points import observe_points, scale_of
from curiosight.teacher.cloud.repeats import find_repeats
from curiosight.teacher.memory.places import shrunk
from room import ROOM, look, render
from scenes import CAMERA, WALL, as_frame, kinect_noise

Depth = npt.NDArray[np.float32]
POSE = look(0.0, distance=1.9, height=1.0, tilt_deg=25.0)
BOXES = (*ROOM[:3], replace(WALL, centre=(0.0, 1.6, 1.25)))


def camera_at(width: int, height: int) -> Camera:
    return scaled_camera(CAMERA, (width, height))


def frame_at(camera: Camera, pose: Pose = POSE) -> Frame:
    """Return a room with three things on the floor as a Kinect sees it."""
    frame = as_frame(render(camera, pose, BOXES), camera, pose)
    assert frame.depth is not None
    return replace(frame, depth=kinect_noise(frame.depth, np.random.default_rng(0)))


def enlarged(frame: Frame, size: tuple[int, int], interpolation: int) -> Frame:
    """Return a frame whose readings are repeated."""
    assert frame.depth is not None
    assert frame.camera is not None
    rgb, depth = (
        cv2.resize(a, size, interpolation=interpolation) for a in (frame.rgb, frame.depth)
    )
    return replace(frame, rgb=rgb, depth=depth, camera=scaled_camera(frame.camera, size))


@pytest.mark.parametrize("size", [(160, 120), (320, 240), (1280, 960)])
def test_objects_are_those_of_an_image_of_the_usual_size(size: tuple[int, int]) -> None:
    camera = camera_at(*size)
    usual, other = (Teacher().segment(frame_at(one)) for one in (CAMERA, camera))
    assert len(usual.objects) == len(other.objects) == 3
    sizes = [np.array(sorted(one.size for one in found.objects)) for found in (usual, other)]
    np.testing.assert_allclose(*sizes, atol=0.04)
    n_usual, n_other = (sum(one.n_pixels for one in found.objects) for found in (usual, other))
    assert n_other / scale_of(camera) ** 2 == pytest.approx(n_usual, rel=0.1)
    fitted = cv2.resize(other.labels, (640, 480), interpolation=cv2.INTER_NEAREST)
    assert np.mean((fitted == Label.SALIENT) == (usual.labels == Label.SALIENT)) > 0.99


def test_confidence_does_not_depend_on_the_size() -> None:
    small, usual = (frame_at(camera_at(*size)) for size in ((160, 120), (640, 480)))
    means = []
    for frame in (small, usual):
        teacher = Teacher()
        found = teacher.segment(frame)
        confidence = teacher.confidence(frame, found)
        means.append(float(confidence[found.labels == Label.SALIENT].mean()))
    assert means[0] == pytest.approx(means[1], abs=0.03)


@pytest.mark.parametrize(
    ("size", "stride"),
    [
        ((160, 120), 1),
        ((320, 240), 1),
        ((480, 640), 3),
        ((640, 480), 3),
        ((1280, 720), 5),
        ((1920, 1440), 9),
        ((3840, 2160), 16),
    ],
)
def test_grid_is_about_as_fine_at_every_size(size: tuple[int, int], stride: int) -> None:
    scale = scale_of(Camera(*size, 500.0, 500.0, 0.0, 0.0))
    assert SegmentationSettings().stride_at(scale) == stride


def test_pixels_are_those_of_an_image_of_the_usual_size() -> None:
    points = observe_points(np.ones((240, 320), np.float32), camera_at(320, 240), stride=1)
    assert points.cell == 2
    assert (points.steps(6), points.steps(0.1)) == (3, 1)
    assert points.count(200) == points.evidence(200) == 50
    coarse = observe_points(np.ones((120, 160), np.float32), camera_at(160, 120), stride=1)
    assert coarse.count(200) == 12.5
    # Fewer readings than make a thing at 640x480 do not make one here.
    assert coarse.evidence(200) == pytest.approx(200 / 9)


def test_frames_of_a_survey_are_small_but_not_smaller_than_they_were() -> None:
    for size, expected in (
        ((160, 120), (120, 160)),
        ((320, 240), (240, 320)),
        ((640, 480), (240, 320)),
        ((480, 640), (320, 240)),
        ((1920, 1440), (240, 320)),
    ):
        camera = Camera(*size, 500.0, 500.0, 0.0, 0.0)
        shape = (size[1], size[0])
        frame = Frame("0", np.zeros((*shape, 3), np.uint8), np.ones(shape, np.float32), camera)
        small = shrunk(frame)
        assert small.depth is not None
        assert small.depth.shape == expected


@pytest.mark.parametrize("interpolation", [cv2.INTER_NEAREST, cv2.INTER_NEAREST_EXACT])
@pytest.mark.parametrize("size", [(512, 384), (640, 480), (1920, 1440)])
def test_repeated_readings_are_seen_once(size: tuple[int, int], interpolation: int) -> None:
    own = frame_at(camera_at(256, 192))
    large = enlarged(own, size, interpolation)
    assert own.depth is not None
    assert large.depth is not None
    repeats = find_repeats(large.depth)
    assert (repeats.shape, repeats.full_shape) == ((192, 256), size[::-1])
    np.testing.assert_array_equal(repeats.pick(large.depth), own.depth)
    np.testing.assert_array_equal(repeats.repeat(own.depth), large.depth)
    expected, found = Teacher().segment(own), Teacher().segment(large)
    assert len(expected.objects) == 3
    for name in ("labels", "cluster_of_pixel", "found"):
        np.testing.assert_array_equal(
            getattr(found, name), repeats.repeat(getattr(expected, name)), err_msg=name
        )
    for one, other in zip(expected.clusters, found.clusters, strict=True):
        assert one.size == other.size
        u_min, v_min, u_max, v_max = other.box
        where = np.argwhere(found.cluster_of_pixel == 1 + found.clusters.index(other))
        assert (where.min(axis=0) >= (v_min, u_min)).all()
        assert (where.max(axis=0) < (v_max, u_max)).all()


def test_masks_part_things_of_repeated_readings_and_end_where_they_are_drawn() -> None:
    large = enlarged(frame_at(camera_at(256, 192)), (640, 480), cv2.INTER_NEAREST)
    assert large.depth is not None
    alone = Teacher().segment(large)
    regions = alone.instances().astype(np.int32)
    # One more column, in which depth has no reading: as fine as colour, not as depth.
    v, u = (int(place) for place in np.argwhere(regions == 1)[-1])
    depth = large.depth.copy()
    depth[v, u + 1] = np.nan
    regions[v, u + 1] = 1
    found = Teacher(masks=lambda frame: regions).segment(replace(large, depth=depth))
    assert found.labels[v, u + 1] == Label.SALIENT
    assert len(found.objects) == len(alone.objects) == 3


def test_confidence_of_repeated_readings_is_theirs() -> None:
    own = frame_at(camera_at(256, 192))
    large = enlarged(own, (640, 480), cv2.INTER_NEAREST)
    teacher = Teacher()
    expected = teacher.confidence(own, teacher.segment(own))
    found = teacher.confidence(large, teacher.segment(large))
    assert expected.max() > 0.9
    assert large.depth is not None
    repeated = find_repeats(large.depth).repeat(expected)
    np.testing.assert_allclose(found, repeated, atol=0.01)


def test_memory_and_survey_see_repeated_readings_once() -> None:
    poses = [look(heading, distance=1.9, height=1.0, tilt_deg=25.0) for heading in (0, 20, 40)]
    camera = camera_at(160, 120)
    own = [frame_at(camera, pose) for pose in poses]
    large = [enlarged(frame, (640, 480), cv2.INTER_NEAREST) for frame in own]
    surveys = [survey_recording(frames, scene="floor") for frames in (own, large)]
    assert surveys[1].floor_height == surveys[0].floor_height
    assert surveys[1].repeats is not None
    assert surveys[1].repeats.shape == (120, 160)
    memories = [TemporalTeacher(Teacher(survey)) for survey in surveys]
    for frame, repeated in zip(own, large, strict=True):
        expected, found = memories[0].segment(frame), memories[1].segment(repeated)
        assert expected.objects
        np.testing.assert_array_equal(found.labels[::4, ::4], expected.labels)


def slanted_wall() -> Depth:
    """Return a smooth wall as a sensor without noise reads it, in whole millimetres."""
    x = (np.arange(640) - CAMERA.cx) / CAMERA.fx
    return np.tile(np.round(1000 / (0.6 + 0.03 * x)) / 1000, (480, 1)).astype(np.float32)


def kinect_steps() -> Depth:
    """Return a floor in the steps of a Kinect's disparity."""
    y = (np.arange(480) - CAMERA.cy) / CAMERA.fy
    steps = np.round((0.5 + 0.3 * y) / 0.0028) * 0.0028
    return np.tile(1 / steps[:, None], (1, 640)).astype(np.float32)


def boxes_before_a_wall() -> Depth:
    depth = np.full((480, 640), 1.0, np.float32)
    for place in range(0, 400, 20):
        depth[place : place + 13, place : place + 17] = 0.8 + place / 10000
    return depth


@pytest.mark.parametrize(
    "depth",
    [
        slanted_wall(),
        kinect_steps(),
        boxes_before_a_wall(),
        np.ones((480, 640), np.float32),
        np.full((480, 640), np.nan, np.float32),
        np.ones((3, 2), np.float32),
        np.maximum(slanted_wall(), np.float32(1.66)) * np.round(kinect_steps(), 2),
    ],
    ids=["wall", "floor", "boxes", "even", "nothing", "tiny", "both"],
)
def test_steps_of_a_sensor_are_no_repeats(depth: Depth) -> None:
    repeats = find_repeats(depth)
    assert repeats.shape == repeats.full_shape == depth.shape


def test_holes_are_repeated_too() -> None:
    depth = frame_at(camera_at(160, 120)).depth
    assert depth is not None
    depth[30:60, 40:90] = np.nan
    large = np.repeat(np.repeat(depth, 3, axis=0), 3, axis=1)
    assert find_repeats(large).shape == depth.shape
