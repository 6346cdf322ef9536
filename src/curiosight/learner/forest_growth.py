"""Grow one tree of the forest, depth first, on the loops of `forest_splits.py`."""

from __future__ import annotations

import numpy as np

from curiosight.learner.forest_kernels import (
    N_BINS,
    NOT_SALIENT_BITS,
    Indices,
    Packed,
    Points,
    RandomState,
    Values,
    has_both,
    kernel,
)
from curiosight.learner.forest_splits import (
    N_SIDE_BY_SIDE,
    fill_histograms,
    find_split_in_histograms,
    find_split_in_points,
    make_room,
    partition,
    split_histograms,
)

# A node of fewer points counts them feature by feature; the result is the same.
N_POINTS_FOR_HISTOGRAMS = 256


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
    points: Points,
    counts: Packed,
    max_depth: int,
    min_split: int,
    n_tried: int,
    shift: int,
    state: RandomState,
) -> tuple[Packed, Values, int]:
    """Grow a tree on (F, P) `points` with class counts `counts`; return nodes, values, depth.

    The points' values have lost their `shift` lowest bits; the tree asks for values that have not.

    A node is a leaf at `max_depth`, below `min_split` samples, when it is pure, and when all
    its features are constant. The smaller child grows first: so the stack stays shorter than
    log2(P) + 2, and a node's place in the stack is its place in `histograms` too. `counts` are
    moved about.
    """
    n_features, n_points = points.shape
    total, weights = weigh_classes(counts)
    nodes, values = np.empty(2 * n_points, np.int64), np.empty(2 * n_points, np.float32)
    order, scratch, features = count_up(n_points), count_up(n_points), count_up(n_features)
    moved = np.empty(n_points, np.int64)
    n_places = int(np.log2(n_points)) + 2
    stack = np.empty((n_places, 5), np.int64)  # node, start, end, depth, packed class counts
    n_with_histograms = N_POINTS_FOR_HISTOGRAMS if n_tried == n_features else n_points + 1
    n_kept = n_places if n_points >= n_with_histograms else 0
    histograms = np.empty((n_kept, n_features, N_BINS), np.int64)
    bins, room = np.zeros((N_SIDE_BY_SIDE, N_BINS >> shift), np.int64), make_room()
    if n_kept > 0:
        fill_histograms(histograms[0], points, order, counts, features)
    push(stack, 0, 0, 0, n_points, 0, total)
    top, n_nodes, deepest = 0, 1, 0
    while top >= 0:
        node, start, end, depth, total = stack[top]
        here, counts_here = order[start:end], counts[start:end]
        n_not, n_salient = total & NOT_SALIENT_BITS, total >> 32
        values[node] = n_salient * weights[1] / (n_salient * weights[1] + n_not * weights[0])
        score, feature, threshold = -1.0, 0, 0
        if depth < max_depth and has_both(total) and n_not + n_salient >= min_split:
            if here.size >= n_with_histograms:
                score, feature, threshold = find_split_in_histograms(
                    histograms[top], total, weights, room
                )
            else:
                score, feature, threshold = find_split_in_points(
                    points, here, counts_here, total, weights, features, n_tried, bins, room, state
                )
        if score < 0:
            nodes[node] = (node << 24) | (N_BINS - 1)
            deepest = max(deepest, depth)
            top -= 1
            continue
        nodes[node] = (n_nodes << 24) | (feature << 8) | ((threshold + 1 << shift) - 1)
        n_left, total_left = partition(
            here, counts_here, scratch, moved, points[feature], threshold
        )
        push_children(stack, top, n_nodes, n_left, total_left)
        if max(n_left, here.size - n_left) >= n_with_histograms and depth + 1 < max_depth:
            split_histograms(histograms, top, points, here, counts_here, features, n_left)
        n_nodes += 2
        top += 1
    return nodes[:n_nodes], values[:n_nodes], deepest
