"""The forest's draws, trees and buffer in plain Python and NumPy, slow and simple."""

from __future__ import annotations

import numpy as np

MASK = 2**64 - 1


class ReferenceRandom:
    """Draw integers with splitmix64, in Python's own integers."""

    def __init__(self, seed):
        self.state = seed

    def below(self, bound):
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        mixed = self.state
        mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & MASK
        return ((mixed ^ (mixed >> 31)) >> 32) * bound >> 32


def reference_points(rows, is_salient, n_drawn, random):
    """Return the drawn rows, equal neighbours merged, and their (P, 2) class counts."""
    drawn = []
    for sample in range(len(rows)):
        if random.below(len(rows) - sample) < n_drawn - len(drawn):
            drawn.append(sample)
    points, counts = [], []
    for sample in drawn:
        if not points or not np.array_equal(points[-1], rows[sample]):
            points.append(rows[sample])
            counts.append([0, 0])
        counts[-1][int(is_salient[sample])] += 1
    return np.array(points), np.array(counts)


class ReferenceTree:
    """Grow a tree in plain NumPy; as a nested (share, feature, threshold, left, right).

    n_merged: values that each level of the points stands for.
    """

    def __init__(self, points, counts, max_depth, min_split, n_tried, random, n_merged=1):
        self.max_depth, self.min_split, self.n_tried = max_depth, min_split, n_tried
        self.random, self.n_merged = random, n_merged
        self.features = np.arange(points.shape[1])
        self.weights = np.maximum(counts.sum(axis=0)[::-1], 1)
        self.root = self.grow(points, counts, 0)

    def grow(self, points, counts, depth):
        total = counts.sum(axis=0)
        share = np.float32(total[1] * self.weights[1] / (total @ self.weights))
        score = -1.0
        if depth < self.max_depth and total.min() > 0 and total.sum() >= self.min_split:
            score, feature, threshold = self.find_split(points, counts)
        if score < 0:
            return (share,)
        is_left = points[:, feature] <= threshold
        sides = {}
        is_left_larger = 2 * is_left.sum() > len(points)
        for side in [not is_left_larger, is_left_larger]:
            chosen = is_left == side
            sides[side] = self.grow(points[chosen], counts[chosen], depth + 1)
        asked = (int(threshold) + 1) * self.n_merged - 1
        return share, int(feature), asked, sides[True], sides[False]

    def find_split(self, points, counts):
        best = (-1.0, 0, 0)
        for turn in range(len(self.features)):
            if turn >= self.n_tried and best[0] >= 0:
                break
            if self.n_tried < len(self.features):
                other = turn + self.random.below(len(self.features) - turn)
                self.features[[turn, other]] = self.features[[other, turn]]
            feature = self.features[turn]
            score, threshold = reference_cut(points[:, feature], counts, self.weights)
            if score > best[0]:
                best = (score, feature, threshold)
        return best


def reference_cut(values, counts, weights):
    """Return (score, threshold) of the first best cut of one feature; -1 if it is constant."""
    present = np.unique(values)
    if present.size == 1:
        return -1.0, 0
    total = counts.sum(axis=0)
    left = np.array([counts[values <= value].sum(axis=0) for value in present[:-1]])
    difference = (left[:, 1] * total[0] - left[:, 0] * total[1]).astype(float)
    sides = (left @ weights).astype(float) * ((total - left) @ weights).astype(float)
    scores = difference * difference / sides
    best = int(scores.argmax())
    return scores[best], (int(present[best]) + int(present[best + 1])) // 2


def unpack(nodes, values, node=0):
    """Return a grown tree in the form of `ReferenceTree`."""
    left, feature, threshold = nodes[node] >> 24, nodes[node] >> 8 & 0xFFFF, nodes[node] & 255
    if left == node:
        return (values[node],)
    children = unpack(nodes, values, left), unpack(nodes, values, left + 1)
    return (values[node], int(feature), int(threshold), *children)


def depth_of(tree):
    return 0 if len(tree) == 1 else 1 + max(depth_of(tree[3]), depth_of(tree[4]))


def reference_mix(number):
    """Return the number with its bits stirred, in Python's own integers."""
    number = ((number ^ (number >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    number = ((number ^ (number >> 27)) * 0x94D049BB133111EB) & MASK
    return number ^ (number >> 31)


def reference_key(row):
    """Return the key of a row of features."""
    key = 0
    for value in row.tolist():
        key = ((key ^ value) * 0x100000001B3) & MASK
    return reference_mix(key)


def reference_is_drawn(rows, seed, bound):
    """Tell of each row whether a tree of this seed draws it."""
    keys = [reference_key(row) for row in rows]
    return np.array([reference_mix(key ^ seed) >> 32 < bound for key in keys], bool)


def reference_rows(rows, is_salient):
    """Return rows, equal neighbours merged, and their (R, 2) class counts."""
    return reference_points(rows, is_salient, len(rows), ReferenceRandom(0))


class ReferenceBuffer:
    """Keep samples as whole arrays, which every update copies."""

    def __init__(self, n_features, max_samples):
        self.rows = np.empty((0, n_features), np.uint8)
        self.is_salient = np.empty(0, bool)
        self.groups = np.empty(0, np.int32)
        self.max_samples = max_samples

    def add(self, rows, is_salient, group, rng):
        order = sorted(range(len(rows)), key=lambda index: rows[index].tobytes())
        self.rows = np.concatenate([self.rows, rows[order]])
        self.is_salient = np.concatenate([self.is_salient, is_salient[order]])
        self.groups = np.concatenate([self.groups, np.full(len(rows), group, np.int32)])
        n_evicted = len(self.rows) - self.max_samples
        if n_evicted > 0:
            is_kept = self._kept(rng.random(len(self.rows)))
            self.rows, self.is_salient = self.rows[is_kept], self.is_salient[is_kept]
            self.groups = self.groups[is_kept]

    def _kept(self, chances):
        """Lower what the largest groups keep until all fits; draw who leaves one by one."""
        sizes = {group: int(np.sum(self.groups == group)) for group in set(self.groups.tolist())}
        kept = dict(sizes)
        while sum(kept.values()) > self.max_samples:
            # Of the largest the one that has fewest samples to begin with gives up, or the first.
            most = max(kept.values())
            loser = min((sizes[g], g) for g in kept if kept[g] == most)[1]
            kept[loser] -= 1
        left, leaving = dict(sizes), {group: sizes[group] - kept[group] for group in sizes}
        is_kept = np.ones(len(self.groups), bool)
        for index, group in enumerate(self.groups.tolist()):
            if chances[index] * left[group] < leaving[group]:
                is_kept[index] = False
                leaving[group] -= 1
            left[group] -= 1
        return is_kept
