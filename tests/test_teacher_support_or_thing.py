"""What stands free and carries nothing is an object; what carries something is its support."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation, Survey, Teacher, survey_recording
from curiosight.teacher.segmented import CODE_OF, FOUND_AS
from curiosight.teacher.supports.tops import Kind
from room import Box, View
from scenes import CAMERA, as_frame, kinect_noise, see

WOOD = (150, 110, 60)
FAR_WALL = Box((0.0, 4.0, 1.25), (12.0, 0.2, 2.5), (190, 190, 170), is_salient=False)
HEADINGS = (0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0)


def block(
    x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], *, salient: bool = True
) -> Box:
    low, high = np.transpose((x, y, z))
    return Box(tuple((low + high) / 2), tuple(high - low), WOOD, is_salient=salient)


def board_on_legs(width: float, depth: float, height: float, *, salient: bool) -> tuple[Box, ...]:
    half, x, y = 0.02, width / 2 - 0.03, depth / 2 - 0.03
    under = height - 0.03
    board = block(
        (-width / 2, width / 2), (-depth / 2, depth / 2), (under, height), salient=salient
    )
    legs = [
        block((a - half, a + half), (b - half, b + half), (0, under), salient=salient)
        for a in (-x, x)
        for b in (-y, y)
    ]
    return (board, *legs)


def cabinet(width: float, depth: float, height: float, *, salient: bool = True) -> Box:
    return block((-width / 2, width / 2), (-depth / 2, depth / 2), (0, height), salient=salient)


def armchair() -> tuple[Box, ...]:
    return (
        block((-0.28, 0.28), (-0.3, 0.22), (0, 0.42)),
        block((-0.4, -0.28), (-0.3, 0.38), (0, 0.6)),
        block((0.28, 0.4), (-0.3, 0.38), (0, 0.6)),
        block((-0.28, 0.28), (0.22, 0.38), (0, 0.85)),
    )


def bin_with_something() -> tuple[Box, ...]:
    x, y, z, wall = 0.22, 0.16, 0.35, 0.015
    return (
        block((-x, x), (-y, wall - y), (0, z)),
        block((-x, x), (y - wall, y), (0, z)),
        block((-x, wall - x), (-y, y), (0, z)),
        block((x - wall, x), (-y, y), (0, z)),
        block((-0.1, 0.12), (-0.08, 0.06), (0, 0.42)),
    )


@lru_cache(maxsize=32)
def shots(boxes: tuple[Box, ...]) -> tuple[tuple[Frame, View], ...]:
    """Return noisy posed frames from all sides."""
    rng, found = np.random.default_rng(0), []
    for heading in HEADINGS:
        frame, view = see(
            (*boxes, FAR_WALL),
            heading_deg=heading,
            distance=2.0,
            height=1.2,
            tilt_deg=25,
            with_pose=True,
        )
        depth = kinect_noise(view.depth, rng)
        found.append((replace(frame, depth=depth), view))
    return tuple(found)


def segmented(
    boxes: tuple[Box, ...], scene: str = "auto", *, posed: bool = True
) -> tuple[Survey, list[tuple[Segmentation, View]]]:
    both = shots(boxes)
    frames = [frame if posed else replace(frame, T_world_camera=None) for frame, _ in both]
    survey = survey_recording(frames, scene=scene)
    views = [view for _, view in both]
    teacher = Teacher(survey)
    return survey, [(teacher.segment(f), v) for f, v in zip(frames, views, strict=True)]


def precision_and_recall(found: list[tuple[Segmentation, View]]) -> tuple[float, float]:
    counts = np.zeros(3)
    for segmentation, view in found:
        is_salient, truth = segmentation.labels == Label.SALIENT, view.ground_truth == 255
        truth &= np.isfinite(view.depth)
        counts += (is_salient & truth).sum(), is_salient.sum(), truth.sum()
    return float(counts[0] / max(1, counts[1])), float(counts[0] / counts[2])


BARE = {
    "a cabinet": (cabinet(0.8, 0.46, 0.55),),
    "a bedside cabinet": (cabinet(0.4, 0.35, 0.5),),
    "a low sideboard": (cabinet(1.15, 0.4, 0.6),),
    "a washing machine": (cabinet(0.6, 0.6, 0.85),),
    "an armchair": armchair(),
    "a stool": board_on_legs(0.36, 0.36, 0.45, salient=True),
    "a coffee table": board_on_legs(0.85, 0.55, 0.45, salient=True),
    "a small desk": board_on_legs(1.0, 0.6, 0.74, salient=True),
    "a bin with something in it": bin_with_something(),
}


@pytest.mark.parametrize("boxes", BARE.values(), ids=BARE)
def test_what_carries_nothing_is_an_object(boxes: tuple[Box, ...]) -> None:
    survey, found = segmented(boxes)
    precision, recall = precision_and_recall(found)
    assert precision > 0.97
    assert recall > 0.85
    assert all(table.kind is Kind.THING for table in survey.tables)


MUG = block((-0.05, 0.05), (-0.02, 0.08), (0.45, 0.57))
CARTON = block((0.15, 0.33), (-0.1, 0.08), (0.45, 0.6))
LADEN = {
    "a coffee table": (*board_on_legs(0.85, 0.55, 0.45, salient=False), MUG, CARTON),
    "a cabinet": (cabinet(0.85, 0.46, 0.45, salient=False), MUG, CARTON),
}


@pytest.mark.parametrize("posed", [True, False])
@pytest.mark.parametrize("boxes", LADEN.values(), ids=LADEN)
def test_what_carries_something_is_a_support(boxes: tuple[Box, ...], posed: bool) -> None:
    _, found = segmented(boxes, posed=posed)
    precision, recall = precision_and_recall(found)
    assert precision > 0.95
    assert recall > 0.8
    n_told = 0
    for segmentation, view in found:
        is_top = (view.surface == 1) & (segmentation.reasons() == CODE_OF[FOUND_AS[Kind.TABLE]])
        n_told += np.count_nonzero(is_top) > 1000
        names = {support.name for support in segmentation.supports}
        assert names & {"table", "support or thing"}
    # One view alone may not show all around a thing that it stands.
    assert n_told >= (len(found) if posed else len(found) - 1)


def test_stool_with_a_thing_on_it_is_never_taught_as_background() -> None:
    stool = board_on_legs(0.42, 0.42, 0.45, salient=False)
    survey, found = segmented((*stool, MUG))
    assert [table.kind for table in survey.tables] == [Kind.DOUBTFUL]
    precision, recall = precision_and_recall(found)
    assert precision > 0.95
    assert recall > 0.8
    for segmentation, view in found:
        is_top = view.surface == 1
        assert np.mean(segmentation.labels[is_top] == Label.NOT_SALIENT) < 0.02


def test_bare_table_that_is_larger_than_objects_is_none() -> None:
    for posed in (True, False):
        _, found = segmented(board_on_legs(1.6, 0.8, 0.74, salient=False), posed=posed)
        for segmentation, view in found:
            n_salient = np.count_nonzero(segmentation.labels == Label.SALIENT)
            assert n_salient < 0.01 * view.depth.size


def test_robot_on_a_floor_takes_a_laden_table_for_one_object() -> None:
    salient = [replace(box, is_salient=True) for box in LADEN["a coffee table"]]
    survey, found = segmented(tuple(salient), "floor")
    assert survey.floor_only
    precision, recall = precision_and_recall(found)
    assert precision > 0.97
    assert recall > 0.85
    assert all({s.name for s in segmentation.supports} == {"floor"} for segmentation, _ in found)


def test_on_a_table_scene_the_lowest_support_is_the_table() -> None:
    board = block((-0.8, 0.8), (-0.6, 0.6), (0.7, 0.74), salient=False)
    mug = block((-0.05, 0.05), (-0.05, 0.05), (0.74, 0.86))
    frame, view = see((board, mug), distance=0.8, height=1.4, tilt_deg=45)
    cut = replace(frame, depth=np.where(view.surface > 0, frame.depth, np.float32(np.nan)))
    found = Teacher(Survey("table")).segment(as_frame(replace(view, depth=cut.depth), CAMERA))
    assert [support.name for support in found.supports] == ["table"]
    assert len(found.objects) == 1
