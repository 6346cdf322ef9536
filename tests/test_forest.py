"""The forest against a plain reference, its rules, and its buffer."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.learner.forest import Forest
from curiosight.learner.forest_buffer import Samples
from curiosight.learner.forest_draws import take_points
from curiosight.learner.forest_growth import grow_tree
from curiosight.learner.forest_splits import find_cut, make_room
from curiosight.learner.forest_votes import add_votes
from reference_trees import ReferenceRandom, ReferenceTree, depth_of, reference_points, unpack


def make_samples(rng, n_samples, n_features=6, n_levels=256):
    """Return noisy rows whose first two features tell the label."""
    rows = rng.integers(0, n_levels, (n_samples, n_features)).astype(np.uint8)
    score = rows[:, 0].astype(float) - rows[:, 1] + rng.normal(0, 0.3 * n_levels, n_samples)
    return rows, score > 0.3 * n_levels


def make_forest(**settings):
    return Forest(**{"n_features": 6, "n_trees": 6, "n_regrown": 2, "max_depth": 6} | settings)


def draw_points(rows, is_salient, share, state, shift=0):
    """Return the (F, P) points that a tree grows on, and their packed class counts."""
    samples = Samples.of(rows, is_salient, np.zeros(len(rows), np.int32))
    columns, counts = samples.draw_samples(share, state)
    return take_points(samples.table, columns, shift), counts


def assert_same_tree(
    rows, is_salient, *, max_depth=10, min_split=11, n_tried=None, share=1.0, shift=0
):
    n_tried = rows.shape[1] if n_tried is None else n_tried
    state = np.array([7], np.uint64)
    points, counts = draw_points(rows, is_salient, share, state, shift)
    nodes, values, depth = grow_tree(points, counts, max_depth, min_split, n_tried, shift, state)
    random = ReferenceRandom(7)
    n_drawn = max(1, round(share * len(rows)))
    drawn, drawn_counts = reference_points(rows, is_salient, n_drawn, random)
    reference = ReferenceTree(
        drawn >> shift, drawn_counts, max_depth, min_split, n_tried, random, 2**shift
    )
    assert unpack(nodes, values) == reference.root
    assert depth == depth_of(reference.root)
    assert random.state == int(state[0])


@pytest.mark.parametrize("n_tried", [1, 2, 6])
@pytest.mark.parametrize("n_samples", [2, 30, 300, 2000])
@pytest.mark.parametrize("n_levels", [2, 256])
def test_tree_equals_reference_on_random_rows(n_samples, n_levels, n_tried):
    rows, is_salient = make_samples(np.random.default_rng(n_samples), n_samples, n_levels=n_levels)
    assert_same_tree(rows, is_salient, n_tried=n_tried, share=2 / 3)


@pytest.mark.parametrize("n_tried", [2, 5, 6])
@pytest.mark.parametrize("shift", [1, 2, 7])
def test_tree_of_fewer_levels_equals_reference(shift, n_tried):
    rows, is_salient = make_samples(np.random.default_rng(shift), 900)
    assert_same_tree(rows, is_salient, n_tried=n_tried, shift=shift)


@pytest.mark.parametrize("max_depth", [0, 1, 30])
@pytest.mark.parametrize("min_split", [2, 50])
def test_tree_equals_reference_at_any_depth(max_depth, min_split):
    rows, is_salient = make_samples(np.random.default_rng(1), 1200)
    assert_same_tree(rows, is_salient, max_depth=max_depth, min_split=min_split)


@pytest.mark.parametrize("n_tried", [2, 4])
@pytest.mark.parametrize(
    ("rows", "is_salient"),
    [
        (np.zeros((1, 4)), [True]),
        (np.zeros((20, 4)), [True] * 20),
        (np.zeros((20, 4)), [False] * 20),
        (np.zeros((20, 4)), [True, False] * 10),
        (np.repeat(np.eye(4) * 255, 100, axis=0), [True, False, True, True] * 100),
        (np.arange(2400).reshape(600, 4) % 256, [False] * 599 + [True]),
        (np.repeat([[0, 0, 9, 0], [0, 0, 200, 0]], 300, axis=0), [False] * 300 + [True] * 300),
    ],
    ids=["one", "salient", "not", "mixed", "duplicates", "rare", "constant"],
)
def test_tree_equals_reference_on_degenerate_rows(rows, is_salient, n_tried):
    rows, is_salient = np.asarray(rows, np.uint8), np.asarray(is_salient, bool)
    assert_same_tree(rows, is_salient, n_tried=n_tried)


def weighted_gini(counts, weights):
    """Return the impurity of (2,) counts times their weight, exactly."""
    parts = [Fraction(int(count * weight)) for count, weight in zip(counts, weights, strict=True)]
    return sum(parts) - sum(part * part for part in parts) / sum(parts)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=2, max_size=12))
def test_cut_lowers_the_weighted_gini_impurity_most(bin_counts):
    bin_counts = np.array(bin_counts)
    total = bin_counts.sum(axis=0)
    weights = np.maximum(total[::-1], 1)
    impurities = {}
    for value in range(len(bin_counts) - 1):
        left = bin_counts[: value + 1].sum(axis=0)
        if left.sum() > 0 and left.sum() < total.sum():
            sides = weighted_gini(left, weights) + weighted_gini(total - left, weights)
            impurities[value] = sides
    bins = bin_counts[:, 0] + (bin_counts[:, 1] << 32)
    packed = int(bins.sum())
    score, threshold = find_cut(bins, 0, len(bins) - 1, packed, weights, make_room())
    if not impurities:
        assert score == -1
    else:
        assert impurities[threshold] == min(impurities.values())


def test_votes_walk_the_tree_as_written():
    rows, is_salient = make_samples(np.random.default_rng(2), 1000)
    forest = make_forest(n_trees=3, vote="soft")
    forest.fit(rows, is_salient)
    queries = np.random.default_rng(3).integers(0, 256, (101, 6)).astype(np.uint8)
    expected = np.empty((101, 3), np.float32)
    for column, tree in enumerate(forest._trees):
        for index, row in enumerate(queries):
            place = unpack(tree.nodes, tree.values)
            while len(place) > 1:
                place = place[3] if row[place[1]] <= place[2] else place[4]
            expected[index, column] = place[0]
    np.testing.assert_array_equal(forest.votes(queries), expected)
    np.testing.assert_array_equal(forest.votes(queries, [2, 0]), expected[:, [2, 0]])
    np.testing.assert_allclose(forest.predict(queries), expected.mean(axis=1), rtol=1e-6)
    forest.vote = "hard"
    np.testing.assert_array_equal(forest.votes(queries), expected > 0.5)


def test_untrained_forest_predicts_zero_until_both_classes_are_seen():
    rows, _ = make_samples(np.random.default_rng(4), 50)
    forest = make_forest()
    assert forest.update(rows, np.ones(50, bool)) == ()
    assert not forest.is_trained
    assert forest.n_samples == 50
    assert not forest.predict(rows).any()
    assert forest.votes(rows).shape == (50, 6)
    assert forest.update(rows, np.zeros(50, bool)) == tuple(range(6))
    assert forest.is_trained


def test_share_of_one_class_gives_a_leaf_of_that_class():
    rows, _ = make_samples(np.random.default_rng(5), 40)
    forest = make_forest(n_trees=20, share=0.05)
    forest.fit(rows, np.arange(40) == 0)
    votes = forest.votes(rows)
    is_single_leaf = np.array([tree.nodes.size == 1 for tree in forest._trees])
    assert is_single_leaf.any()
    assert set(np.unique(votes[:, is_single_leaf])) <= {0, 1}


def test_pure_rows_are_answered_purely():
    rows = np.repeat(np.array([[10], [200]], np.uint8), 30, axis=0)
    forest = make_forest(n_features=1)
    forest.fit(rows, rows[:, 0] > 100)
    assert all(tree.nodes.size == 3 for tree in forest._trees)
    np.testing.assert_array_equal(
        forest.predict(np.array([[104], [105], [106]], np.uint8)), [0, 0, 1]
    )


def test_classes_weigh_the_same_however_rare():
    rng = np.random.default_rng(6)
    rows = rng.integers(0, 256, (4000, 6)).astype(np.uint8)
    is_salient = rng.random(4000) < 0.02 + 0.06 * (rows[:, 0] > 127)
    forest = make_forest(max_depth=1, vote="hard")
    forest.fit(rows, is_salient)
    assert forest.predict(np.full((1, 6), 255, np.uint8)) == 1
    assert forest.predict(np.zeros((1, 6), np.uint8)) == 0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 400), st.integers(1, 6))
def test_exchanged_labels_exchange_the_answer(seed, n_samples, n_split_features):
    rows, is_salient = make_samples(np.random.default_rng(seed), n_samples)
    predictions = []
    for labels in (is_salient, ~is_salient):
        forest = make_forest(vote="soft", n_split_features=n_split_features)
        forest.fit(rows, labels)
        predictions.append(forest.predict(rows))
    expected = 1 - predictions[0] if forest.is_trained else predictions[0]
    np.testing.assert_allclose(predictions[1], expected, atol=1e-6)


@settings(max_examples=25, deadline=None)
@given(st.permutations(range(6)))
def test_features_can_change_places(order):
    # A shallow tree on many samples: no two features score the same.
    rows, is_salient = make_samples(np.random.default_rng(7), 3000)
    answers = []
    for columns in (rows, np.ascontiguousarray(rows[:, order])):
        state = np.array([1], np.uint64)
        tree = grow_tree(*draw_points(columns, is_salient, 2 / 3, state), 4, 11, 6, 0, state)
        answers.append(np.zeros(3000, np.float32))
        add_votes(*tree, columns, False, answers[-1])
    np.testing.assert_array_equal(answers[0], answers[1])
    assert np.unique(answers[0]).size > 8


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(0, 60), min_size=1, max_size=8), st.integers(1, 80))
def test_buffer_never_exceeds_its_cap(sizes, max_samples):
    forest = make_forest(max_samples=max_samples)
    rng = np.random.default_rng(0)
    for group, size in enumerate(sizes):
        forest.update(*make_samples(rng, size), group)
        assert forest.n_samples <= max_samples
    assert forest.n_samples == min(sum(sizes), max_samples)
    assert len(forest.rows) == len(forest.is_salient) == len(forest.groups) == forest.n_samples


def test_eviction_is_uniform_over_old_and_new_samples_of_a_group():
    forest = make_forest(max_samples=1000, max_depth=0)
    rng = np.random.default_rng(8)
    for value in range(2):
        forest.update(np.full((1000, 6), value, np.uint8), rng.random(1000) < 0.5)
    assert abs(np.mean(forest.rows) - 0.5) < 0.06


def test_a_group_keeps_its_room_however_much_comes_after_it():
    forest = make_forest(max_samples=1000, max_depth=0)
    rng = np.random.default_rng(8)
    for group, size in ((0, 400), (1, 100), (2, 5000), (2, 5000)):
        forest.update(*make_samples(rng, size), group)
    np.testing.assert_array_equal(np.bincount(forest.groups), [400, 100, 500])
    forest.update(*make_samples(rng, 5000), 3)
    np.testing.assert_array_equal(np.bincount(forest.groups), [300, 100, 300, 300])


def test_samples_keep_their_label_and_group():
    rows, is_salient = make_samples(np.random.default_rng(9), 500)
    groups = np.arange(500, dtype=np.int32)
    forest = make_forest(max_samples=300)
    forest.update(rows, is_salient, groups)
    np.testing.assert_array_equal(forest.rows, rows[forest.groups])
    np.testing.assert_array_equal(forest.is_salient, is_salient[forest.groups])
    with pytest.raises(ValueError, match="read-only"):
        forest.groups[0] = 1


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32))
def test_exactly_the_returned_trees_change(n_regrown, seed):
    rng = np.random.default_rng(seed)
    forest = make_forest(n_regrown=n_regrown, seed=rng)
    forest.update(*make_samples(rng, 300))
    before = list(forest._trees)
    regrown = forest.update(*make_samples(rng, 300))
    changed = [index for index in range(6) if forest._trees[index] is not before[index]]
    assert sorted(regrown) == changed
    assert len(set(regrown)) == n_regrown


def test_update_without_rows_changes_nothing():
    rng = np.random.default_rng(10)
    forest = make_forest()
    forest.update(*make_samples(rng, 300))
    before = list(forest._trees)
    assert forest.update(np.empty((0, 6), np.uint8), np.empty(0, bool)) == ()
    assert all(old is new for old, new in zip(before, forest._trees, strict=True))


def test_threads_and_seed():
    rng = np.random.default_rng(11)
    batches = [make_samples(rng, 400) for _ in range(3)]
    states = []
    for n_threads, seed in ((1, 5), (3, 5), (1, 6)):
        forest = make_forest(n_threads=n_threads, seed=seed)
        for batch in batches:
            forest.update(*batch)
        states.append(forest.state_arrays())
    for name, array in states[0].items():
        np.testing.assert_array_equal(array, states[1][name])
    assert not np.array_equal(states[0]["node_values"], states[2]["node_values"])


def test_fit_forgets_and_samples_uniformly():
    rng = np.random.default_rng(12)
    forest = make_forest(max_samples=200)
    forest.update(*make_samples(rng, 150), group=1)
    assert forest.fit(*make_samples(rng, 1000), group=2) == tuple(range(6))
    assert set(forest.groups) == {2}
    assert forest.n_samples == 200
    assert forest.fit(np.zeros((5, 6), np.uint8), np.zeros(5, bool)) == ()
    assert not forest.is_trained


def test_fit_keeps_of_groups_what_they_are_of_all():
    """Unlike `update`, which gives a group of few the room of one of many."""
    rng = np.random.default_rng(13)
    groups = np.repeat(np.array([3, 7], np.int32), [9000, 1000])
    forest = make_forest(max_samples=2000)
    forest.fit(*make_samples(rng, 10_000), group=groups)
    assert np.count_nonzero(forest.groups == 7) == pytest.approx(200, abs=45)
    forest = make_forest(max_samples=2000)
    forest.update(*make_samples(rng, 10_000), group=groups)
    assert np.count_nonzero(forest.groups == 7) == 1000


def test_settings_and_state_arrays_restore_the_forest():
    rng = np.random.default_rng(13)
    forest = make_forest(vote="soft", n_split_features=2, min_split=5, max_samples=300)
    forest.update(*make_samples(rng, 400), group=3)
    restored = Forest(**forest.settings())
    assert restored.settings() == forest.settings()
    restored.restore(forest.state_arrays())
    queries = rng.integers(0, 256, (50, 6)).astype(np.uint8)
    np.testing.assert_array_equal(restored.predict(queries), forest.predict(queries))
    for name, array in forest.state_arrays().items():
        np.testing.assert_array_equal(restored.state_arrays()[name], array)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("rows", lambda array: array[:, :5]),
        ("groups", lambda array: array[:-1]),
        ("node_values", lambda array: array.astype(float)),
        ("tree_sizes", lambda array: array[:-1]),
        ("node_left_children", lambda array: array + 1),
        ("node_features", lambda array: array + 6),
        ("node_thresholds", lambda array: array * 0),
    ],
)
def test_restore_refuses_arrays_that_do_not_fit(name, change):
    forest = make_forest()
    forest.update(*make_samples(np.random.default_rng(14), 300))
    arrays = forest.state_arrays()
    with pytest.raises(ValueError, match=r"\w+: expected|expected the same length"):
        forest.restore(arrays | {name: change(arrays[name])})
    del arrays[name]
    with pytest.raises(ValueError, match=f"{name}: expected"):
        forest.restore(arrays)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"n_features": 0}, "n_features: expected 1 or more, got 0"),
        ({"n_regrown": 7}, "n_regrown: expected 1 to 6, got 7"),
        ({"n_split_features": 7}, "n_split_features: expected 1 to 6, got 7"),
        ({"share": 0}, r"share: expected a number in \(0, 1\], got 0"),
        ({"vote": "loud"}, "vote: expected 'hard' or 'soft', got 'loud'"),
        ({"min_split": 1}, "min_split: expected 2 or more, got 1"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(ValueError, match=message):
        make_forest(**settings)


def test_bad_samples_are_named():
    forest = make_forest()
    rows = np.zeros((5, 6), np.uint8)
    with pytest.raises(ValueError, match=r"rows: expected \(n, 6\) uint8, got \(5, 5\) uint8"):
        forest.predict(rows[:, :5])
    with pytest.raises(ValueError, match=r"rows: expected \(n, 6\) uint8, got \(5, 6\) float64"):
        forest.votes(rows.astype(float))
    with pytest.raises(ValueError, match=r"is_salient: expected \(5,\) bool, got \(5,\) uint8"):
        forest.update(rows, np.zeros(5, np.uint8))
    with pytest.raises(ValueError, match=r"group: expected a number or \(5,\), got \(4,\)"):
        forest.update(rows, np.zeros(5, bool), np.zeros(4, np.int32))


def test_a_bad_call_of_fit_forgets_nothing():
    forest = make_forest()
    forest.fit(*make_samples(np.random.default_rng(16), 100))
    with pytest.raises(ValueError, match="is_salient: expected"):
        forest.fit(np.zeros((5, 6), np.uint8), np.zeros(4, bool))
    assert forest.is_trained
    assert forest.n_samples == 100


def test_as_accurate_as_scikit_learn():
    ensemble = pytest.importorskip("sklearn.ensemble")
    metrics = pytest.importorskip("sklearn.metrics")
    rng = np.random.default_rng(15)
    rows, is_salient = make_samples(rng, 6000, n_features=12)
    forest = Forest(n_features=12, vote="soft")
    forest.fit(rows[:4000], is_salient[:4000])
    rival = ensemble.RandomForestClassifier(
        30, max_depth=10, min_samples_split=11, max_features=None, class_weight="balanced"
    )
    rival.set_params(random_state=0).fit(rows[:4000], is_salient[:4000])
    ours = metrics.roc_auc_score(is_salient[4000:], forest.predict(rows[4000:]))
    theirs = metrics.roc_auc_score(is_salient[4000:], rival.predict_proba(rows[4000:])[:, 1])
    assert ours > theirs - 0.01
