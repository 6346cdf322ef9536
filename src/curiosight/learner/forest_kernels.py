"""Part the points of a node, and ask a tree: the compiled loops behind `forest.py`.

A tree is two arrays. `nodes` (N,) int64 packs a node into eight bytes, `left child << 24 |
feature << 8 | threshold`: a row goes left where its feature is <= threshold, else to the node
after the left child. A leaf is its own left child with threshold 255, so a walk that has
arrived stays. `values` (N,) float32 is the salient share of a node's weight.

Trees grow on points, (F, P): a feature's values stand side by side, so that a pass over one
feature stays in the nearest cache. A node is a stretch of `order` (P,), the points' numbers, and
of `counts` (P,), which moves along with it.

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
Points = npt.NDArray[np.uint8]
Packed = npt.NDArray[np.int64]
Indices = npt.NDArray[np.int32]
Values = npt.NDArray[np.float32]
RandomState = npt.NDArray[np.uint64]
# Indices without a sign: none counts from the end, which saves looking.
Four = tuple[np.uint64, np.uint64, np.uint64, np.uint64]
Room = tuple[Packed, npt.NDArray[np.float64]]

N_BINS = 256
ONE_SALIENT = 1 << 32
NOT_SALIENT_BITS = ONE_SALIENT - 1
FEATURE_BITS = (1 << 16) - 1
# Features counted in one pass: their additions do not wait for each other.
N_SIDE_BY_SIDE = 4
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
    while first + N_LANES <= bins.size and is_empty(bins, first):
        first += N_LANES
    while bins[first] == 0:
        first += 1
    while last + 1 >= N_LANES and is_empty(bins, last + 1 - N_LANES):
        last -= N_LANES
    while bins[last] == 0:
        last -= 1
    return first, last


@kernel
def is_empty(bins: Packed, first: int) -> bool:
    """Tell whether `N_LANES` bins from the first on are all 0, in one comparison."""
    together = 0
    for place in range(N_LANES):
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


@kernel
def has_both(total: int) -> bool:
    """Tell whether packed class counts hold both classes."""
    return min(total >> 32, total & NOT_SALIENT_BITS) > 0


@kernel
def step(nodes: Packed, values: Points, row: np.uint64, place: np.uint64) -> np.uint64:
    """Return the node after that at `place`, for the row whose values begin at `row`."""
    node = np.uint64(nodes[place])
    value = values[row + ((node >> np.uint64(8)) & np.uint64(FEATURE_BITS))]
    return (node >> np.uint64(24)) + np.uint64(value > (node & np.uint64(255)))


@kernel
def step_four(nodes: Packed, values: Points, rows: Four, places: Four) -> Four:
    """Return what `step` does of four rows: their memory accesses overlap."""
    return (
        step(nodes, values, rows[0], places[0]),
        step(nodes, values, rows[1], places[1]),
        step(nodes, values, rows[2], places[2]),
        step(nodes, values, rows[3], places[3]),
    )


@kernel
def have_moved(before: Four, after: Four) -> bool:
    """Tell whether any of four places is another."""
    moved = (before[0] ^ after[0]) | (before[1] ^ after[1])
    return bool(moved | (before[2] ^ after[2]) | (before[3] ^ after[3]))


@kernel
def add_votes(
    nodes: Packed, values: Values, depth: int, rows: Rows, is_hard: bool, votes: Values
) -> None:
    """Add the tree's vote for each of `rows` (n, F) to `votes` (n,)."""
    root, n_features = np.uint64(0), np.uint64(rows.shape[1])
    of_rows = rows.reshape(-1)
    for start in range(0, rows.shape[0], N_LANES):
        # Eight rows side by side; of fewer the last one several times.
        first = np.uint64(start)
        last = np.uint64(rows.shape[0] - 1)
        upper = (
            first * n_features,
            min(first + np.uint64(1), last) * n_features,
            min(first + np.uint64(2), last) * n_features,
            min(first + np.uint64(3), last) * n_features,
        )
        lower = (
            min(first + np.uint64(4), last) * n_features,
            min(first + np.uint64(5), last) * n_features,
            min(first + np.uint64(6), last) * n_features,
            min(first + np.uint64(7), last) * n_features,
        )
        one, other = (root, root, root, root), (root, root, root, root)
        for _ in range(0, depth, 2):
            # Two steps between looking whether all have arrived.
            one_before = step_four(nodes, of_rows, upper, one)
            other_before = step_four(nodes, of_rows, lower, other)
            one = step_four(nodes, of_rows, upper, one_before)
            other = step_four(nodes, of_rows, lower, other_before)
            if not (have_moved(one_before, one) or have_moved(other_before, other)):
                break
        places = one + other
        for lane in range(min(N_LANES, rows.shape[0] - start)):
            value = values[places[lane]]
            votes[start + lane] += np.float32(value > 0.5) if is_hard else value
