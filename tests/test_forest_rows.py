"""Forests whose trees draw rows: what they draw, and which regrow."""

from __future__ import annotations

import threading
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.learner.archive import read_archive
from curiosight.learner.forest import Forest
from curiosight.learner.forest_draws import ALL_KEYS
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.model_file import KIND
from pictures import picture
from reference_trees import (
    ReferenceBuffer,
    ReferenceRandom,
    ReferenceTree,
    reference_is_drawn,
    reference_rows,
    unpack,
)
from test_forest import make_samples

GOLDEN = Path(__file__).parent / "golden"


def make_forest(**changed):
    usual = {"n_features": 6, "n_trees": 6, "n_regrown": 2, "share": 0.5, "max_rows": 100}
    return Forest(**usual | {"vote": "soft", "n_split_features": 3} | changed)


def repeated(rng, n_rows, n_each=3):
    """Return samples of which some share a row, as the pixels of a superpixel do."""
    rows, is_salient = make_samples(rng, n_rows)
    return np.repeat(rows, n_each, axis=0), np.repeat(is_salient, n_each)


@pytest.mark.parametrize("max_rows", [40, 10_000])
@pytest.mark.parametrize("n_levels", [256, 32])
def test_tree_equals_reference_on_the_rows_it_draws(max_rows, n_levels):
    forest = make_forest(max_rows=max_rows, n_levels=n_levels)
    forest.fit(*repeated(np.random.default_rng(0), 300))
    forest.regrow(range(6))
    rows, counts = reference_rows(forest.rows, forest.is_salient)
    for tree in forest._trees:
        assert tree.bound == round(ALL_KEYS * min(0.5, max_rows / len(rows)))
        is_drawn = reference_is_drawn(rows, tree.seed, tree.bound)
        assert 0 < is_drawn.sum() < len(rows)
        merged = 256 // n_levels
        reference = ReferenceTree(
            rows[is_drawn] // merged,
            counts[is_drawn],
            10,
            11,
            3,
            ReferenceRandom(tree.seed),
            merged,
        )
        assert unpack(tree.nodes, tree.values) == reference.root


def test_trees_draw_their_share_up_to_a_number_of_rows():
    forest = make_forest(n_trees=40, max_rows=200)
    for n_rows, expected in ((300, 150), (2000, 200)):
        forest.fit(*repeated(np.random.default_rng(1), n_rows))
        forest.regrow(range(40))
        rows, _ = reference_rows(forest.rows, forest.is_salient)
        n_drawn = [reference_is_drawn(rows, t.seed, t.bound).sum() for t in forest._trees]
        assert abs(np.mean(n_drawn) - expected) < 6
        assert len(set(n_drawn)) > 10


def test_a_tree_that_would_draw_nothing_draws_all():
    forest = make_forest(max_rows=1, n_trees=30)
    forest.fit(*repeated(np.random.default_rng(2), 60))
    forest.regrow(range(30))
    bounds = {tree.bound for tree in forest._trees}
    assert bounds == {ALL_KEYS, round(ALL_KEYS / 60)}


def test_the_oldest_trees_regrow_and_more_while_they_are_small():
    rng, forest, n_regrown = np.random.default_rng(3), make_forest(), []
    forest.update(*repeated(rng, 20))
    for _ in range(12):
        births = np.array([tree.birth for tree in forest._trees])
        regrown = forest.update(*repeated(rng, 20))
        others = np.setdiff1d(np.arange(6), regrown)
        assert len(others) == 0 or births[list(regrown)].max() <= births[others].min()
        n_regrown.append(len(regrown))
    # Of 40, 60, 80, ... rows a tree draws half, and 200 rows may be drawn together.
    assert n_regrown == [6, 6, 5, 4, 3, 2, 2, 2, 2, 2, 2, 2]


def test_adding_and_regrowing_is_updating():
    states = []
    for is_apart in (False, True):
        rng, forest = np.random.default_rng(4), make_forest(max_samples=500, seed=3)
        for group in range(6):
            batch = (*repeated(rng, 50), group)
            if is_apart:
                before = forest._trees
                forest.add(*batch)
                assert forest._trees is before
                forest.regrow()
            else:
                forest.update(*batch)
        states.append(forest.state_arrays())
    for name, array in states[0].items():
        np.testing.assert_array_equal(array, states[1][name])


def test_chosen_trees_regrow():
    forest = make_forest()
    assert forest.regrow([1]) == ()
    forest.add(*repeated(np.random.default_rng(5), 50))
    assert not forest.is_trained
    assert forest.regrow([1]) == tuple(range(6))
    before = forest._trees
    assert forest.regrow([4, 1, 4]) == (1, 4)
    changed = [index for index in range(6) if forest._trees[index] is not before[index]]
    assert changed == [1, 4]
    with pytest.raises(ValueError, match="trees: expected 0 to 5, got 6"):
        forest.regrow([6])


def test_what_the_trees_drew_is_kept_with_them():
    forest = make_forest(n_levels=128)
    forest.update(*repeated(np.random.default_rng(10), 100))
    restored = Forest(**forest.settings())
    assert restored.settings() == forest.settings()
    arrays = forest.state_arrays()
    restored.restore(arrays)
    for name in ("seed", "bound", "birth"):
        kept = [getattr(tree, name) for tree in restored._trees]
        assert kept == [getattr(tree, name) for tree in forest._trees]
    for name in ("tree_seeds", "tree_bounds", "tree_births"):
        with pytest.raises(ValueError, match=rf"{name}: expected \(6,\) \w+, got \(5,\)"):
            restored.restore(arrays | {name: arrays[name][:5]})
    with pytest.raises(ValueError, match=f"tree_bounds: expected 0 to {2**32}"):
        restored.restore(arrays | {"tree_bounds": arrays["tree_bounds"] + np.uint64(2**32)})


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"max_rows": 0}, "max_rows: expected 1 or more, got 0"),
        ({"n_levels": 100}, r"n_levels: expected one of \(256, 128, .*, 2\), got 100"),
    ],
)
def test_bad_settings_are_named(changed, message):
    with pytest.raises(ValueError, match=message):
        make_forest(**changed)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(0, 40), min_size=1, max_size=9), st.integers(1, 90), st.integers(1, 4))
def test_buffer_equals_a_plain_one(sizes, max_samples, n_levels):
    forest = Forest(n_features=3, max_samples=max_samples, seed=5)
    plain, rng = ReferenceBuffer(3, max_samples), np.random.default_rng(5)
    drawn = np.random.default_rng(0)
    for group, size in enumerate(sizes):
        rows = drawn.integers(0, n_levels, (size, 3)).astype(np.uint8)
        is_salient = drawn.random(size) < 0.5
        forest.add(rows, is_salient, group)
        plain.add(rows, is_salient, group, rng)
    np.testing.assert_array_equal(forest.rows, plain.rows)
    np.testing.assert_array_equal(forest.is_salient, plain.is_salient)
    np.testing.assert_array_equal(forest.groups, plain.groups)


def test_who_reads_while_another_learns_sees_one_moment():
    """Every row says its group: one that was overwritten while it was read would not."""
    forest = make_forest(max_samples=2000, n_trees=2, max_depth=1)
    is_over = threading.Event()

    def learn():
        for group in range(400):
            rows = np.full((150, 6), group % 256, np.uint8)
            rows[:, 5] = np.arange(150)
            forest.update(rows, np.arange(150) < 75, group)
        is_over.set()

    learning = threading.Thread(target=learn)
    learning.start()
    n_read = 0
    while not is_over.is_set():
        arrays = forest.state_arrays()
        assert (arrays["rows"][:, :5] == arrays["groups"][:, None] % 256).all()
        assert (arrays["is_salient"] == (arrays["rows"][:, 5] < 75)).all()
        n_read += 1
    learning.join()
    assert n_read > 3


def test_an_update_copies_no_rows():
    rng = np.random.default_rng(11)
    forest = Forest(n_features=50, max_samples=20_000, n_trees=2, n_regrown=1, max_rows=200)
    forest.fit(*make_samples(rng, 20_000, n_features=50))
    batches = [make_samples(rng, 300, n_features=50) for _ in range(3)]
    forest.update(*batches[0])
    forest.update(*batches[1])
    tracemalloc.start()
    forest.update(*batches[2])
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 0.6 * 20_000 * 50


def test_a_model_of_version_0_1_is_read_and_goes_on_learning():
    """`golden/model-0.1.npz` was written by version 0.1, and its answers were noted."""
    header, arrays = read_archive(GOLDEN / "model-0.1.npz", KIND)
    assert "max_rows" not in header["forest"]
    forest = Forest(**header["forest"])
    forest.restore(arrays)
    rows = np.random.default_rng(0).integers(0, 256, (6, 54)).astype(np.uint8)
    np.testing.assert_allclose(forest.predict(rows), [0.6, 0.4, 0.2, 0.4, 0.4, 0.6], rtol=1e-6)
    assert set(forest.state_arrays()) == set(arrays)
    for name, array in forest.state_arrays().items():
        np.testing.assert_array_equal(array, arrays[name])
    assert len(forest.update(rows, np.arange(6) < 3)) == 2
    learner = SaliencyLearner.load(GOLDEN / "model-0.1.npz")
    saliency = learner.saliency(picture(8).rgb)
    assert saliency.shape == (240, 320)
    assert saliency.max() > 0.9
