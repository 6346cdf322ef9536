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
