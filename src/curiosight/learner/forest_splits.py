"""Find where to split a node of a tree, and part its points: the loops behind `forest_growth.py`.

Trees grow on points, (F, P): a feature's values stand side by side, so that a pass over one
feature stays in the nearest cache. A node is a stretch of `order` (P,), the points' numbers, and
of `counts` (P,), which moves along with it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest_kernels import (
    N_BINS,
    NOT_SALIENT_BITS,
    Indices,
    Packed,
    Points,
    RandomState,
    draw_below,
    kernel,
)

Room = tuple[Packed, npt.NDArray[np.float64]]

# Features counted in one pass: their additions do not wait for each other.
N_SIDE_BY_SIDE = 4
# Bins compared with 0 at once.
N_AT_ONCE = 8


@kernel
def find_cut(
    bins: Packed, first: int, last: int, total: int, weights: Packed, room: Room
) -> tuple[float, int]:
    """Return (score, threshold) of the best cut between the values `first` and `last`.

    The score is the decrease of the weighted Gini impurity up to a factor of the node: with
    two classes, (l1 n0 - l0 n1)^2 over the product of both sides' weights; -1 if there is no
    cut. All terms are integers below 2^53 until the division, so the classes can be exchanged.
    The first of equal cuts wins; the threshold lies midway between the values it separates.
    """
    n_not, n_salient = np.float64(total & NOT_SALIENT_BITS), np.float64(total >> 32)
    weight_not, weight_salient = np.float64(weights[0]), np.float64(weights[1])
    weight = n_not * weight_not + n_salient * weight_salient
    lefts, scores = room
    inner, left = bins[first:last], 0
    n_cuts = inner.size
    for cut in range(n_cuts):
        left += inner[cut]
        lefts[cut] = left
    # A loop of its own, without branches: the compiler does several divisions at once.
    for cut in range(n_cuts):
        left_not, left_salient = (
            np.float64(lefts[cut] & NOT_SALIENT_BITS),
            np.float64(lefts[cut] >> 32),
        )
        difference = left_salient * n_not - left_not * n_salient
        weight_left = left_not * weight_not + left_salient * weight_salient
        scores[cut] = difference * difference / (weight_left * (weight - weight_left))
    best_score, best = -1.0, -1
    for cut in range(n_cuts):
        # 0 / 0 = NaN where a side is empty: never better.
        if scores[cut] > best_score:
            best_score, best = scores[cut], cut
    if best < 0:
        return -1.0, 0
    after = first + best + 1
    while bins[after] == 0:
        after += 1
    return best_score, (first + best + after) >> 1


@kernel
def make_room() -> Room:
    """Return what `find_cut` writes to while it works."""
    return np.empty(N_BINS, np.int64), np.empty(N_BINS, np.float64)


@kernel
def count_bins(
    bins: Packed, points: Points, order: Indices, counts: Packed, features: Indices
) -> None:
    """Add the points `order` and their `counts` to `bins` (f, 256), of `features` (f,)."""
    n_in_fours = features.size - features.size % N_SIDE_BY_SIDE
    for first in range(0, n_in_fours, N_SIDE_BY_SIDE):
        column_0, column_1 = points[features[first]], points[features[first + 1]]
        column_2, column_3 = points[features[first + 2]], points[features[first + 3]]
        bins_0, bins_1, bins_2, bins_3 = (
            bins[first],
            bins[first + 1],
            bins[first + 2],
            bins[first + 3],
        )
        for place in range(order.size):
            point, count = order[place], counts[place]
            bins_0[column_0[point]] += count
            bins_1[column_1[point]] += count
            bins_2[column_2[point]] += count
            bins_3[column_3[point]] += count
    for turn in range(n_in_fours, features.size):
        column, bins_0 = points[features[turn]], bins[turn]
        for place in range(order.size):
            bins_0[column[order[place]]] += counts[place]


@kernel
def fill_histograms(
    histograms: Packed, points: Points, order: Indices, counts: Packed, features: Indices
) -> None:
    """Count the points `order` into `histograms` (F, 256), of all `features` in turn."""
    for feature in range(histograms.shape[0]):
        for value in range(N_BINS):
            histograms[feature, value] = 0
    count_bins(histograms, points, order, counts, features)


@kernel
def split_histograms(
    histograms: Packed,
    top: int,
    points: Points,
    order: Indices,
    counts: Packed,
    features: Indices,
    n_left: int,
) -> None:
    """Turn the histograms of a node, at `top`, into those of its children.

    The larger child's stay at `top`, the smaller one's follow: only its points are counted.
    """
    is_left_larger = 2 * n_left > order.size
    first, last = (n_left, order.size) if is_left_larger else (0, n_left)
    smaller = histograms[top + 1]
    fill_histograms(smaller, points, order[first:last], counts[first:last], features)
    for feature in range(histograms.shape[1]):
        for value in range(N_BINS):
            histograms[top, feature, value] -= histograms[top + 1, feature, value]


@kernel
def find_split_in_histograms(
    histograms: Packed, total: int, weights: Packed, room: Room
) -> tuple[float, int, int]:
    """Return (score, feature, threshold) of the best cut of all features, -1 if none."""
    best_score, best_feature, best_threshold = -1.0, 0, 0
    for feature in range(histograms.shape[0]):
        score, threshold = find_cut(histograms[feature], 0, N_BINS - 1, total, weights, room)
        if score > best_score:
            best_score, best_feature, best_threshold = score, feature, threshold
    return best_score, best_feature, best_threshold


@kernel
def find_ends(bins: Packed) -> tuple[int, int]:
    """Return the first and the last bin that is not 0; there is one."""
    first, last = 0, bins.size - 1
    while first + N_AT_ONCE <= bins.size and is_empty(bins, first):
        first += N_AT_ONCE
    while bins[first] == 0:
        first += 1
    while last + 1 >= N_AT_ONCE and is_empty(bins, last + 1 - N_AT_ONCE):
        last -= N_AT_ONCE
    while bins[last] == 0:
        last -= 1
    return first, last


@kernel
def is_empty(bins: Packed, first: int) -> bool:
    """Tell whether `N_AT_ONCE` bins from the first on are all 0, in one comparison."""
    together = 0
    for place in range(N_AT_ONCE):
        together |= bins[np.uint64(first) + np.uint64(place)]
    return together == 0


@kernel
def find_split_of(
    points: Points,
    order: Indices,
    counts: Packed,
    total: int,
    weights: Packed,
    features: Indices,
    bins: Packed,
    room: Room,
) -> tuple[float, int, int]:
    """Return (score, feature, threshold) of the best cut of a few features, -1 if none.

    features: (f,); as many as `bins` (f, L) at most, which are all 0 before and after.
    """
    count_bins(bins, points, order, counts, features)
    best_score, best_feature, best_threshold = -1.0, 0, 0
    for turn in range(features.size):
        first, last = find_ends(bins[turn])
        score, threshold = find_cut(bins[turn], first, last, total, weights, room)
        bins[turn, first : last + 1] = 0
        if score > best_score:
            best_score, best_feature, best_threshold = score, features[turn], threshold
    return best_score, best_feature, best_threshold


@kernel
def find_split_in_points(
    points: Points,
    order: Indices,
    counts: Packed,
    total: int,
    weights: Packed,
    features: Indices,
    n_tried: int,
    bins: Packed,
    room: Room,
    state: RandomState,
) -> tuple[float, int, int]:
    """Return (score, feature, threshold) of the best cut of `n_tried` features, -1 if none.

    Where `n_tried` is not all of them they are drawn at random, and the search goes on until
    one is not constant. `features` is a permutation that the draws go on shuffling.
    """
    best_score, best_feature, best_threshold = -1.0, 0, 0
    turn = 0
    while turn < n_tried or (turn < features.size and best_score < 0):
        n_more = min(N_SIDE_BY_SIDE, n_tried - turn) if turn < n_tried else 1
        if n_tried < features.size:
            for place in range(turn, turn + n_more):
                drawn = place + draw_below(state, features.size - place)
                features[place], features[drawn] = features[drawn], features[place]
        score, feature, threshold = find_split_of(
            points, order, counts, total, weights, features[turn : turn + n_more], bins, room
        )
        if score > best_score:
            best_score, best_feature, best_threshold = score, feature, threshold
        turn += n_more
    return best_score, best_feature, best_threshold


@kernel
def partition(
    order: Indices, counts: Packed, scratch: Indices, moved: Packed, column: Points, threshold: int
) -> tuple[int, int]:
    """Move the points that go left, and their counts, to the front; both sides stay in order.

    column: the points' values of the split's feature; `scratch` and `moved`: room for as many.
    Return how many go left and their packed class counts.
    """
    # Without a sign no index counts from the end: sooner.
    n_left, n_right, total_left = np.uint32(0), np.uint32(0), 0
    for place in range(order.size):
        point, count = order[place], counts[place]
        goes_left = np.uint32(column[np.uint32(point)] <= threshold)
        # Write to both sides and keep one: the branch would be wrong half of the time.
        order[n_left], counts[n_left] = point, count
        scratch[n_right], moved[n_right] = point, count
        n_left += goes_left
        n_right += np.uint32(1) - goes_left
        total_left += count * np.int64(goes_left)
    for place in range(int(n_right)):
        target = n_left + np.uint32(place)
        order[target], counts[target] = scratch[place], moved[place]
    return int(n_left), total_left
