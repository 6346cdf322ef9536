"""Things that touch on a table are told apart, and what they enclose is not the table."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from curiosight.frame import Frame, Label
from curiosight.teacher import TABLE, Segmentation, SegmentationSettings, Survey, Teacher
from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.view import border_mask
from curiosight.teacher.things.hollows import find_hollows
from curiosight.teacher.things.things import Thing, find_things
from curiosight.teacher.things.touching import _join_around, part_touching
from curiosight.teacher.things.union import number_sets
from curiosight.teacher.walls.surroundings import Surroundings
from room import Box, View, look
from scenes import CAMERA, TABLE_TOP, WALL, kinect_noise, see

Array = npt.NDArray[Any]
RED, TOP = (200, 40, 40), 0.72
# Down at the table, from close by.
LOOK = {"distance": 0.9, "height": 1.3, "tilt_deg": 38.0}
# Small things on a grid that is fine enough for them.
FINE = SegmentationSettings(stride=2)
WHOLE = replace(FINE, table=replace(TABLE, part_touching=False))


def box(x: float, y: float, size: tuple[float, float, float], *, on: float = TOP) -> Box:
    """Return a box that stands on the table, or higher."""
    return Box((x, y, on + size[2] / 2), size, RED)


SIDE_BY_SIDE = (box(-0.08, 0.20, (0.16, 0.10, 0.16)), box(0.065, 0.22, (0.13, 0.10, 0.10)))
STACKED = (box(0.0, 0.20, (0.24, 0.20, 0.12)), box(0.0, 0.24, (0.12, 0.10, 0.10), on=TOP + 0.12))
ONE_BEFORE = (box(0.0, 0.02, (0.12, 0.08, 0.12)), box(0.0, 0.12, (0.25, 0.12, 0.25)))
HIDDEN_MIDDLE = (box(0.0, 0.05, (0.10, 0.08, 0.24)), box(0.0, 0.22, (0.45, 0.10, 0.15)))


def look_at(*boxes: Box, heading_deg: float = 0.0, noise: int | None = None) -> tuple[Frame, View]:
    """Return a frame of boxes on the table; noise: seed of a Kinect's, None = none."""
    frame, view = see((TABLE_TOP, WALL, *boxes), heading_deg=heading_deg, **LOOK)
    return with_noise(frame, noise), view


def with_noise(frame: Frame, noise: int | None) -> Frame:
    assert frame.depth is not None
    if noise is None:
        return frame
    return replace(frame, depth=kinect_noise(frame.depth, np.random.default_rng(noise)))


def segment(frame: Frame, limits: SegmentationSettings = FINE) -> Segmentation:
    return Teacher(Survey("table"), limits).segment(frame)


def objects_of(found: Segmentation, view: View) -> list[int]:
    """Return the number of the object that most of each box is in, 0 = none.

    The lowest centimetres of a box are in none, within the noise of the table; and a crease
    is found to some pixels.
    """
    instances, numbers = found.instances(), []
    for surface in range(3, view.surface.max() + 1):
        votes = np.bincount(instances[view.surface == surface])
        assert votes.max() > 0.8 * votes.sum()
        numbers.append(int(votes.argmax()))
    return numbers


@pytest.mark.parametrize("noise", [None, 1])
@pytest.mark.parametrize("heading_deg", [0.0, 30.0])
@pytest.mark.parametrize("boxes", [SIDE_BY_SIDE, STACKED, ONE_BEFORE])
def test_boxes_that_touch_are_two_objects(
    boxes: tuple[Box, Box], heading_deg: float, noise: int | None
) -> None:
    frame, view = look_at(*boxes, heading_deg=heading_deg, noise=noise)
    found = segment(frame)
    assert len(found.objects) == 2
    assert sorted(objects_of(found, view)) == [1, 2]
    assert len(segment(frame, WHOLE).objects) == 1


@pytest.mark.parametrize("noise", [None, 1])
@pytest.mark.parametrize("heading_deg", [0.0, 20.0, 45.0])
def test_box_is_one_object_from_all_sides(heading_deg: float, noise: int | None) -> None:
    frame, view = look_at(box(0.0, 0.2, (0.20, 0.14, 0.15)), heading_deg=heading_deg, noise=noise)
    assert objects_of(segment(frame), view) == [1]


@pytest.mark.parametrize("noise", [None, 1])
def test_box_whose_middle_is_hidden_is_one_object(noise: int | None) -> None:
    frame, view = look_at(*HIDDEN_MIDDLE, noise=noise)
    found = segment(frame)
    nearer, farther = objects_of(found, view)
    assert nearer != farther
    assert len(found.objects) == 2
    columns = np.flatnonzero((found.instances() == farther).any(axis=0))
    assert np.diff(columns).max() > 40


def with_drum(frame: Frame, *, radius: float, height: float, is_open: bool) -> Frame:
    """Return a frame with an upright cylinder on the middle of the table, cast exactly.

    is_open: without a lid, so that one looks at its inside, and at the table for a bottom.
    """
    pose = look(**LOOK)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.dstack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)])
    way, begin = rays @ pose[:3, :3].T, pose[:3, 3] - [0.0, 0.2, 0.0]
    a, b = (way[..., :2] ** 2).sum(axis=2), way[..., :2] @ begin[:2]
    root = np.sqrt(np.maximum(b**2 - a * (begin[:2] @ begin[:2] - radius**2), 0))
    sides = np.stack([(-b - root) / a, (-b + root) / a])
    heights = begin[2] + sides * way[..., 2] - TOP
    sides[~((root > 0) & (heights > 0) & (heights < height))] = np.inf
    lid = (TOP + height - begin[2]) / way[..., 2]
    is_lid = np.linalg.norm(begin[:2] + lid[..., None] * way[..., :2], axis=2) < radius
    lid[~is_lid | (lid < 0) | is_open] = np.inf
    assert frame.depth is not None
    depth = np.min([*sides, lid], axis=0).astype(np.float32)
    return replace(frame, depth=np.fmin(frame.depth, depth))


@pytest.mark.parametrize("noise", [None, 1])
@pytest.mark.parametrize(("radius", "height"), [(0.05, 0.15), (0.10, 0.08), (0.03, 0.12)])
def test_round_things_are_one_object(radius: float, height: float, noise: int | None) -> None:
    frame = with_drum(look_at()[0], radius=radius, height=height, is_open=False)
    (found,) = segment(with_noise(frame, noise)).objects
    assert found.size[2] == pytest.approx(height, abs=0.02)


@pytest.mark.parametrize("noise", [None, 1])
@pytest.mark.parametrize(("radius", "height"), [(0.06, 0.12), (0.10, 0.15)])
def test_cup_whose_bottom_is_out_of_sight_is_one_object(
    radius: float, height: float, noise: int | None
) -> None:
    frame = with_drum(look_at()[0], radius=radius, height=height, is_open=True)
    found = segment(with_noise(frame, noise))
    assert len(found.objects) == 1
    np.testing.assert_array_equal(found.instances() == 1, found.labels == Label.SALIENT)


@pytest.mark.parametrize("noise", [None, 1])
@pytest.mark.parametrize(("radius", "height"), [(0.08, 0.05), (0.07, 0.04), (0.12, 0.06)])
def test_inside_of_a_pot_is_the_same_object_and_its_bottom_unknown(
    radius: float, height: float, noise: int | None
) -> None:
    empty, _ = look_at()
    frame = with_drum(empty, radius=radius, height=height, is_open=True)
    assert frame.depth is not None
    assert empty.depth is not None
    is_wall = frame.depth < empty.depth - 0.01
    is_bottom = ndimage.binary_fill_holes(is_wall) & ~is_wall
    found = segment(with_noise(frame, noise))
    assert len(found.objects) == 1
    assert np.mean(found.labels[is_bottom] == Label.UNKNOWN) > 0.95
    assert np.mean(found.instances()[is_bottom | is_wall] == 1) > 0.9
    assert not np.any(found.labels[found.instances() == 1] == Label.NOT_SALIENT)


@pytest.mark.parametrize("noise", [None, 1])
@pytest.mark.parametrize("heading_deg", [0.0, 30.0])
def test_open_box_is_one_object_and_its_bottom_unknown(
    heading_deg: float, noise: int | None
) -> None:
    sides = [box(x, 0.23, (0.01, 0.30, 0.10)) for x in (-0.15, 0.15)]
    ends = [box(0.0, y, (0.31, 0.01, 0.10)) for y in (0.08, 0.38)]
    frame, view = look_at(*sides, *ends, heading_deg=heading_deg, noise=noise)
    found = segment(frame)
    assert len(found.objects) == 1
    is_wall = view.surface > 2
    is_bottom = ndimage.binary_fill_holes(is_wall) & ~is_wall
    assert np.count_nonzero(is_bottom) > 1000
    assert np.mean(found.labels[is_bottom] == Label.UNKNOWN) > 0.9
    assert np.mean(found.instances()[is_bottom] == 1) > 0.9


def test_table_seen_through_a_loop_stays_table() -> None:
    posts = [box(x, 0.2, (0.05, 0.06, 0.20)) for x in (-0.10, 0.10)]
    bars = [box(0.0, 0.2, (0.25, 0.06, 0.04), on=TOP + height) for height in (0.0, 0.16)]
    frame, view = look_at(*posts, *bars)
    found = segment(frame)
    assert len(found.objects) == 1
    is_loop = view.surface > 2
    is_through = ndimage.binary_fill_holes(is_loop) & ~is_loop & (view.surface == 1)
    assert np.count_nonzero(is_through) > 1000
    assert np.mean(found.labels[is_through] == Label.NOT_SALIENT) > 0.9
    np.testing.assert_array_equal(found.instances() == 1, found.labels == Label.SALIENT)


@pytest.mark.parametrize("boxes", [SIDE_BY_SIDE, STACKED, ONE_BEFORE, HIDDEN_MIDDLE])
def test_labels_stay_when_things_are_parted(boxes: tuple[Box, ...]) -> None:
    frame, _ = look_at(*boxes, noise=2)
    parted, whole = segment(frame), segment(frame, WHOLE)
    np.testing.assert_array_equal(parted.labels, whole.labels)
    np.testing.assert_array_equal(parted.instances() > 0, whole.instances() > 0)
    assert len(parted.objects) == 2


def test_things_on_a_floor_are_not_parted() -> None:
    on_floor = tuple(
        replace(one, centre=(one.centre[0], one.centre[1], one.centre[2] - TOP))
        for one in SIDE_BY_SIDE
    )
    assert len(Teacher().segment(see((*on_floor, WALL), distance=1.2)[0]).objects) == 1


def things_on_table(*boxes: Box, noise: int | None = None) -> tuple[list[Thing], Surroundings]:
    """Return what stands on the table, the largest a group of boxes that touch."""
    frame, _ = look_at(*boxes, noise=noise)
    assert frame.depth is not None
    found, points = segment(frame), observe_points(frame.depth, CAMERA)
    border = border_mask(CAMERA, points.stride, 10)
    support = found.supports[-1]
    assert support.extent is not None
    nowhere = np.zeros(border.shape, np.bool_)
    free = support.extent & (support.heights > 0.02) & ~border
    around = Surroundings(points, [support], [], border, FINE, nowhere, nowhere, free)
    return find_things(np.where(free, 0, -1).astype(np.int8), around), around


APART = box(-0.35, 0.20, (0.10, 0.10, 0.10))


@pytest.mark.parametrize("boxes", [SIDE_BY_SIDE, STACKED, ONE_BEFORE])
def test_parts_have_the_points_of_the_things(boxes: tuple[Box, ...]) -> None:
    things, around = things_on_table(*boxes, APART, noise=3)
    parts = part_touching(things, around)
    assert (len(things), len(parts)) == (2, 3)
    points, expected = (np.concatenate([one.members for one in found]) for found in (parts, things))
    np.testing.assert_array_equal(np.sort(points), np.sort(expected))


def test_order_of_the_parts_is_that_of_the_image() -> None:
    things, around = things_on_table(*SIDE_BY_SIDE, APART, noise=3)
    parts, again = (part_touching(order, around) for order in (things, things[::-1]))
    for one, other in zip(parts, again, strict=True):
        np.testing.assert_array_equal(one.members, other.members)
        assert one.box == other.box
    assert [part.box[1] for part in parts] == sorted(part.box[1] for part in parts)


def test_things_without_normals_stay_whole() -> None:
    things, around = things_on_table(*SIDE_BY_SIDE, APART)
    points = around.points
    unknown = replace(points, normals=np.full_like(points.normals, np.nan))
    blind = replace(around, points=unknown)
    parts = part_touching(things, blind)
    assert len(parts) == len(things) == 2
    for part, thing in zip(parts, things, strict=True):
        np.testing.assert_array_equal(np.sort(part.members), np.sort(thing.members))


def test_points_that_hang_together_with_nothing_stay_with_their_thing() -> None:
    (thing,), around = things_on_table(APART)
    v, u = np.divmod(thing.members, around.points.depth.shape[1])
    is_stray = (v > v.max() - 2) & (u < u.min() + 12)
    is_gap = (v > v.max() - 5) & (u < u.min() + 15) & ~is_stray
    assert np.count_nonzero(is_stray) > 5
    torn = replace(thing, members=thing.members[~is_gap])
    (part,) = part_touching([torn], around)
    np.testing.assert_array_equal(np.sort(part.members), np.sort(torn.members))


SHAPE = (24, 30)


def flat_points(depth: Array) -> Points:
    """Return points of which only the depth is asked."""
    nothing = np.zeros((*depth.shape, 3), np.float32)
    axes = (np.zeros(size, np.float32) for size in depth.shape[::-1])
    return Points(nothing, depth, nothing, depth, *axes, 2)


def hollows_in(number: Array, is_support: Array, depth: Array) -> Array:
    """Return the hollows of all objects, each in its box."""
    boxes = [
        (one, (columns.start, rows.start, columns.stop, rows.stop))
        for one, (rows, columns) in enumerate(ndimage.find_objects(number), start=1)
    ]
    return find_hollows(number, boxes, is_support, flat_points(depth))


def ring(top: int = 6, left: int = 8, side: int = 10) -> Array:
    """(h, w) int32: 1 in a square frame, two cells thick."""
    number = np.zeros(SHAPE, np.int32)
    number[top : top + side, left : left + side] = 1
    number[top + 2 : top + side - 2, left + 2 : left + side - 2] = 0
    return number


LEVEL = np.full(SHAPE, 1.0, np.float32)


def test_ring_encloses_what_it_rises_from() -> None:
    number = ring()
    expected = np.zeros(SHAPE, np.int32)
    expected[8:14, 10:16] = 1
    np.testing.assert_array_equal(hollows_in(number, number == 0, LEVEL), expected)


def test_handle_encloses_nothing() -> None:
    number = ring()
    nearer = np.where(number == 1, LEVEL - 0.1, LEVEL)
    assert not hollows_in(number, number == 0, nearer).any()
    unread = np.where(number == 1, np.float32(np.nan), LEVEL)
    assert not hollows_in(number, number == 0, unread).any()


def test_gap_lets_the_table_in() -> None:
    number = ring()
    number[10, 8:10] = 0
    assert not hollows_in(number, number == 0, LEVEL).any()
    # Cells that meet at a corner do enclose.
    number[10, 8] = 1
    number[9, 8:10] = 1
    assert hollows_in(number, number == 0, LEVEL).any()


@pytest.mark.parametrize("side", ["top", "bottom", "left", "right"])
def test_ring_at_the_image_border_encloses_until_it_is_cut(side: str) -> None:
    for n_cut, n_enclosed in ((0, 36), (1, 36), (2, 0), (5, 0)):
        rows, columns = slice(None), slice(None)
        match side:
            case "top":
                rows = slice(6 + n_cut, None)
            case "bottom":
                rows = slice(None, 16 - n_cut)
            case "left":
                columns = slice(8 + n_cut, None)
            case "right":
                columns = slice(None, 18 - n_cut)
        number = ring()[rows, columns]
        found = hollows_in(number, number == 0, LEVEL[rows, columns])
        assert np.count_nonzero(found) == n_enclosed


def test_hole_that_is_mostly_no_support_is_no_hollow() -> None:
    number = ring()
    is_support = np.zeros(SHAPE, np.bool_)
    is_support[8:11, 10:16] = True
    assert not hollows_in(number, is_support, LEVEL).any()
    is_support[11, 10:16] = True
    np.testing.assert_array_equal(hollows_in(number, is_support, LEVEL) == 1, is_support)


def test_patches_around_a_hollow_are_one_and_what_stands_in_it_another() -> None:
    thing = ring()
    thing[10:12, 12:14] = 2
    # The upper and the lower half of the ring, and what stands in it.
    patch = np.where(thing == 1, 1 + (np.arange(SHAPE[0])[:, None] > 10), 3 * (thing == 2))
    hollows = hollows_in(thing, thing == 0, LEVEL)
    assert np.count_nonzero(hollows == 1) == 32
    parent = np.arange(3)
    _join_around(hollows, thing, patch, parent, reach=2)
    assert number_sets(parent).tolist() == [0, 0, 1]
    parent = np.arange(3)
    _join_around(np.zeros_like(hollows), thing, patch, parent, reach=2)
    assert number_sets(parent).tolist() == [0, 1, 2]


def hollows_by_definition(number: Array, is_support: Array, depth: Array) -> Array:
    """Fill the holes of each object in turn, hole by hole."""
    hollows = np.zeros(SHAPE, np.int32)
    for one in range(1, number.max() + 1):
        is_object = number == one
        holes, n_holes = ndimage.label(ndimage.binary_fill_holes(is_object) & ~is_object)
        for hole in range(1, n_holes + 1):
            bottom = np.argwhere((holes == hole) & is_support)
            upper = [(v - 1, u) for v, u in bottom]
            ends = [
                abs(depth[above] - depth[tuple(cell)]) < 0.03
                for above, cell in zip(upper, bottom, strict=True)
                if not (holes[above] == hole and is_support[above])
            ]
            if len(bottom) > 0.5 * np.count_nonzero(holes == hole) and np.mean(ends) > 0.5:
                hollows[tuple(bottom.T)] = one
    return hollows


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.4, 0.9))
def test_hollows_are_filled_holes(seed: int, density: float) -> None:
    rng = np.random.default_rng(seed)
    number = np.where(rng.random(SHAPE) < density, rng.integers(1, 3, SHAPE), 0).astype(np.int32)
    number[0, :2] = 1, 2
    is_support = (number == 0) & (rng.random(SHAPE) < 0.8)
    depth = (1 + 0.03 * rng.random(SHAPE) * rng.integers(1, 3, SHAPE)).astype(np.float32)
    depth[rng.random(SHAPE) < 0.02] = np.nan
    expected = hollows_by_definition(number, is_support, depth)
    np.testing.assert_array_equal(hollows_in(number, is_support, depth), expected)
