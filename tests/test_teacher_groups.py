"""Groups of points against plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.teacher.things.groups import Groups

SEED = 4
SHAPE = (30, 40)


def some_groups(
    seed: int = SEED, *, n_points: int = 500, n_groups: int = 6
) -> tuple[Groups, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return groups with the flat indices and the numbers that they were made of."""
    rng = np.random.default_rng(seed)
    where = np.sort(rng.choice(SHAPE[0] * SHAPE[1], n_points, replace=False))
    # Each number at least once.
    number = np.concatenate([np.arange(n_groups), rng.integers(0, n_groups, n_points - n_groups)])
    return Groups.of(where, number), where, number


def test_groups_hold_the_points_of_each_number_in_their_order() -> None:
    groups, where, number = some_groups()
    assert len(groups) == 6
    for index, members in enumerate(groups):
        np.testing.assert_array_equal(members, where[number == index])


def test_groups_with_few_points_are_left_out() -> None:
    where, number = np.arange(9), np.array([0, 1, 1, 2, 2, 2, 0, 2, 3])
    groups = Groups.of(where, number, min_points=2)
    assert [members.tolist() for members in groups] == [[0, 6], [1, 2], [3, 4, 5, 7]]
    assert groups.sizes.tolist() == [2, 2, 4]
    assert len(Groups.of(where, number, min_points=5)) == 0


def test_joined_groups_hold_all_their_points() -> None:
    groups, *_ = some_groups()
    parts = list(groups)
    joined = list(groups.joined(np.array([1, 0, 1, 2, 0, 1])))
    expected = [parts[1:5:3], [parts[0], parts[2], parts[5]], parts[3:4]]
    for members, together in zip(joined, expected, strict=True):
        np.testing.assert_array_equal(members, np.concatenate(together))


def test_boxes_and_counts_are_those_of_the_members() -> None:
    groups, *_ = some_groups()
    mask = np.random.default_rng(SEED).random(SHAPE) < 0.3
    boxes, counts = groups.boxes(mask)
    for members, box, count in zip(groups, boxes, counts, strict=True):
        v, u = np.unravel_index(members, SHAPE)
        assert box.tolist() == [u.min(), v.min(), u.max() + 1, v.max() + 1]
        assert count == mask[v, u].sum()


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n_points=st.integers(6, 1100),
    share=st.sampled_from([0.01, 0.02, 0.1, 0.5]),
    n_values=st.sampled_from([1, 3, 10**6]),
)
def test_ends_leave_a_share_of_each_group_outside(
    seed: int, n_points: int, share: float, n_values: int
) -> None:
    groups, *_ = some_groups(seed, n_points=n_points)
    values = np.random.default_rng(seed).integers(0, n_values, (n_points, 2)).astype(np.float32)
    found = groups.ends(values, [(0, share), (1, share)])
    for part, ends in zip(np.split(values, groups.start[1:-1]), found, strict=True):
        ordered = np.sort(part, axis=0)
        n_beyond = min(int(share * len(part)), (len(part) - 1) // 2)
        np.testing.assert_array_equal(ends, ordered[[n_beyond, -1 - n_beyond]].T)


def test_ends_of_half_are_at_the_median() -> None:
    groups, *_ = some_groups()
    values = np.random.default_rng(SEED).random((500, 1)).astype(np.float32)
    expected = [np.median(part) for part in np.split(values, groups.start[1:-1])]
    np.testing.assert_allclose(groups.ends(values, [(0, 0.5)]).mean(axis=(1, 2)), expected)


def hidden_share_by_loop(
    depth: npt.NDArray[np.float32], members: npt.NDArray[np.int64], step: float
) -> float:
    """Apply the definition of `Groups.hidden_shares` column by column."""
    v, u = np.unravel_index(members, depth.shape)
    hidden = []
    for column in np.unique(u):
        foot = v[u == column].max()
        below = depth[np.minimum([foot + 3, foot + 6], len(depth) - 1), column]
        hidden.append(np.any(np.isnan(below) | (below < depth[foot, column] - np.float32(step))))
    return float(np.mean(hidden))


@pytest.mark.parametrize("step", [0.05, 0.4])
def test_columns_are_hidden_below_whose_foot_comes_something_nearer_or_nothing(
    step: float,
) -> None:
    depth = np.random.default_rng(SEED).uniform(1, 2, SHAPE).astype(np.float32)
    groups, where, _ = some_groups(n_points=120)
    holes = np.setdiff1d(np.arange(depth.size), where)[::7]
    depth.ravel()[holes] = np.nan
    expected = [hidden_share_by_loop(depth, members, step) for members in groups]
    assert 0 < min(expected) < max(expected) < 1 or step == 0.05
    np.testing.assert_allclose(groups.hidden_shares(depth, step=step), expected)
