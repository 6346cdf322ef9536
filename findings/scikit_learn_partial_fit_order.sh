#!/usr/bin/env bash
# scikit-learn 1.9.1, seen 2026-11-30 (Python 3.11, Linux x86-64).
# Expected: partial_fit(X, y, classes) is one call for all classifiers that learn on-line,
#   as it is in SGDClassifier, GaussianNB, BernoulliNB, MultinomialNB and Perceptron.
# Happens: the third argument of MLPClassifier.partial_fit is sample_weight, and classes
#   the fourth. With classes in third place the first call is refused, since classes are
#   missing; a later one with as many samples as there are classes takes them for weights
#   without a word, so that the sample beside class 0 weighs nothing.
# Meets: who exchanges one on-line classifier for another.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check scikit-learn==1.9.1 numpy==2.3.4
"$work/env/bin/python" - <<'PY'
import inspect

import numpy as np
import sklearn
from sklearn.linear_model import Perceptron, SGDClassifier
from sklearn.naive_bayes import BernoulliNB, GaussianNB, MultinomialNB
from sklearn.neural_network import MLPClassifier

print("scikit-learn", sklearn.__version__)
for kind in (SGDClassifier, Perceptron, GaussianNB, BernoulliNB, MultinomialNB, MLPClassifier):
    names = list(inspect.signature(kind.partial_fit).parameters)[1:]
    print(f"{kind.__name__:>15}", names)
    expected = ["classes", "sample_weight"]
    assert names[2:] == (expected[::-1] if kind is MLPClassifier else expected)

rng = np.random.default_rng(0)
X, y = rng.normal(size=(20, 3)), np.arange(20) % 2
try:
    MLPClassifier().partial_fit(X, y, [0, 1])
except ValueError as error:
    print("the first call, classes in third place:", error)
else:
    raise AssertionError("no error")


def learned(*arguments, **named):
    model = MLPClassifier((4,), random_state=0).partial_fit(X, y, classes=[0, 1])
    return model.partial_fit(X[:2], y[:2], *arguments, **named).coefs_[0]


third = learned([0, 1])
print("a batch of 2, classes in third place, is as with weights 0 and 1:",
      np.array_equal(third, learned(sample_weight=[0, 1])),
      "and as with classes:", np.array_equal(third, learned(classes=[0, 1])))
assert np.array_equal(third, learned(sample_weight=[0, 1]))
assert not np.array_equal(third, learned(classes=[0, 1]))
PY
