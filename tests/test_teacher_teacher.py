"""What the teacher says of scenes where the truth is known, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.frame import Camera, Frame, Label
from curiosight.teacher import (
    REASONS,
    Cluster,
    Segmentation,
    SegmentationSettings,
    SupportSettings,
    Survey,
    Teacher,
    Verdict,
)
from curiosight.teacher.cloud.view import border_mask
from curiosight.teacher.segmented import CODE_OF, DOUBTED
from curiosight.teacher.supports.table_map import CELL, Table
from room import ROOM, Box, look, render
from scenes import CAMERA, ON_FLOOR, ON_TABLE, TABLE_TOP, WALL, as_frame, kinect_noise, see

CUBE = Box((0.0, 0.0, 0.10), (0.20, 0.20, 0.20), (200, 40, 40))
GREY = (90, 90, 90)


def segment(*boxes: Box, distance: float = 1.9) -> Segmentation:
    return Teacher().segment(see((*boxes, WALL), distance=distance)[0])


def verdicts(segmentation: Segmentation) -> list[Verdict]:
    return [cluster.verdict for cluster in segmentation.clusters]


def verdict_at(*boxes: Box, distance: float = 1.9) -> Verdict:
    """Return the verdict on the largest cluster of the scene."""
    found = segment(*boxes, distance=distance)
    return max(found.clusters, key=lambda cluster: cluster.n_pixels).verdict


def share(labels: np.ndarray, where: np.ndarray, label: Label) -> float:
    return float(np.mean(labels[where] == label))


def test_boxes_are_salient_floor_and_wall_are_not() -> None:
    frame, view = see((*ROOM[:3], replace(WALL, centre=(0.0, 1.6, 1.25))))
    found = Teacher().segment(frame)
    assert found.problem is None
    assert len(found.objects) == 3
    assert len(found.walls) == 1
    # The lowest centimetres of a box are within the noise of the floor.
    assert share(found.labels, np.isin(view.surface, (1, 2, 3)), Label.SALIENT) > 0.92
    is_background = np.isin(view.surface, (0, 4)) & (view.depth < SegmentationSettings().max_range)
    assert share(found.labels, is_background, Label.NOT_SALIENT) > 0.98
    assert share(found.labels, is_background, Label.SALIENT) == 0


def test_noise_of_a_kinect_changes_little() -> None:
    frame, view = see()
    assert frame.depth is not None
    noisy = replace(frame, depth=kinect_noise(frame.depth, np.random.default_rng(0)))
    labels = Teacher().segment(noisy).labels
    is_box = np.isin(view.surface, (1, 2, 3))
    assert share(labels, is_box, Label.SALIENT) > 0.92
    assert share(view.ground_truth, labels == Label.SALIENT, Label.SALIENT) > 0.99


def test_codes_follow_depth() -> None:
    frame, _ = see(distance=2.5)
    assert frame.depth is not None
    frame.depth[100:120, 300:340] = np.nan
    found = Teacher().segment(frame)
    is_out = np.isnan(frame.depth) | (frame.depth > SegmentationSettings().max_range)
    assert share(found.labels, is_out, Label.UNAVAILABLE) == 1
    assert set(np.unique(found.labels)) <= {int(label) for label in Label}
    assert found.labels.shape == frame.depth.shape
    assert found.labels.dtype == np.uint8


def test_clusters_are_measured() -> None:
    found = segment(CUBE)
    (cluster,) = found.objects
    # The far side of a box is not seen, so its length comes from its lid.
    assert cluster.size == pytest.approx((0.20, 0.20, 0.20), abs=0.04)
    assert cluster.support_height == 0
    assert cluster.distance == pytest.approx(2.1, abs=0.15)
    rows, columns = np.nonzero(found.instances() == 1)
    box = (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
    assert cluster.box == pytest.approx(box, abs=3)
    assert cluster.n_pixels == pytest.approx(len(rows), rel=0.03)


def test_reasons_tell_what_was_found_and_why_pixels_are_unknown() -> None:
    found = segment(CUBE, replace(CUBE, centre=(-1.2, 0.0, 0.10)))
    reasons = found.reasons()
    names = {REASONS[code] for code in np.unique(reasons)}
    assert {"floor", "object", "no reading, or beyond the range", Verdict.CUT.value} <= names
    is_known = np.isin(found.labels, [Label.SALIENT, Label.NOT_SALIENT])
    assert np.array_equal(np.isin(reasons, [CODE_OF["floor"], CODE_OF["object"]]), is_known)
    for number, cluster in enumerate(found.clusters, start=1):
        in_cluster = (found.cluster_of_pixel == number) & ~is_known
        told = {REASONS[code] for code in np.unique(reasons[in_cluster])}
        assert told <= {cluster.verdict.value, DOUBTED}


def test_reasons_tell_table_wall_and_what_is_under_a_table() -> None:
    below = Box((0.0, 0.2, 0.15), (0.30, 0.30, 0.30), GREY)
    wall = replace(WALL, centre=(0.0, 1.6, 1.25))
    frame, view = see((TABLE_TOP, below, wall, ON_TABLE), height=1.3)
    reasons = Teacher().segment(frame).reasons()
    for surface, reason in enumerate(("floor", "table", "under a table", "wall", "object")):
        is_there = (view.surface == surface) & (frame.depth < 3.5)
        assert np.mean(reasons[is_there] == CODE_OF[reason]) > 0.7, reason


def test_frame_that_tells_nothing_says_so() -> None:
    nothing = Segmentation.of_labels(np.full((2, 3), Label.UNKNOWN, np.uint8), "no support")
    assert (nothing.reasons() == CODE_OF["the frame tells nothing"]).all()


def test_instances_number_the_objects_alone() -> None:
    flat = Box((-0.6, 0.0, 0.025), (0.40, 0.40, 0.05), GREY)
    found = segment(flat, CUBE)
    assert sorted(verdict.name for verdict in verdicts(found)) == ["FLAT", "OBJECT"]
    instances = found.instances()
    assert set(np.unique(instances)) == {0, 1}
    np.testing.assert_array_equal(instances > 0, found.labels == Label.SALIENT)


def test_small_things_are_unknown() -> None:
    small = Box((0.0, -0.6, 0.025), (0.05, 0.05, 0.05), GREY)
    assert verdict_at(small) is Verdict.SMALL


def test_large_things_are_unknown() -> None:
    bench = Box((0.0, 0.3, 0.15), (1.30, 0.15, 0.30), GREY)
    arm = Box((-0.57, 0.9, 0.22), (0.15, 1.20, 0.44), GREY)
    assert verdict_at(bench, arm, distance=2.2) is Verdict.LARGE


def test_things_that_reach_beyond_the_range_are_unknown() -> None:
    far = Box((0.0, 2.35, 0.20), (0.40, 0.40, 0.40), GREY)
    assert verdict_at(far) is Verdict.FAR


def test_flat_things_are_unknown() -> None:
    assert verdict_at(Box((0.0, 0.0, 0.025), (0.40, 0.40, 0.05), GREY)) is Verdict.FLAT


def test_hovering_things_are_unknown() -> None:
    assert verdict_at(replace(CUBE, centre=(0.0, 0.0, 0.6))) is Verdict.FLOATING


def test_what_hangs_on_a_wall_is_part_of_it() -> None:
    cabinet = Box((0.0, 1.45, 0.6), (0.40, 0.09, 0.30), GREY)
    wall = replace(WALL, centre=(0.0, 1.6, 1.25))
    found = Teacher().segment(see((cabinet, wall))[0])
    assert verdicts(found) == [Verdict.WALL_PART]


def test_side_of_a_cupboard_is_part_of_it() -> None:
    cupboard = Box((1.1, 0.3, 0.45), (2.4, 0.4, 0.90), GREY)
    frame, view = see((cupboard,), heading_deg=40, height=0.85, tilt_deg=10)
    found = Teacher().segment(frame)
    assert len(found.walls) == 1
    assert set(verdicts(found)) == {Verdict.WALL_PART}
    assert share(found.labels, view.surface == 1, Label.SALIENT) == 0


def test_box_that_stands_before_a_wall_stays_an_object() -> None:
    wall = replace(WALL, centre=(0.0, 0.7, 1.25))
    found = Teacher().segment(see((replace(CUBE, centre=(0.0, 0.3, 0.10)), wall))[0])
    assert verdicts(found) == [Verdict.OBJECT]


def in_window(frame: Frame, window: tuple[int, int, int, int]) -> Frame:
    """Return a frame whose depth ends at a window, as registered depth does."""
    assert frame.depth is not None
    u_min, v_min, u_max, v_max = window
    depth = np.full_like(frame.depth, np.nan)
    depth[v_min:v_max, u_min:u_max] = frame.depth[v_min:v_max, u_min:u_max]
    return replace(frame, depth=depth, camera=replace(CAMERA, depth_window=window))


def test_image_border_cuts() -> None:
    at_border = replace(CUBE, centre=(-1.25, 0.0, 0.10))
    assert verdict_at(at_border) is Verdict.CUT


def test_depth_window_cuts_only_what_it_cuts() -> None:
    frame, view = see((CUBE, WALL))
    columns = np.flatnonzero((view.surface == 1).any(axis=0))
    middle = int(columns.mean())
    cut = Teacher().segment(in_window(frame, (30, 20, middle, 470)))
    whole = Teacher().segment(in_window(frame, (30, 20, int(columns.max()) + 20, 470)))
    assert verdicts(cut) == [Verdict.CUT]
    assert verdicts(whole) == [Verdict.OBJECT]


def test_holes_inside_the_view_are_no_border() -> None:
    frame, view = see((CUBE, WALL))
    assert frame.depth is not None
    columns = np.flatnonzero((view.surface == 1).any(axis=0))
    frame.depth[:, columns.max() - 5 : columns.max() + 60] = np.nan
    assert verdicts(Teacher().segment(frame)) == [Verdict.OBJECT]


@pytest.mark.parametrize(
    ("window", "inside"),
    [
        (None, (10, 10, 630, 470)),
        ((0, 0, 640, 480), (10, 10, 630, 470)),
        ((40, 2, 600, 480), (44, 10, 596, 470)),
        ((0, 50, 640, 400), (10, 54, 630, 396)),
    ],
)
def test_border_is_the_frame_and_the_outline_of_the_window(
    window: tuple[int, int, int, int] | None, inside: tuple[int, int, int, int]
) -> None:
    camera = replace(CAMERA, depth_window=window)
    expected = np.ones((480, 640), np.bool_)
    u_min, v_min, u_max, v_max = inside
    expected[v_min:v_max, u_min:u_max] = False
    np.testing.assert_array_equal(border_mask(camera, 2, 10), expected[::2, ::2])


def test_objects_stand_on_table_and_floor() -> None:
    boxes = (TABLE_TOP, ON_TABLE, ON_FLOOR, WALL)
    frame, view = see(boxes, distance=1.9, height=1.4, tilt_deg=30)
    found = Teacher().segment(frame)
    assert [support.is_table for support in found.supports] == [False, True]
    assert sorted(round(cluster.support_height, 1) for cluster in found.objects) == [0.0, 0.7]
    assert share(found.labels, view.surface == 2, Label.SALIENT) > 0.75
    assert share(found.labels, view.surface == 3, Label.SALIENT) > 0.9
    assert share(found.labels, view.surface == 1, Label.NOT_SALIENT) > 0.8
    assert share(view.ground_truth, found.labels == Label.SALIENT, Label.SALIENT) > 0.99


def test_what_is_under_a_table_is_unknown() -> None:
    leg = Box((0.0, 0.0, 0.34), (0.08, 0.08, 0.68), GREY, is_salient=False)
    frame, view = see((TABLE_TOP, leg, WALL), distance=1.9, height=1.4, tilt_deg=30)
    labels = Teacher().segment(frame).labels
    assert (view.surface == 2).sum() > 500
    assert share(labels, view.surface == 2, Label.SALIENT) == 0


def test_known_floor_stays_the_support_below_a_table_that_hides_it() -> None:
    # 1.2 by 0.8 metres around the world's origin, the floor's size in cells of the map.
    inside = np.full((round(0.8 / CELL), round(1.2 / CELL)), 0.2, np.float32)
    table = Table(0.72, np.eye(3)[:, :2], np.array([-0.6, -0.2]), inside)
    survey = Survey("floor", np.array([0.0, 0.0, 1.0]), 0.0, (table,))
    near = replace(ON_TABLE, centre=(0.15, 0.0, 0.80))
    frame, _ = see((TABLE_TOP, near), distance=0.5, height=1.3, tilt_deg=55, with_pose=True)
    found = Teacher(survey, SegmentationSettings(stride=2)).segment(frame)
    assert [support.is_table for support in found.supports] == [False, True]
    assert [round(cluster.support_height, 1) for cluster in found.objects] == [0.7]


def test_largest_surface_is_not_the_floor_where_much_lies_below_it() -> None:
    frame, _ = see((CUBE, WALL), tilt_deg=40)
    assert frame.depth is not None
    # 1/z is affine in the pixel: a board that leans 15° from the floor, over most of the image.
    y = (np.arange(480)[:, None] - CAMERA.cy) / CAMERA.fy
    tilt = np.radians(40 + 15)
    board = (0.9 / (np.cos(tilt) * y + np.sin(tilt))).astype(np.float32)
    frame.depth[:, :520] = np.minimum(board, frame.depth[:, :520])
    found = Teacher().segment(frame)
    assert found.problem is None
    assert found.supports[0].plane.offset == pytest.approx(1.0, abs=0.02)


NO_FLOOR = see((WALL,), distance=-1.0, height=1.2, tilt_deg=0)[0]
ROOM_FRAME = see()[0]


@pytest.mark.parametrize(
    ("frame", "problem"),
    [
        (NO_FLOOR, "support"),
        (Frame("flat", ROOM_FRAME.rgb), "no depth"),
        (replace(ROOM_FRAME, depth=np.full((480, 640), np.nan, np.float32)), "no reading"),
        (replace(ROOM_FRAME, problem="the file is cut off"), "the file is cut off"),
        (Frame("bad", ROOM_FRAME.rgb, problem="no such file"), "no such file"),
    ],
)
def test_frames_that_cannot_teach_say_why(frame: Frame, problem: str) -> None:
    found = Teacher().segment(frame)
    assert found.problem is not None
    assert problem in found.problem
    depth = frame.depth if frame.depth is not None else np.full((480, 640), np.nan)
    expected = np.where(depth <= 4.0, Label.UNKNOWN, Label.UNAVAILABLE)
    np.testing.assert_array_equal(found.labels, expected)
    assert found.clusters == found.objects == ()
    assert not found.instances().any()


def test_frame_is_left_as_it_was() -> None:
    frame, view = see()
    Teacher().segment(frame)
    np.testing.assert_array_equal(frame.depth, view.depth)


def test_same_frame_same_answer() -> None:
    first, second = (Teacher().segment(see()[0]) for _ in range(2))
    np.testing.assert_array_equal(first.labels, second.labels)
    np.testing.assert_array_equal(first.cluster_of_pixel, second.cluster_of_pixel)
    assert first.clusters == second.clusters


def test_mirrored_scene_has_mirrored_labels() -> None:
    # An odd width, so that the coarse grid mirrors onto itself.
    camera = Camera(641, 480, 525.0, 525.0, 320.0, 239.5)
    view = render(camera, look(10.0), ROOM)
    frame = as_frame(view, camera)
    mirrored = Frame("m", frame.rgb[:, ::-1], np.ascontiguousarray(view.depth[:, ::-1]), camera)
    labels, flipped = (Teacher().segment(f).labels[:, ::2] for f in (frame, mirrored))
    assert np.mean(labels == flipped[:, ::-1]) > 0.998
    assert (labels == Label.SALIENT).any()


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        (SupportSettings, {"slab": 0.0}),
        (SupportSettings, {"min_size": 2.0}),
        (SegmentationSettings, {"max_range": -1.0}),
    ],
)
def test_settings_are_checked(kind: type, changes: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(changes))):
        kind(**changes)


def test_settings_reach_the_teacher() -> None:
    frame, _ = see((ON_FLOOR,), height=1.2, tilt_deg=30)
    strict = SegmentationSettings(floor=SupportSettings(min_size=1.0))
    assert len(Teacher().segment(frame).objects) == 1
    assert [c.verdict for c in Teacher(settings=strict).segment(frame).clusters] == [Verdict.SMALL]


def test_objects_are_the_clusters_that_passed() -> None:
    cluster = Cluster(Verdict.OBJECT, (0, 0, 4, 4), 16, (0.2, 0.2, 0.2), 1.0, 0.0)
    clusters = (replace(cluster, verdict=Verdict.CUT), cluster)
    number = np.array([[0, 1], [2, 2]], np.uint16)
    found = Segmentation(np.zeros((2, 2), np.uint8), number, clusters)
    assert found.objects == (cluster,)
    np.testing.assert_array_equal(found.instances(), [[0, 0], [1, 1]])
