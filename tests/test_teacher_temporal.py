"""Memory of several views: votes on voxels, and what they correct."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.frame import Camera, Frame, Label
from curiosight.teacher import Survey, Teacher, TemporalTeacher
from curiosight.teacher.cloud.tracking import UpTracker
from curiosight.teacher.memory.temporal import Remembered
from curiosight.teacher.memory.votes import FREE, ORIGIN, REJECTED, VoxelVotes
from room import ROOM, Box, look, render
from scenes import CAMERA, WALL, as_frame, see

UP = np.array([0.0, 0.0, 1.0])
CUBE = Box((0.0, 0.0, 0.15), (0.30, 0.30, 0.30), (200, 40, 40))
TINY = Camera(4, 3, 2.0, 2.0, 1.5, 1.0)


def teacher() -> TemporalTeacher:
    return TemporalTeacher(Teacher(Survey("floor", UP, 0.0)))


def view(*boxes: Box, aside: float = 0.0, distance: float = 1.9) -> tuple[Frame, np.ndarray]:
    """Return a frame that looks past the origin by some metres, and where the cube is in it."""
    pose = look(0.0, distance=distance, height=1.0, tilt_deg=25.0)
    pose[0, 3] += aside
    seen = render(CAMERA, pose, (*boxes, WALL))
    return as_frame(seen, CAMERA, pose), seen.surface == 1


def salient_share(labels: np.ndarray, where: np.ndarray) -> float:
    return float(np.mean(labels[where] == Label.SALIENT))


def test_thing_cut_by_the_image_is_salient_once_it_was_seen_whole_twice() -> None:
    temporal = teacher()
    cut, where = view(CUBE, aside=1.2)
    assert where[:, :10].any()
    assert salient_share(temporal.segment(cut).labels, where) == 0
    temporal.remember([view(CUBE, aside=0.4)[0], view(CUBE, aside=0.7)[0]])
    assert salient_share(temporal.segment(cut).labels, where) > 0.8


def test_one_view_of_a_thing_is_not_enough() -> None:
    temporal = teacher()
    temporal.remember([view(CUBE)[0]])
    cut, where = view(CUBE, aside=1.2)
    assert salient_share(temporal.segment(cut).labels, where) == 0


def test_thing_that_has_gone_is_forgotten() -> None:
    temporal = teacher()
    temporal.remember([view(CUBE, aside=0.4)[0], view(CUBE, aside=0.7)[0], view(aside=0.1)[0]])
    cut, where = view(CUBE, aside=1.2)
    # Its lowest part is too close to the floor behind it to be told from it.
    assert salient_share(temporal.segment(cut).labels, where) < 0.2


@pytest.mark.parametrize("drift", [0.01, 0.03])
def test_drift_of_the_pose_by_centimetres_does_no_harm(drift: float) -> None:
    temporal = teacher()
    for step, frame in enumerate([view(CUBE, aside=0.4)[0], view(CUBE, aside=0.7)[0]]):
        pose = frame.T_world_camera.copy()
        pose[:2, 3] += drift * np.array([1, -1]) * (-1) ** step
        temporal.segment(replace(frame, T_world_camera=pose))
    cut, where = view(CUBE, aside=1.2)
    labels = temporal.segment(cut).labels
    assert salient_share(labels, where) > 0.85
    assert salient_share(labels, ~where & (cut.depth < 4)) < 0.005


def test_what_most_views_took_for_background_is_taken_back() -> None:
    temporal = teacher()
    frame, where = view(CUBE)
    pose = frame.T_world_camera
    voxels = temporal.votes.voxels_of(frame.depth, CAMERA, pose)
    for _ in range(4):
        temporal.votes.add(voxels, np.where(where, Label.NOT_SALIENT, Label.UNKNOWN))
    labels = temporal.segment(frame).labels
    assert salient_share(labels, where) < 0.05
    assert np.mean(labels[where] == Label.UNKNOWN) > 0.9


def test_what_a_view_does_not_know_is_not_salient_where_others_know_it() -> None:
    temporal = teacher()
    temporal.is_remembering = False
    cut, where = view(CUBE, aside=1.2)
    alone = temporal.teacher.segment(cut)
    assert np.mean(alone.labels[where] == Label.UNKNOWN) > 0.9
    voxels = temporal.votes.voxels_of(cut.depth, CAMERA, cut.T_world_camera)
    said = np.where(where, Label.NOT_SALIENT, Label.UNKNOWN)
    temporal.votes.add(voxels, said)
    assert np.mean(temporal.segment(cut).labels[where] == Label.UNKNOWN) > 0.9  # one is not enough
    temporal.votes.add(voxels, said)
    assert np.mean(temporal.segment(cut).labels[where] == Label.NOT_SALIENT) > 0.9
    temporal.is_remembering = True  # more is to come
    assert np.mean(temporal.segment(cut).labels[where] == Label.UNKNOWN) > 0.9


def test_the_foot_of_an_unknown_thing_does_not_become_table() -> None:
    temporal = teacher()
    temporal.is_remembering = False
    cut, where = view(CUBE, aside=1.2)
    voxels = temporal.votes.voxels_of(cut.depth, CAMERA, cut.T_world_camera)
    foot = where & (np.arange(len(where))[:, None] > np.flatnonzero(where.any(axis=1))[-1] - 15)
    for _ in range(5):
        temporal.votes.add(voxels, np.where(foot, Label.NOT_SALIENT, Label.UNKNOWN))
    assert np.mean(temporal.segment(cut).labels[where] == Label.NOT_SALIENT) < 0.05


def test_a_rejected_cluster_does_not_make_what_others_do_not_know_not_salient() -> None:
    temporal = teacher()
    temporal.is_remembering = False
    cut, where = view(CUBE, aside=1.2)
    voxels = temporal.votes.voxels_of(cut.depth, CAMERA, cut.T_world_camera)
    for _ in range(5):
        temporal.votes.add(voxels, np.where(where, REJECTED, Label.UNKNOWN))
    labels = temporal.segment(cut).labels
    assert np.mean(labels[where] == Label.UNKNOWN) > 0.9
    assert (temporal.votes.balance(voxels[where])[:, 0] < 0).all()


def test_once_all_is_seen_labels_are_told_and_nobody_votes() -> None:
    temporal = teacher()
    cut, where = view(CUBE, aside=1.2)
    temporal.remember([cut, view(CUBE, aside=0.4)[0], view(CUBE, aside=0.7)[0]])
    voxels = temporal.votes.voxels_of(cut.depth, CAMERA, cut.T_world_camera).ravel()
    before = temporal.votes.balance(voxels)
    temporal.is_remembering = False
    assert salient_share(temporal.segment(cut).labels, where) > 0.8
    assert np.array_equal(temporal.votes.balance(voxels), before)


def test_frame_without_pose_is_as_the_teacher_sees_it_and_leaves_no_trace() -> None:
    temporal = teacher()
    frame, _ = see(ROOM)
    assert np.array_equal(temporal.segment(frame).labels, temporal.teacher.segment(frame).labels)
    assert len(temporal.votes) == 0


def test_every_view_has_one_vote_a_voxel_for_what_most_of_its_pixels_say() -> None:
    votes = VoxelVotes()
    voxels = np.array([7, 7, 7, 8, 9, FREE])
    said = [Label.SALIENT, Label.SALIENT, Label.NOT_SALIENT, Label.NOT_SALIENT, Label.UNKNOWN, 255]
    votes.add(voxels, np.array(said, np.uint8))
    assert votes.balance(np.array([7, 8, 9, FREE])).tolist() == [
        [1, 1, 1],
        [-1, 0, 0],
        [0, 0, 0],
        [0, 0, 0],
    ]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 40), st.sampled_from([0, 125, 255])), max_size=200))
def test_votes_equal_a_dictionary_of_counts(cast: list[tuple[int, int]]) -> None:
    votes, expected = VoxelVotes(capacity=64), dict.fromkeys(range(41), 0)
    for voxel, label in cast:
        votes.add(np.array([voxel]), np.array([label], np.uint8))
        expected[voxel] += {0: -1, 125: 0, 255: 1}[label]
    assert votes.balance(np.arange(41))[:, 0].tolist() == list(expected.values())


def test_table_grows_and_keeps_its_votes() -> None:
    votes = VoxelVotes(capacity=64)
    many = np.arange(5000)
    votes.add(many, np.full(5000, Label.SALIENT, np.uint8))
    votes.add(many[::2], np.full(2500, Label.NOT_SALIENT, np.uint8))
    assert len(votes) >= 5000
    assert votes.balance(many)[:, 0].tolist() == [0, 1] * 2500


def test_memory_has_an_end_and_what_was_not_seen_for_longest_is_forgotten() -> None:
    votes = VoxelVotes(capacity=64, max_voxels=4096)
    for view in range(400):  # into ever new space, by a tenth of what is in view
        labels = np.full(500, Label.SALIENT if view % 3 else Label.NOT_SALIENT, np.uint8)
        votes.add(10 * np.arange(500) + 500 * view, labels)
        assert len(votes) <= 4096 + 500
    assert len(votes._voxels) == 2 * 8192
    seen = votes.balance(10 * np.arange(500) + 500 * 399)
    alone = VoxelVotes()
    for view in range(380, 400):
        labels = np.full(500, Label.SALIENT if view % 3 else Label.NOT_SALIENT, np.uint8)
        alone.add(10 * np.arange(500) + 500 * view, labels)
    assert np.array_equal(seen, alone.balance(10 * np.arange(500) + 500 * 399))
    assert not votes.balance(10 * np.arange(500)).any()


def test_a_view_of_more_than_is_kept_is_taken_in_whole() -> None:
    votes = VoxelVotes(capacity=64, max_voxels=100)
    for _ in range(3):
        votes.add(10 * np.arange(1000), np.full(1000, Label.NOT_SALIENT, np.uint8))
    assert (votes.balance(10 * np.arange(1000))[:, 0] < 0).all()


def test_voxels_are_the_cells_of_the_surface_in_the_world() -> None:
    depth = np.array([[1, 2, np.nan, 3]] * 3, np.float32)
    pose = look(30.0, distance=1.0, height=1.0, tilt_deg=20.0)
    found = VoxelVotes(side=0.1).voxels_of(depth, TINY, pose)
    u, v = np.meshgrid(np.arange(4), np.arange(3))
    rays = np.stack([(u - 1.5) / 2, (v - 1.0) / 2, np.ones_like(u)], axis=-1)
    cells = np.floor(((rays * depth[..., None]) @ pose[:3, :3].T + pose[:3, 3]) / 0.1)
    is_seen = np.isfinite(depth)
    assert (found[~is_seen] == FREE).all()
    key = [hash(tuple(cell)) for cell in cells[is_seen]]
    same = np.equal.outer(key, key)
    assert np.array_equal(same, np.equal.outer(found[is_seen], found[is_seen]))


def test_memory_that_is_told_what_another_noted_is_the_same() -> None:
    """Things come, go, and are seen beyond the image's edge; the table of voxels grows."""
    seeing, told = teacher(), teacher()
    assert seeing.noted is None
    seeing.segment(view(CUBE)[0])
    assert seeing.noted is None  # nobody asked for it
    told.segment(view(CUBE)[0])
    seeing.votes, told.votes = VoxelVotes(capacity=64), VoxelVotes(capacity=64)
    seeing.is_noting = True
    scenes = [view(CUBE, aside=0.4), view(CUBE, aside=0.7), view(aside=0.1), view(CUBE, aside=1.2)]
    n_gone = 0
    for frame, _ in scenes:
        seeing.segment(frame)
        assert isinstance(seeing.noted, Remembered)
        n_gone += len(seeing.noted.gone)
        told.remember_again(seeing.noted)
    assert n_gone > 0
    assert len(seeing.votes) > 64
    for name, value in vars(seeing.votes).items():
        other = getattr(told.votes, name)
        if name == "_salient":
            value, other = value[: seeing.votes._n_salient], other[: told.votes._n_salient]
        assert np.array_equal(value, other), name
    seeing.segment(Frame("bad", frame.rgb, None, None, frame.T_world_camera, problem="no depth"))
    assert seeing.noted is None


def test_votes_cast_again_leave_the_same_table() -> None:
    """Voxels in any order, met again and again, near and far, also on the other side of 0."""
    rng = np.random.default_rng(7)
    seeing, told = (VoxelVotes(capacity=64, max_voxels=3000) for _ in range(2))
    codes = np.array([Label.SALIENT, Label.NOT_SALIENT, REJECTED, Label.UNKNOWN], np.uint8)
    for width in (3, 40, 300, 70_000, 3, 40, 300):
        cells = ORIGIN + rng.integers(-width, width, (900, 3))
        voxels = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
        voxels = np.repeat(voxels, rng.integers(1, 4, 900))
        voxels[rng.random(len(voxels)) < 0.1] = FREE
        note = seeing.add_and_note(voxels, rng.choice(codes, len(voxels)))
        told.add_again(note)
        assert len(note.far) == len(note.codes) if width > 300 else len(note.far) > 0
        for name, value in vars(seeing).items():
            other = getattr(told, name)
            if name == "_salient":
                value, other = value[: seeing._n_salient], other[: told._n_salient]
            assert np.array_equal(value, other), name
    nothing = seeing.add_and_note(np.full(9, FREE), np.full(9, REJECTED))
    assert len(nothing.codes) == len(nothing.far) == 0
    told.add_again(nothing)
    assert (seeing._n_views, len(seeing)) == (told._n_views, len(told))


def test_way_up_of_frames_without_pose_is_told_too() -> None:
    seeing, told = teacher(), teacher()
    seeing.is_noting = True
    frame, _ = see(ROOM)
    seeing.segment(frame)
    assert isinstance(seeing.noted, UpTracker)
    told.remember_again(seeing.noted)
    assert frame.depth is not None
    expected = seeing._tracker.up_in(frame.depth)
    assert expected is not None
    assert np.array_equal(told._tracker.up_in(frame.depth), expected)
