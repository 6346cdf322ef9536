"""Grow and ask one tree of the forest: the compiled loops behind `forest.py`.

A tree is two arrays. `nodes` (N,) int64 packs a node into eight bytes, `left child << 24 |
feature << 8 | threshold`: a row goes left where its feature is <= threshold, else to the node
after the left child. A leaf is its own left child with threshold 255, so a walk that has
arrived stays. `values` (N,) float32 is the salient share of a node's weight.

Two class counts are packed into one int64, `salient << 32 | not salient`: one addition counts
both, and a child's histogram is its parent's minus its sibling's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Rows = npt.NDArray[np.uint8]
Packed = npt.NDArray[np.int64]
Indices = npt.NDArray[np.int32]
Values = npt.NDArray[np.float32]
RandomState = npt.NDArray[np.uint64]

N_BINS = 256
ONE_SALIENT = 1 << 32
NOT_SALIENT_BITS = ONE_SALIENT - 1
FEATURE_BITS = (1 << 16) - 1
# A node of fewer points counts them feature by feature; the result is the same.
N_POINTS_FOR_HISTOGRAMS = 256
# Rows walked side by side: their memory accesses overlap.
N_LANES = 8

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function; a division by zero gives NaN as in NumPy (see `find_cut`)."""
    compiled: Callable[Parameters, Result] = njit(cache=True, nogil=True, error_model="numpy")(
        function
    )
    return compiled


@kernel
def draw_below(state: RandomState, bound: int) -> int:
    """Draw an integer in [0, bound) and advance the splitmix64 generator `state` (1,)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    mixed = state[0]
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed = mixed ^ (mixed >> np.uint64(31))
    return int(np.int64(((mixed >> np.uint64(32)) * np.uint64(bound)) >> np.uint64(32)))


@kernel
def draw_points(
    rows: Rows, is_salient: npt.NDArray[np.bool_], n_drawn: int, state: RandomState
) -> tuple[Rows, Packed]:
    """Draw `n_drawn` samples without replacement and merge equal neighbours.

    Return the (P, F) points and their (P,) packed class counts, P <= n_drawn. The pixels of a
    superpixel share a row, so P can be far smaller.
    """
    n_samples, n_features = rows.shape
    points = np.empty((n_drawn, n_features), np.uint8)
    counts = np.zeros(n_drawn, np.int64)
    n_points, n_missing = 0, n_drawn
    for sample in range(n_samples):
        if draw_below(state, n_samples - sample) >= n_missing:
            continue
        n_missing -= 1
        n_equal = 0
        if n_points > 0:
            while n_equal < n_features and points[n_points - 1, n_equal] == rows[sample, n_equal]:
                n_equal += 1
        if n_equal < n_features:
            for feature in range(n_features):
                points[n_points, feature] = rows[sample, feature]
            n_points += 1
        counts[n_points - 1] += ONE_SALIENT if is_salient[sample] else 1
    return points[:n_points], counts[:n_points]


@kernel
def find_cut(bins: Packed, first: int, last: int, total: int, weights: Packed) -> tuple[float, int]:
    """Return (score, threshold) of the best cut between the values `first` and `last`.

    The score is the decrease of the weighted Gini impurity up to a factor of the node: with
    two classes, (l1 n0 - l0 n1)^2 over the product of both sides' weights; -1 if there is no
    cut. All terms are integers below 2^53 until the division, so the classes can be exchanged.
    The first of equal cuts wins; the threshold lies midway between the values it separates.
    """
    n_not, n_salient = np.float64(total & NOT_SALIENT_BITS), np.float64(total >> 32)
    weight_not, weight_salient = np.float64(weights[0]), np.float64(weights[1])
    weight = n_not * weight_not + n_salient * weight_salient
    best_score, cut, left = -1.0, -1, 0
    for value in range(first, last):
        left += bins[value]
        left_not, left_salient = np.float64(left & NOT_SALIENT_BITS), np.float64(left >> 32)
        difference = left_salient * n_not - left_not * n_salient
        weight_left = left_not * weight_not + left_salient * weight_salient
        # 0 / 0 = NaN where a side is empty: never better. Branches would cost more.
        score = difference * difference / (weight_left * (weight - weight_left))
        if score > best_score:
            best_score, cut = score, value
    if cut < 0:
        return -1.0, 0
    after = cut + 1
    while bins[after] == 0:
        after += 1
    return best_score, (cut + after) >> 1


@kernel
def fill_histograms(histograms: Packed, points: Rows, counts: Packed, order: Indices) -> None:
    """Count the points `order` into `histograms` (F, 256)."""
    n_features = points.shape[1]
    for feature in range(n_features):
        for value in range(N_BINS):
            histograms[feature, value] = 0
    for point in order:
        count = counts[point]
        for feature in range(n_features):
            histograms[feature, points[point, feature]] += count


@kernel
def split_histograms(
    histograms: Packed, top: int, points: Rows, counts: Packed, order: Indices, n_left: int
) -> None:
    """Turn the histograms of a node, at `top`, into those of its children.

    The larger child's stay at `top`, the smaller one's follow: only its points are counted.
    """
    is_left_larger = 2 * n_left > order.size
    smaller = order[n_left:] if is_left_larger else order[:n_left]
    fill_histograms(histograms[top + 1], points, counts, smaller)
    for feature in range(histograms.shape[1]):
        for value in range(N_BINS):
            histograms[top, feature, value] -= histograms[top + 1, feature, value]


@kernel
def find_split_in_histograms(
    histograms: Packed, total: int, weights: Packed
) -> tuple[float, int, int]:
    """Return (score, feature, threshold) of the best cut of all features, -1 if none."""
    best_score, best_feature, best_threshold = -1.0, 0, 0
    for feature in range(histograms.shape[0]):
        score, threshold = find_cut(histograms[feature], 0, N_BINS - 1, total, weights)
        if score > best_score:
            best_score, best_feature, best_threshold = score, feature, threshold
    return best_score, best_feature, best_threshold


@kernel
def find_split_in_points(
    points: Rows,
    counts: Packed,
    order: Indices,
    total: int,
    weights: Packed,
    features: Indices,
    n_tried: int,
    state: RandomState,
) -> tuple[float, int, int]:
    """Return (score, feature, threshold) of the best cut of `n_tried` features, -1 if none.

    Where `n_tried` is not all of them they are drawn at random, and the search goes on until
    one is not constant. `features` is a permutation that the draws go on shuffling.
    """
    bins = np.zeros(N_BINS, np.int64)
    best_score, best_feature, best_threshold = -1.0, 0, 0
    for turn in range(features.size):
        if turn >= n_tried and best_score >= 0:
            break
        if n_tried < features.size:
            drawn = turn + draw_below(state, features.size - turn)
            features[turn], features[drawn] = features[drawn], features[turn]
        feature = features[turn]
        first, last = N_BINS - 1, 0
        for point in order:
            value = points[point, feature]
            bins[value] += counts[point]
            first, last = min(first, value), max(last, value)
        score, threshold = find_cut(bins, first, last, total, weights)
        for value in range(first, last + 1):
            bins[value] = 0
        if score > best_score:
            best_score, best_feature, best_threshold = score, feature, threshold
    return best_score, best_feature, best_threshold


@kernel
def partition(
    order: Indices, scratch: Indices, points: Rows, counts: Packed, feature: int, threshold: int
) -> tuple[int, int]:
    """Move the points that go left to the front of `order`; both sides stay in order.

    Return how many go left and their packed class counts.
    """
    n_left, n_right, total_left = 0, 0, 0
    for point in order:
        goes_left = int(points[point, feature] <= threshold)
        # Write to both sides and keep one: the branch would be wrong half of the time.
        order[n_left] = point
        scratch[n_right] = point
        n_left += goes_left
        n_right += 1 - goes_left
        total_left += counts[point] * goes_left
    for place in range(n_right):
        order[n_left + place] = scratch[place]
    return n_left, total_left


@kernel
def weigh_classes(counts: Packed) -> tuple[int, Packed]:
    """Return the packed count of all points and what a sample of each class weighs.

    Each class weighs the other's count, so that both weigh the same; 1 where the other is
    missing.
    """
    total = 0
    for count in counts:
        total += count
    weights = np.empty(2, np.int64)
    weights[0], weights[1] = max(total >> 32, 1), max(total & NOT_SALIENT_BITS, 1)
    return total, weights


@kernel
def count_up(n: int) -> Indices:
    """Return 0, 1, ... n - 1 (compiles ten times faster than NumPy's)."""
    numbers = np.empty(n, np.int32)
    for index in range(n):
        numbers[index] = index
    return numbers


@kernel
def push(
    stack: Packed, place: int, node: int, start: int, end: int, depth: int, total: int
) -> None:
    """Put a node that is still to grow on its place in the stack."""
    stack[place, 0] = node
    stack[place, 1] = start
    stack[place, 2] = end
    stack[place, 3] = depth
    stack[place, 4] = total


@kernel
def push_children(stack: Packed, top: int, n_nodes: int, n_left: int, total_left: int) -> None:
    """Replace the node at `top` by its larger child, with the smaller one above it."""
    _, start, end, depth, total = stack[top]
    middle = start + n_left
    left, right = (top, top + 1) if 2 * n_left > end - start else (top + 1, top)
    push(stack, left, n_nodes, start, middle, depth + 1, total_left)
    push(stack, right, n_nodes + 1, middle, end, depth + 1, total - total_left)


@kernel
def grow_tree(
    points: Rows, counts: Packed, max_depth: int, min_split: int, n_tried: int, state: RandomState
) -> tuple[Packed, Values, int]:
    """Grow a tree on (P, F) `points` with class counts `counts`; return nodes, values, depth.

    A node is a leaf at `max_depth`, below `min_split` samples, when it is pure, and when all
    its features are constant. The smaller child grows first: so the stack stays shorter than
    log2(P) + 2, and a node's place in the stack is its place in `histograms` too.
    """
    n_points, n_features = points.shape
    total, weights = weigh_classes(counts)
    nodes, values = np.empty(2 * n_points, np.int64), np.empty(2 * n_points, np.float32)
    order, scratch, features = count_up(n_points), count_up(n_points), count_up(n_features)
    n_places = int(np.log2(n_points)) + 2
    stack = np.empty((n_places, 5), np.int64)  # node, start, end, depth, packed class counts
    n_with_histograms = N_POINTS_FOR_HISTOGRAMS if n_tried == n_features else n_points + 1
    n_kept = n_places if n_points >= n_with_histograms else 0
    histograms = np.empty((n_kept, n_features, N_BINS), np.int64)
    if n_kept > 0:
        fill_histograms(histograms[0], points, counts, order)
    push(stack, 0, 0, 0, n_points, 0, total)
    top, n_nodes, deepest = 0, 1, 0
    while top >= 0:
        node, start, end, depth, total = stack[top]
        here = order[start:end]
        n_not, n_salient = total & NOT_SALIENT_BITS, total >> 32
        values[node] = n_salient * weights[1] / (n_salient * weights[1] + n_not * weights[0])
        score, feature, threshold = -1.0, 0, 0
        if depth < max_depth and min(n_not, n_salient) > 0 and n_not + n_salient >= min_split:
            if here.size >= n_with_histograms:
                score, feature, threshold = find_split_in_histograms(
                    histograms[top], total, weights
                )
            else:
                score, feature, threshold = find_split_in_points(
                    points, counts, here, total, weights, features, n_tried, state
                )
        if score < 0:
            nodes[node] = (node << 24) | (N_BINS - 1)
            deepest = max(deepest, depth)
            top -= 1
            continue
        nodes[node] = (n_nodes << 24) | (feature << 8) | threshold
        n_left, total_left = partition(here, scratch, points, counts, feature, threshold)
        push_children(stack, top, n_nodes, n_left, total_left)
        if max(n_left, here.size - n_left) >= n_with_histograms and depth + 1 < max_depth:
            split_histograms(histograms, top, points, counts, here, n_left)
        n_nodes += 2
        top += 1
    return nodes[:n_nodes], values[:n_nodes], deepest


@kernel
def add_votes(
    nodes: Packed, values: Values, depth: int, rows: Rows, is_hard: bool, votes: Values
) -> None:
    """Add the tree's vote for each of `rows` (n, F) to `votes` (n,)."""
    places = np.zeros(N_LANES, np.int64)
    for start in range(0, rows.shape[0], N_LANES):
        block = rows[start : start + N_LANES]
        places[:] = 0
        for _ in range(depth):
            for lane in range(block.shape[0]):
                node = nodes[places[lane]]
                value = block[lane, (node >> 8) & FEATURE_BITS]
                places[lane] = (node >> 24) + (value > (node & 255))
        for lane in range(block.shape[0]):
            value = values[places[lane]]
            votes[start + lane] += np.float32(value > 0.5) if is_hard else value
