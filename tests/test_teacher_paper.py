"""What the paper's own teacher says of scenes where the truth is known."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight import open_dataset
from curiosight.evaluation import TeacherCounts, score_frame
from curiosight.frame import Camera, Frame, Label
from curiosight.teacher import (
    Cluster,
    PaperSettings,
    PaperSupport,
    PaperTeacher,
    Segmentation,
    Verdict,
)
from curiosight.teacher.cloud.view import border_mask
from curiosight.teacher.paper.paper_settings import PAPER_TABLE
from curiosight.teacher.paper.paper_teacher import voxel_clusters
from curiosight.teacher.things.clusters import euclidean_clusters
from room import ROOM, Box, View
from scenes import CAMERA, ON_TABLE, TABLE_TOP, WALL, kinect_noise, see

GREY = (90, 90, 90)
CUBE = Box((0.0, 0.0, 0.15), (0.30, 0.30, 0.30), GREY)
NEAR_WALL = replace(WALL, centre=(0.0, 1.4, 1.25))


def noisy_room() -> tuple[Frame, View]:
    frame, view = see((*ROOM[:3], NEAR_WALL))
    assert frame.depth is not None
    noisy = kinect_noise(frame.depth, np.random.default_rng(0))
    return replace(frame, depth=noisy), view


def largest(segmentation: Segmentation) -> Cluster:
    return max(segmentation.clusters, key=lambda cluster: cluster.n_pixels)


def share(labels: np.ndarray, where: np.ndarray, label: Label) -> float:
    return float(np.mean(labels[where] == label))


def test_boxes_are_salient_floor_and_wall_are_not() -> None:
    frame, view = see((*ROOM[:3], NEAR_WALL))
    found = PaperTeacher().segment(frame)
    assert found.problem is None
    assert [cluster.verdict for cluster in found.objects] == 3 * [Verdict.OBJECT]
    is_box = np.isin(view.surface, (1, 2, 3))
    # Five centimetres of a box count as floor.
    assert 0.80 < share(found.labels, is_box, Label.SALIENT) < 0.95
    assert share(found.labels, ~is_box, Label.NOT_SALIENT) > 0.98
    assert share(view.ground_truth, found.labels == Label.SALIENT, Label.SALIENT) > 0.99
    assert set(np.unique(found.labels)) <= {int(label) for label in Label}
    assert found.labels.dtype == np.uint8


def test_what_is_far_or_has_no_reading_is_unavailable() -> None:
    frame, _ = see((CUBE, WALL), distance=2.5)
    assert frame.depth is not None
    frame.depth[300:320, 300:340] = np.nan
    labels = PaperTeacher().segment(frame).labels
    np.testing.assert_array_equal(labels == Label.UNAVAILABLE, ~(frame.depth <= 4))
    assert (frame.depth > 4).any()


def test_noise_of_a_kinect_changes_little() -> None:
    frame, view = noisy_room()
    labels = PaperTeacher().segment(frame).labels
    assert share(labels, np.isin(view.surface, (1, 2, 3)), Label.SALIENT) > 0.80
    assert share(view.ground_truth, labels == Label.SALIENT, Label.SALIENT) > 0.98


def test_clusters_are_measured() -> None:
    found = PaperTeacher().segment(see((CUBE, WALL))[0])
    (cluster,) = found.objects
    assert cluster.size == pytest.approx((0.30, 0.30, 0.30), abs=0.04)
    assert cluster.distance == pytest.approx(1.94, abs=0.1)
    rows, columns = np.nonzero(found.instances() == 1)
    box = (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
    assert cluster.box == pytest.approx(box, abs=2)
    assert cluster.n_pixels == pytest.approx(len(rows), rel=0.02)


@pytest.mark.parametrize(
    ("box", "verdict"),
    [
        (CUBE, Verdict.OBJECT),
        (Box((0.0, -0.9, 0.03), (0.05, 0.05, 0.06), GREY), Verdict.SMALL),
        (Box((0.0, 0.3, 0.40), (1.40, 0.70, 0.80), GREY), Verdict.LARGE),
        (replace(CUBE, centre=(-1.25, 0.0, 0.15)), Verdict.CUT),
        (Box((0.0, 2.10, 0.30), (0.50, 0.50, 0.60), GREY), Verdict.FAR),
    ],
)
def test_each_test_of_the_paper_names_its_verdict(box: Box, verdict: Verdict) -> None:
    frame, view = see((box,), distance=2.2)
    found = PaperTeacher().segment(frame)
    assert largest(found).verdict is verdict
    label = Label.SALIENT if verdict is Verdict.OBJECT else Label.UNKNOWN
    number = found.clusters.index(largest(found)) + 1
    assert set(found.labels[found.cluster_of_pixel == number]) == {label}
    assert np.mean(view.surface[found.cluster_of_pixel == number] == 1) > 0.98


def test_one_point_at_the_border_is_enough() -> None:
    frame, view = see((CUBE,))
    assert frame.depth is not None
    columns = np.flatnonzero((view.surface == 1).any(axis=0))
    for margin, verdict in ((9, Verdict.CUT), (14, Verdict.OBJECT)):
        window = (0, 0, int(columns.max()) + margin, 480)
        cut = replace(frame, camera=replace(CAMERA, depth_window=window))
        assert largest(PaperTeacher().segment(cut)).verdict is verdict


def test_border_is_the_frame_of_the_image_and_of_its_depth() -> None:
    whole = border_mask(Camera(40, 30, 30.0, 30.0, 20.0, 15.0), 1, 10, outline_px=10)
    assert (~whole).sum() == 20 * 10
    assert not whole[10:20, 10:30].any()
    window = border_mask(Camera(40, 30, 30.0, 30.0, 20.0, 15.0, (5, 0, 30, 30)), 1, 4, outline_px=4)
    assert not window[4:26, 9:26].any()
    assert (~window).sum() == 22 * 17
    assert border_mask(Camera(12, 9, 9.0, 9.0, 6.0, 4.0), 1, 10, outline_px=10).all()


def test_what_is_below_a_table_is_not_salient() -> None:
    on_floor = Box((-1.0, 1.1, 0.15), (0.25, 0.25, 0.30), GREY)
    top = replace(TABLE_TOP, size=(1.20, 1.20, 0.04))
    frame, view = see((top, ON_TABLE, on_floor), distance=0.5, height=1.3, tilt_deg=40)
    found = PaperTeacher("table").segment(frame)
    assert len(found.objects) == 1
    assert share(found.labels, view.surface == 2, Label.SALIENT) > 0.9
    below = np.isin(view.surface, (0, 3)) & (view.depth <= 4)
    assert (view.surface == 3).sum() > 500
    assert share(found.labels, below, Label.NOT_SALIENT) > 0.99


def test_what_is_higher_than_the_slab_is_unknown() -> None:
    shelf = Box((0.0, 1.5, 2.15), (0.6, 0.4, 0.20), GREY)
    frame, view = see((shelf,), height=1.6, tilt_deg=0)
    found = PaperTeacher().segment(frame)
    is_shelf = (view.surface == 1) & (view.depth <= 4)
    assert is_shelf.sum() > 500
    assert share(found.labels, is_shelf, Label.UNKNOWN) > 0.95
    assert not found.cluster_of_pixel[is_shelf & (found.labels == Label.UNKNOWN)].any()


def test_only_large_upright_planes_are_walls() -> None:
    screen = Box((0.0, 0.6, 0.5), (1.0, 0.04, 0.8), GREY)
    assert len(PaperTeacher().segment(see((screen,))[0]).objects) == 1
    wide = replace(screen, size=(1.7, 0.04, 0.8))
    frame, view = see((wide,))
    found = PaperTeacher().segment(frame)
    assert share(found.labels, view.surface == 1, Label.NOT_SALIENT) > 0.95


def test_a_box_before_a_wall_stays_an_object() -> None:
    before = replace(CUBE, centre=(0.0, 1.0, 0.15))
    frame, view = see((before, NEAR_WALL))
    found = PaperTeacher().segment(frame)
    assert len(found.objects) == 1
    assert share(found.labels, view.surface == 1, Label.SALIENT) > 0.6


def test_same_seed_same_bytes_whatever_was_seen_before() -> None:
    frame, _ = noisy_room()
    teacher = PaperTeacher()
    first = teacher.segment(frame)
    teacher.segment(see((CUBE,))[0])
    for again in (teacher.segment(frame), PaperTeacher().segment(frame)):
        assert again.labels.tobytes() == first.labels.tobytes()
        assert again.cluster_of_pixel.tobytes() == first.cluster_of_pixel.tobytes()
        assert again.clusters == first.clusters
    other = PaperTeacher(settings=PaperSettings(seed=1)).segment(frame)
    assert other.labels.tobytes() != first.labels.tobytes()
    assert np.mean(other.labels == first.labels) > 0.99


def looking_at_a_wall() -> tuple[Frame, View]:
    return see((replace(WALL, centre=(0.0, -0.8, 1.25)),), tilt_deg=0)


@pytest.mark.parametrize(
    ("frame", "problem"),
    [
        (looking_at_a_wall()[0], "no floor is in view"),
        (replace(see()[0], depth=np.full((480, 640), np.nan, np.float32)), "no floor is in view"),
        (replace(see()[0], depth=None, camera=None), "the frame has no depth"),
        (replace(see()[0], problem="no such file"), "no such file"),
    ],
)
def test_frames_that_cannot_teach_say_why(frame: Frame, problem: str) -> None:
    found = PaperTeacher().segment(frame)
    assert found.problem == problem
    depth = frame.depth if frame.depth is not None else np.full((480, 640), np.nan)
    expected = np.where(depth <= 4.0, Label.UNKNOWN, Label.UNAVAILABLE)
    np.testing.assert_array_equal(found.labels, expected)
    assert found.clusters == ()


def test_a_plane_that_few_surfaces_lie_in_is_no_floor() -> None:
    rng = np.random.default_rng(0)
    frame = replace(see()[0], depth=rng.uniform(0.5, 4, (480, 640)).astype(np.float32))
    assert PaperTeacher("table").segment(frame).problem == "no table is in view"


@pytest.mark.parametrize("shape", [(1, 640), (480, 1), (2, 2), (7, 9)])
@pytest.mark.parametrize("depth", [np.nan, 0.5, 1.0, 10.0])
def test_any_shape_of_image_is_taken(shape: tuple[int, int], depth: float) -> None:
    height, width = shape
    camera = Camera(width, height, 500.0, 500.0, width / 2, height / 2)
    rgb = np.zeros((*shape, 3), np.uint8)
    frame = Frame("small", rgb, np.full(shape, depth, np.float32), camera)
    labels = PaperTeacher().segment(frame).labels
    assert labels.shape == shape
    assert not (labels == Label.SALIENT).any()


def same_partition(a: np.ndarray, b: np.ndarray) -> bool:
    n_pairs = len({*zip(a.tolist(), b.tolist(), strict=True)})
    return n_pairs == len({*a.tolist()}) == len({*b.tolist()})


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n_points=st.integers(0, 400),
    leaf=st.floats(0.01, 0.2),
    ratio=st.floats(0.3, 4),
)
def test_k_d_tree_finds_the_clusters_of_the_hash_table(
    seed: int, n_points: int, leaf: float, ratio: float
) -> None:
    xyz = np.random.default_rng(seed).uniform(-1, 1, (n_points, 3))
    number, n_voxels = voxel_clusters(xyz, leaf=leaf, tolerance=ratio * leaf)
    assert same_partition(number, euclidean_clusters(xyz, leaf=leaf, tolerance=ratio * leaf))
    cells = np.floor(xyz / leaf)
    for cluster, expected in enumerate(n_voxels):
        assert len(np.unique(cells[number == cluster], axis=0)) == expected


def test_size_limits_in_voxels_are_half_the_square_and_the_square() -> None:
    assert PAPER_TABLE.voxel_limits == pytest.approx((8, 1600))
    assert PaperSupport().voxel_limits == pytest.approx((0.5 * (0.1 / 0.06) ** 2, 625))


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: PaperSupport(leaf=0.0), "leaf"),
        (lambda: PaperSupport(min_size=2.0), "min_size"),
        (lambda: PaperSupport(min_height=3.0), "min_height"),
        (lambda: PaperSettings(max_range=-1.0), "max_range"),
        (lambda: PaperSettings(seed=-1), "seed"),
        (lambda: PaperTeacher("shelf"), "scene"),  # type: ignore[arg-type]
    ],
)
def test_settings_are_checked(make, name: str) -> None:
    with pytest.raises(ValueError, match=name):
        make()


def test_settings_reach_the_teacher() -> None:
    frame, _ = see((CUBE,))
    strict = PaperSettings(floor=PaperSupport(min_size=1.0))
    assert largest(PaperTeacher(settings=strict).segment(frame)).verdict is Verdict.SMALL
    near = PaperSettings(max_range=1.5)
    assert (PaperTeacher(settings=near).segment(frame).labels == Label.UNAVAILABLE).mean() > 0.3


DATA = os.environ.get("CURIOSIGHT_TEST_DATA")


@pytest.mark.skipif(DATA is None, reason="CURIOSIGHT_TEST_DATA is not set")
def test_tables_of_a_real_kinect() -> None:
    dataset = open_dataset(Path(DATA or "") / "data/osd_learn")
    teacher, counts = PaperTeacher("table"), TeacherCounts()
    for index in range(0, len(dataset), 5):
        frame, truth = dataset[index], dataset.ground_truth(index)
        assert truth is not None
        counts += score_frame(frame, teacher.segment(frame), truth).counts
    assert counts.precision > 0.97
    assert counts.recall > 0.90
