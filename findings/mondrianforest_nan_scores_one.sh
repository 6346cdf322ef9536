#!/usr/bin/env bash
# mondrianforest 0.0.2, seen 2026-11-30 (Python 3.11, Linux x86-64).
# Expected: two far-apart clouds of points give probabilities that sum to 1, and each
#   split of a tree has all points of its left child on its left.
# Happens: predict_proba is NaN for nearly every point that was learned, in the place
#   of the right class; `score` still says 1.0, since argmax takes NaN for the largest.
#   And a tenth or more of the splits cut through one of their own children: for a
#   new point below a block the cut is drawn from the point to the block's far side.
# Meets: who looks for a random forest that learns on-line, and trusts its `score`.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mondrianforest==0.0.2 numpy==2.3.4
"$work/env/bin/python" -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
from mondrianforest import MondrianForestClassifier

print("mondrianforest", version("mondrianforest"))
rng = np.random.default_rng(0)
np.random.seed(0)
clouds = [rng.normal(0, 0.1, (200, 2)), rng.normal(3, 0.1, (200, 2))]
order = rng.permutation(400)
points, labels = np.concatenate(clouds)[order], np.repeat([0, 1], 200)[order]
forest = MondrianForestClassifier(n_tree=10)
forest.partial_fit(points, labels)
probabilities = forest.predict_proba(points)
right = probabilities[np.arange(400), labels]
n_nan, n_wrong = np.isnan(right).sum(), np.isnan(probabilities[np.arange(400), 1 - labels]).sum()
print("of 400 learned points the right class is NaN for", n_nan, "and the wrong one for", n_wrong)
print("score", forest.score(points, labels))


def splits(node):
    if node.is_leaf:
        return []
    is_cut = node.left.max_list[node.delta] > node.xi or node.right.min_list[node.delta] < node.xi
    return [is_cut, *splits(node.left), *splits(node.right)]


cut = [np.mean(splits(tree.root)) for tree in forest.trees]
print("splits that cut through a child, by tree:", np.round(cut, 2).tolist())
assert n_nan > 300
assert forest.score(points, labels) == 1.0
assert min(cut) > 0.1
PY
