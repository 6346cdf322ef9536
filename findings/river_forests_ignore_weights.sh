#!/usr/bin/env bash
# river 0.26.1, seen 2026-11-30 (Python 3.11, Linux x86-64).
# Expected: ARFClassifier and SRPClassifier heed the weight of a sample, learn_one(x, y, w=…),
#   as the Hoeffding trees in them, bagging and logistic regression do; or refuse it, as
#   GaussianNB does.
# Happens: both take any keyword and use none. All weights 0, or 100 for one of the classes,
#   give the same forest, to the last bit, as no weights; a misspelt keyword too.
# Meets: who balances rare classes of a stream by weights.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check river==0.26.1 numpy==2.3.4
"$work/env/bin/python" - <<'PY'
from importlib.metadata import version

import numpy as np
from river.ensemble import BaggingClassifier, SRPClassifier
from river.forest import ARFClassifier
from river.linear_model import LogisticRegression
from river.tree import HoeffdingTreeClassifier

print("river", version("river"))
rng = np.random.default_rng(0)
X = rng.random((400, 5))
samples = [dict(enumerate(row)) for row in X.tolist()]
labels = (X[:, 0] > 0.5).tolist()


def learned(make, **of_label):
    model = make()
    for x, y in zip(samples, labels):
        model.learn_one(x, y, **{name: weight(y) for name, weight in of_label.items()})
    return [model.predict_proba_one(x).get(True, 0.0) for x in samples[:100]]


def rare(y):
    return 100.0 if y else 1.0


heeding = {
    "HoeffdingTree": HoeffdingTreeClassifier,
    "Bagging": lambda: BaggingClassifier(HoeffdingTreeClassifier(), n_models=3, seed=0),
    "LogisticRegression": LogisticRegression,
}
for name, make in heeding.items():
    is_same = learned(make, w=rare) == learned(make)
    print(f"{name}: weights of 100 for a class change {'nothing' if is_same else 'its answers'}")
    assert not is_same
for kind in (ARFClassifier, SRPClassifier):
    def make():
        return kind(n_models=3, seed=0)

    plain = learned(make)
    same = {
        "100 for a class": learned(make, w=rare) == plain,
        "0 for all": learned(make, w=lambda y: 0.0) == plain,
        "a misspelt wieght": learned(make, wieght=rare) == plain,
    }
    print(f"{kind.__name__}: the same as without weights:", same)
    assert all(same.values())
PY
