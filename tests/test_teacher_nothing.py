"""Where there is nothing to find, nothing is found; where depth is nonsense, nothing breaks."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from curiosight.frame import Camera, Depth, Frame, Label
from curiosight.teacher import Teacher, survey_recording
from room import Box, kinect, look, render
from scenes import CAMERA, TABLE_TOP, as_frame, kinect_noise

GREY = (150, 150, 150)
WALL = Box((0.0, 3.0, 1.25), (12.0, 0.2, 2.5), GREY, is_salient=False)
LEFT = Box((-2.0, 1.0, 1.25), (0.2, 12.0, 2.5), GREY, is_salient=False)
RIGHT = Box((2.0, 1.0, 1.25), (0.2, 12.0, 2.5), GREY, is_salient=False)
CORRIDOR = tuple(Box((x, 4.0, 1.25), (0.2, 20.0, 2.5), GREY, is_salient=False) for x in (-0.8, 0.8))
LEGS = tuple(
    Box((x, y, 0.34), (0.06, 0.06, 0.68), GREY, is_salient=False)
    for x in (-0.55, 0.55)
    for y in (-0.15, 0.55)
)
SCENES = {
    "an empty room": (WALL, LEFT, RIGHT),
    "a corridor": CORRIDOR,
    "a bare floor": (),
    "a bare table": (TABLE_TOP, *LEGS, WALL),
}


def n_salient(labels: np.ndarray) -> int:
    return int(np.count_nonzero(labels == Label.SALIENT))


def shot(boxes: tuple[Box, ...], heading: float, height: float, tilt: float) -> Frame:
    pose = look(heading, distance=1.9, height=height, tilt_deg=tilt)
    view = render(CAMERA, pose, boxes)
    return Frame(
        "empty", view.rgb, kinect_noise(view.depth, np.random.default_rng(0)), CAMERA, pose
    )


@pytest.mark.parametrize("boxes", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("height", [0.4, 1.0, 1.6])
@pytest.mark.parametrize("tilt", [5, 20, 45])
def test_nothing_is_salient(boxes: tuple[Box, ...], height: float, tilt: float) -> None:
    frames = [shot(boxes, heading, height, tilt) for heading in (0.0, 25.0, 130.0, 200.0, 290.0)]
    teacher = Teacher(survey_recording(frames))
    for frame in frames:
        assert n_salient(teacher.segment(frame).labels) == 0
        alone = Teacher().segment(replace(frame, T_world_camera=None))
        # One view alone, from below its top, may see a table's legs better than its top.
        most = 0.02 if boxes is SCENES["a bare table"] else 0
        assert n_salient(alone.labels) <= most * alone.labels.size


def test_wall_at_a_metre_shows_nothing_salient() -> None:
    near = Box((0.0, 1.1, 1.25), (12.0, 0.2, 2.5), GREY, is_salient=False)
    for tilt in (0.0, 10.0, 30.0):
        pose = look(0.0, distance=0.0, height=1.0, tilt_deg=tilt)
        frame = as_frame(render(CAMERA, pose, (near,)), CAMERA, None)
        assert n_salient(Teacher().segment(frame).labels) == 0


@cache
def nonsense() -> dict[str, Depth]:
    """Return depth images that no sensor should give."""
    rng = np.random.default_rng(0)
    shape = (480, 640)
    noise = rng.uniform(0.5, 4, shape).astype(np.float32)
    one = np.full(shape, np.nan, np.float32)
    one[9, 320] = 1.0
    return {
        "no reading": np.full(shape, np.nan, np.float32),
        "one reading": one,
        "constant": np.full(shape, 1.5, np.float32),
        "noise": noise,
        "noise and holes": np.where(rng.random(shape) < 0.5, np.nan, noise),
        "millimetres taken for metres": np.full(shape, 1500.0, np.float32),
        "tiny": np.full(shape, 1e-6, np.float32),
        "one column": np.linspace(1, 3, 480, dtype=np.float32)[:, None],
        "one row": np.linspace(1, 3, 640, dtype=np.float32)[None],
        "one pixel": np.ones((1, 1), np.float32),
        "4K of noise": rng.uniform(0.5, 4, (2160, 3840)).astype(np.float32),
    }  # fmt: skip


@pytest.mark.parametrize("name", nonsense())
def test_nonsense_breaks_nothing_and_is_no_object(name: str) -> None:
    depth = nonsense()[name]
    height, width = depth.shape
    camera = Camera(width, height, 0.82 * width, 0.82 * width, (width - 1) / 2, (height - 1) / 2)
    rgb = np.zeros((height, width, 3), np.uint8)
    for pose in (None, look(0.0)):
        frame = Frame(name, rgb, depth, camera, pose)
        survey = survey_recording([frame, frame, frame])
        labels = Teacher(survey).segment(frame).labels
        assert labels.shape == depth.shape
        assert n_salient(labels) == 0


def test_objects_of_a_4k_image_are_found() -> None:
    camera = kinect(3840, 2880)
    boxes = (Box((0.0, 0.0, 0.15), (0.3, 0.3, 0.3), GREY), WALL)
    view = render(camera, look(0.0), boxes)
    labels = Teacher().segment(as_frame(view, camera)).labels
    assert np.mean(labels[view.surface == 1] == Label.SALIENT) > 0.9
