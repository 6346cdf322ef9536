"""What verdicts are told from, against plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy import ndimage

from curiosight.teacher.things.objects import _measure_extents
from curiosight.teacher.things.things import APART, _take_over
from curiosight.teacher.things.verdicts import _count_in, _mean_cosine, _turns_corner

SHAPE, SEED = (30, 40), 8
Members = npt.NDArray[np.int64]


def blob(rng: np.random.Generator) -> Members:
    """Return the flat indices of most of a box on the grid."""
    is_in = np.zeros(SHAPE, np.bool_)
    is_in[8:22, 12:25] = rng.random((14, 13)) < 0.8
    return np.flatnonzero(is_in)


def turns_by_rows(
    depth: npt.NDArray[np.float32], members: Members, inliers: npt.NDArray[np.bool_], reach: int
) -> bool:
    """Look beside the ends of every row."""
    v, u = np.unravel_index(members, SHAPE)
    rows = np.unique(v)
    for end, way in ((np.min, -reach), (np.max, reach)):
        edge = np.array([end(u[v == row]) for row in rows])
        there = np.clip(edge + way, 0, SHAPE[1] - 1)
        step = np.abs(depth[rows, there] - depth[rows, edge])
        if np.mean(inliers[rows, there] & (step < 0.10)) > 0.5:
            return True
    return False


@pytest.mark.parametrize(("first", "last", "turns"), [(0, 8, True), (27, 40, True), (9, 11, False)])
def test_things_turn_a_corner_where_a_wall_goes_on_beside_them(
    first: int, last: int, turns: bool
) -> None:
    rng = np.random.default_rng(SEED)
    depth, members = rng.uniform(1, 1.06, SHAPE).astype(np.float32), blob(rng)
    inliers = np.zeros(SHAPE, np.bool_)
    inliers[:, first:last] = rng.random((SHAPE[0], last - first)) < 0.95
    assert _turns_corner(depth, members, inliers, 6) == turns
    assert turns_by_rows(depth, members, inliers, 6) == turns
    assert not _turns_corner(depth + inliers, members, inliers, 6)


@pytest.mark.parametrize("seed", range(8))
def test_turning_equals_the_rows_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth = (1 + 0.2 * (rng.random(SHAPE) < 0.3)).astype(np.float32)
    members, inliers = blob(rng), rng.random(SHAPE) < 0.75
    assert _turns_corner(depth, members, inliers, 3) == turns_by_rows(depth, members, inliers, 3)


def test_members_are_counted_in_a_mask_and_their_middle_is_seen_from_above() -> None:
    rng = np.random.default_rng(SEED)
    mask, members = rng.random(SHAPE) < 0.4, blob(rng)
    assert _count_in(mask, members) == np.count_nonzero(mask.ravel()[members])
    xyz = rng.uniform((-1, -1, 1), (1, 1, 2), (mask.size, 3)).astype(np.float32)
    middle, down = xyz[members].mean(axis=0), np.array([0.0, 0.6, 0.8])
    expected = middle @ down / np.linalg.norm(middle)
    assert _mean_cosine(xyz, members, down) == pytest.approx(expected, rel=1e-5)


def test_extents_are_windows_and_counts_of_the_numbers() -> None:
    rng = np.random.default_rng(SEED)
    number = np.where(rng.random(SHAPE) < 0.2, rng.integers(1, 4, SHAPE), 0).astype(np.int32)
    number[:, 30:] = 0
    extents = np.zeros((4, 5), np.int64)
    _measure_extents(number, extents)
    for one, (rows, columns) in enumerate(ndimage.find_objects(number), start=1):
        box = [columns.start, rows.start, columns.stop, rows.stop]
        assert extents[one - 1].tolist() == [*box, np.count_nonzero(number == one)]
    assert not extents[3].any()


def test_take_over_some_supports_are_taken_and_moved_apart() -> None:
    rng = np.random.default_rng(SEED)
    carrier, xyz = rng.integers(-1, 3, 200).astype(np.int8), rng.random((200, 3), np.float32)
    where, places = _take_over(
        np.flatnonzero(carrier >= 0), carrier, np.array([True, False, True]), xyz
    )
    expected = np.flatnonzero((carrier == 0) | (carrier == 2))
    np.testing.assert_array_equal(where, expected)
    moved = xyz[expected] + np.outer(carrier[expected], [APART, 0.0, 0.0])
    np.testing.assert_allclose(places, moved)
