"""Keep the rows of the forest's buffer, and draw what a tree grows on: compiled loops.

The buffer's table is (C, F) uint8: rows of features, in no order. `places` (n,) int32 says
which one each sample has; equal samples that follow each other share one.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.learner.forest_kernels import (
    ONE_SALIENT,
    Indices,
    Packed,
    Points,
    RandomState,
    Rows,
    draw_below,
    kernel,
    mix,
)

Labels = npt.NDArray[np.bool_]
Keys = npt.NDArray[np.uint64]

# A row is drawn where its key, mixed with the tree's seed, is below a bound out of so many.
ALL_KEYS = 1 << 32


@kernel
def is_drawn(key: np.uint64, seed: np.uint64, bound: np.uint64) -> bool:
    """Tell whether a tree of this seed draws rows of this key: `bound` of `ALL_KEYS` do."""
    return bool((mix(key ^ seed) >> np.uint64(32)) < bound)


@kernel
def find_free(places: Indices, n_places: int, n_wanted: int) -> Indices:
    """Return the first `n_wanted` places that no sample has, fewer where there are no more."""
    is_free = np.ones(n_places, np.bool_)
    for place in places:
        is_free[place] = False
    free, n_found = np.empty(n_wanted, np.int32), 0
    for place in range(n_places):
        if n_found == n_wanted:
            break
        if is_free[place]:
            free[n_found] = place
            n_found += 1
    return free[:n_found]


@kernel
def draw_some(
    groups: npt.NDArray[np.int64],
    n_members: npt.NDArray[np.int64],
    n_drawn: npt.NDArray[np.int64],
    chances: npt.NDArray[np.float64],
) -> Labels:
    """Draw so many members of each group, all as likely (Knuth's algorithm S); return (n,) who.

    groups: (n,) each one's. n_members, n_drawn: (n_groups,). chances: (n,) in [0, 1).
    """
    drawn = np.zeros(len(groups), np.bool_)
    n_left, n_wanted = n_members.copy(), n_drawn.copy()
    for index, group in enumerate(groups):
        if chances[index] * n_left[group] < n_wanted[group]:
            drawn[index] = True
            n_wanted[group] -= 1
        n_left[group] -= 1
    return drawn


@kernel
def find_runs(rows: Rows) -> Indices:
    """Number the (n,) runs of equal rows that follow each other: 0, 0, 1, ..."""
    numbers, number = np.zeros(rows.shape[0], np.int32), 0
    for row in range(1, rows.shape[0]):
        for feature in range(rows.shape[1]):
            if rows[row, feature] != rows[row - 1, feature]:
                number += 1
                break
        numbers[row] = number
    return numbers


@kernel
def put_rows(table: Rows, keys: Keys, rows: Rows, places: Indices) -> None:
    """Write each of `rows` (n, F) to its place, and its key: a hash of its features."""
    for row in range(rows.shape[0]):
        key = np.uint64(0)
        for feature in range(rows.shape[1]):
            table[places[row], feature] = rows[row, feature]
            key = (key ^ np.uint64(rows[row, feature])) * np.uint64(0x100000001B3)
        keys[places[row]] = mix(key)


def take_points(table: Rows, places: Indices, shift: int) -> Points:
    """Return some rows, without the lowest bits, as the (F, P) points that a tree grows on."""
    points: Points = cv2.transpose(table.take(places, axis=0))
    return points >> np.uint8(shift) if shift else points


@kernel
def draw_samples(
    table: Rows, places: Indices, is_salient: Labels, n_drawn: int, state: RandomState
) -> tuple[Indices, Packed]:
    """Draw `n_drawn` samples without replacement and merge equal neighbours.

    Return the (P,) places and their packed class counts, P <= n_drawn. The pixels of a
    superpixel share a row, so P can be far smaller.
    """
    n_samples = places.size
    drawn, counts = np.empty(n_drawn, np.int32), np.zeros(n_drawn, np.int64)
    n_points, n_missing = 0, n_drawn
    for sample in range(n_samples):
        if draw_below(state, n_samples - sample) >= n_missing:
            continue
        n_missing -= 1
        place = places[sample]
        if n_points == 0 or not have_same_row(table, drawn[n_points - 1], place):
            drawn[n_points] = place
            n_points += 1
        counts[n_points - 1] += ONE_SALIENT if is_salient[sample] else 1
    return drawn[:n_points], counts[:n_points]


@kernel
def have_same_row(table: Rows, one: int, other: int) -> bool:
    """Tell whether two places hold the same row."""
    if one != other:
        for feature in range(table.shape[1]):
            if table[one, feature] != table[other, feature]:
                return False
    return True


@kernel
def count_rows(places: Indices, is_salient: Labels) -> tuple[Indices, Packed]:
    """Return the (R,) places that samples have, in their order, and packed class counts."""
    rows, counts = np.empty(places.size, np.int32), np.zeros(places.size, np.int64)
    row, before = -1, np.int32(-1)
    for sample in range(places.size):
        # No branches: they would be guessed wrong too often.
        row += int(places[sample] != before)
        before = places[sample]
        rows[row] = before
        counts[row] += 1 + np.int64(is_salient[sample]) * (ONE_SALIENT - 1)
    return rows[: row + 1], counts[: row + 1]


@kernel
def draw_rows(
    rows: Indices, counts: Packed, keys: Keys, seed: np.uint64, bound: np.uint64
) -> tuple[Indices, Packed]:
    """Draw rows with all their samples, see `is_drawn`; return places and class counts."""
    drawn, n_drawn = np.empty(rows.size, np.int32), 0
    for row in range(rows.size):
        drawn[n_drawn] = row
        n_drawn += int(is_drawn(keys[np.uint32(rows[row])], seed, bound))
    return rows[drawn[:n_drawn]], counts[drawn[:n_drawn]]
