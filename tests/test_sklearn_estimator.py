"""The scikit-learn face of the forest keeps scikit-learn's contract."""

from __future__ import annotations

import builtins
import doctest
import importlib
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("sklearn")

from sklearn.datasets import make_classification
from sklearn.utils.estimator_checks import parametrize_with_checks

from curiosight.learner import sklearn_estimator
from curiosight.learner.sklearn_estimator import OnlineForestClassifier


@parametrize_with_checks([OnlineForestClassifier(n_trees=8)])
def test_scikit_learn_contract(estimator, check):
    check(estimator)


def test_learns_and_keeps_learning():
    X, y = make_classification(2000, n_informative=6, random_state=0)
    labels = np.array(["mug", "table"])[y]
    model = OnlineForestClassifier(random_state=0)
    for start in range(0, 1000, 200):
        batch = slice(start, start + 200)
        model.partial_fit(X[batch], labels[batch], classes=["mug", "table"])
    assert model.forest_.n_samples == 1000
    assert model.score(X[1000:], labels[1000:]) > 0.85
    assert model.predict_proba(X).shape == (2000, 2)


def test_binning_costs_nothing_that_matters():
    X, y = make_classification(3000, n_informative=6, random_state=1)
    for scale in (1e-6, 1, 1e6):
        model = OnlineForestClassifier(random_state=0).fit(scale * X[:2000], y[:2000])
        assert model.score(scale * X[2000:], y[2000:]) > 0.88


def test_first_batch_needs_the_classes():
    X, y = make_classification(50, random_state=0)
    with pytest.raises(ValueError, match="classes: expected both labels"):
        OnlineForestClassifier().partial_fit(X, y)
    model = OnlineForestClassifier().partial_fit(X, y, classes=[0, 1])
    with pytest.raises(ValueError, match=r"y: expected labels of \[0 1\], got \[2\]"):
        model.partial_fit(X, np.full(50, 2))


def test_example_in_the_docstring():
    results = doctest.testmod(sklearn_estimator)
    assert results.attempted > 0
    assert results.failed == 0


def test_one_class_so_far_answers_the_first():
    model = OnlineForestClassifier().partial_fit(np.zeros((9, 2)), ["b"] * 9, classes=["a", "b"])
    assert set(model.predict(np.zeros((3, 2)))) == {"a"}


def test_missing_scikit_learn_names_the_extra(monkeypatch):
    import_really = builtins.__import__

    def import_without_sklearn(name, *arguments, **keywords):
        if name.startswith("sklearn"):
            raise ImportError(name)
        return import_really(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", import_without_sklearn)
    with pytest.raises(ImportError, match=r"pip install 'curiosight\[sklearn\]'"):
        importlib.reload(sklearn_estimator)


def test_the_forest_itself_does_without_scikit_learn():
    code = "import sys, curiosight.learner.forest; sys.exit('sklearn' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def batches_of_one_class_and_place(rng, n=1200):
    """Two classes side by side; what comes first is one of them, and all in one corner."""
    X = rng.uniform(0, 1, (n, 2))
    y = (X[:, 0] + X[:, 1] > 1).astype(int)
    is_corner = (X < 0.2).all(axis=1)
    first = np.flatnonzero(is_corner)
    rest = np.array_split(np.flatnonzero(~is_corner), 8)
    return X, y, [first, *rest]


@pytest.mark.parametrize("scale", [1, 1e4, -1e-3])
def test_levels_follow_the_data(scale):
    X, y, batches = batches_of_one_class_and_place(np.random.default_rng(0), 6000)
    model = OnlineForestClassifier(random_state=0)
    for batch in batches:
        model.partial_fit(scale * X[batch], y[batch], classes=[0, 1])
    at_once = OnlineForestClassifier(random_state=0).fit(scale * X, y)
    unseen = np.random.default_rng(1).uniform(0, 1, (2000, 2))
    truth = unseen.sum(axis=1) > 1
    assert at_once.score(scale * unseen, truth) > 0.97
    assert model.score(scale * unseen, truth) > 0.97


def test_first_batch_of_equal_rows_costs_nothing():
    X, y = make_classification(2000, n_informative=6, random_state=3)
    model = OnlineForestClassifier(random_state=0)
    model.partial_fit(np.full((50, 20), 0.5), np.zeros(50, int), classes=[0, 1])
    for start in range(0, 1000, 100):
        model.partial_fit(X[start : start + 100], y[start : start + 100])
    assert model.score(X[1000:], y[1000:]) > 0.85


def test_levels_are_cut_anew_only_where_they_must_be():
    """Trees grow in turns otherwise: a stream that stays as it is moves no level for long."""
    rng = np.random.default_rng(0)
    model, n_cut, thresholds = OnlineForestClassifier(n_trees=4), 0, None
    for _ in range(60):
        X = rng.normal(size=(100, 3))
        X[:60, 0] = 0  # many equal values are no crowd
        model.partial_fit(X, X[:, 1] > 0, classes=[False, True])
        n_cut += thresholds is not model.thresholds_
        thresholds = model.thresholds_
    assert 1 <= n_cut < 12


def test_memory_is_bounded_and_samples_stay_with_their_labels():
    rng = np.random.default_rng(0)
    model = OnlineForestClassifier(n_trees=4, max_samples=300, random_state=0)
    for place in range(10):
        X = rng.normal(place, 1, (100, 2))
        model.partial_fit(X, X[:, 0] > place, classes=[False, True])
    assert model.forest_.n_samples == len(model._samples) == 300
    np.testing.assert_array_equal(model._bin(model._samples), model.forest_.rows)
