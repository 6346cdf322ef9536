"""What is learned from and what is kept for testing never touch."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from curiosight.evaluation import every_nth, make_folds


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def distance(training, test) -> int:
    """Return how many frames the nearest two are apart."""
    return int(np.abs(np.subtract.outer(training, test)).min())


def test_every_fifth_frame_is_tested_and_its_neighbours_left_out() -> None:
    training, test = every_nth(12, 5, gap=1)
    assert test.tolist() == [0, 5, 10]
    assert training.tolist() == [2, 3, 7, 8]


@given(n_frames=st.integers(2, 200), every=st.integers(1, 30), gap=st.integers(0, 8))
def test_a_gap_is_kept_and_no_other_frame_is_lost(n_frames: int, every: int, gap: int) -> None:
    assume(n_frames >= gap + 2 and every > 2 * gap + 1)
    training, test = every_nth(n_frames, every, gap=gap)
    assert test.tolist() == list(range(0, n_frames, every))
    assert distance(training, test) == gap + 1
    near = {t + offset for t in test.tolist() for offset in range(-gap, gap + 1)}
    assert set(training.tolist()) == set(range(n_frames)) - near


@pytest.mark.parametrize(
    ("n_frames", "every", "gap", "complaint"),
    [
        (100, 0, 3, "every, gap: expected 1 and 0 or more, got 0, 3"),
        (100, 10, -1, "every, gap: expected 1 and 0 or more, got 10, -1"),
        (100, 7, 3, "expected more than 7 for 100 frames with a gap of 3.*got 7"),
        (1, 10, 3, "n_frames: expected 5 or more to keep some out with a gap of 3, got 1"),
        (0, 10, 0, "n_frames: expected 2 or more"),
    ],
)
def test_splits_that_leave_nothing_are_refused(n_frames, every, gap, complaint) -> None:
    with pytest.raises(ValueError, match=complaint):
        every_nth(n_frames, every, gap=gap)


@pytest.mark.parametrize("kind", ["frames", "blocks"])
@given(data=st.data(), n_frames=st.integers(2, 120), seed=st.integers(0, 5))
def test_every_frame_is_tested_once_and_never_learned_from_then(kind, data, n_frames, seed) -> None:
    n_folds = data.draw(st.integers(2, n_frames))
    folds = make_folds(n_frames, n_folds, kind, rng(seed), gap=0)
    assert len(folds) == n_folds
    tested = np.concatenate([test for _, test in folds])
    assert sorted(tested.tolist()) == list(range(n_frames))
    sizes = [len(test) for _, test in folds]
    assert max(sizes) - min(sizes) <= 1
    for training, test in folds:
        assert sorted([*training.tolist(), *test.tolist()]) == list(range(n_frames))


def test_blocks_are_stretches_with_a_gap_beside_them() -> None:
    folds = make_folds(20, 4, "blocks", rng(), gap=2)
    assert [test.tolist() for _, test in folds] == [
        list(range(start, start + 5)) for start in (0, 5, 10, 15)
    ]
    assert folds[0][0].tolist() == list(range(7, 20))
    assert folds[1][0].tolist() == [0, 1, 2, *range(12, 20)]


def test_frames_are_dealt_out_at_random_without_a_gap() -> None:
    tests = [make_folds(20, 4, "frames", rng(seed), gap=2)[0][1].tolist() for seed in (1, 1, 2)]
    assert tests[0] == tests[1] != tests[2]
    assert tests[0] != list(range(5))
    assert len(make_folds(20, 4, "frames", rng(), gap=2)[0][0]) == 15


@pytest.mark.parametrize(
    ("n_frames", "n_folds", "kind", "gap", "complaint"),
    [
        (10, 1, "frames", 0, "folds: expected 2 to 10 for 10 frames, got 1"),
        (10, 11, "frames", 0, "folds: expected 2 to 10 for 10 frames, got 11"),
        (10, 5, "scenes", 0, "split: expected frames or blocks, got 'scenes'"),
        (10, 5, "blocks", -1, "gap: expected 0 or more, got -1"),
        (4, 2, "blocks", 3, "gap: expected less for 2 blocks of 4 frames"),
    ],
)
def test_impossible_folds_are_refused(n_frames, n_folds, kind, gap, complaint) -> None:
    with pytest.raises(ValueError, match=complaint):
        make_folds(n_frames, n_folds, kind, rng(), gap=gap)
