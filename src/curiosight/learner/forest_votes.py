"""Ask a tree: compiled loops that walk several rows down side by side."""

from __future__ import annotations

import numpy as np

from curiosight.learner.forest_kernels import FEATURE_BITS, Packed, Rows, Values, kernel

# Indices without a sign: none counts from the end, which saves looking.
Four = tuple[np.uint64, np.uint64, np.uint64, np.uint64]

# Rows walked side by side: their memory accesses overlap.
N_LANES = 8


@kernel
def step(nodes: Packed, of_rows: Rows, row: np.uint64, place: np.uint64) -> np.uint64:
    """Return the node after that at `place`, for the row that begins at `row` of all of them."""
    node = np.uint64(nodes[place])
    value = of_rows[row + ((node >> np.uint64(8)) & np.uint64(FEATURE_BITS))]
    return (node >> np.uint64(24)) + np.uint64(value > (node & np.uint64(255)))


@kernel
def step_four(nodes: Packed, of_rows: Rows, rows: Four, places: Four) -> Four:
    """Return what `step` does of four rows: their memory accesses overlap."""
    return (
        step(nodes, of_rows, rows[0], places[0]),
        step(nodes, of_rows, rows[1], places[1]),
        step(nodes, of_rows, rows[2], places[2]),
        step(nodes, of_rows, rows[3], places[3]),
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
