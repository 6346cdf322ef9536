"""Keep the rows of the forest's buffer, and draw what a tree grows on: compiled loops.

The buffer's table is (F, C) uint8: each column is a row of features. `columns` (n,) int32 says
which one each sample has; equal samples that follow each other share one.
"""

from __future__ import annotations

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
)

Labels = npt.NDArray[np.bool_]
Keys = npt.NDArray[np.uint64]

# A row is drawn where its key, mixed with the tree's seed, is below a bound out of so many.
ALL_KEYS = 1 << 32


@kernel
def mix(number: np.uint64) -> np.uint64:
    """Return the number with all its bits stirred (the last steps of splitmix64)."""
    number = (number ^ (number >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    number = (number ^ (number >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return number ^ (number >> np.uint64(31))


@kernel
def is_drawn(key: np.uint64, seed: np.uint64, bound: np.uint64) -> bool:
    """Tell whether a tree of this seed draws rows of this key: `bound` of `ALL_KEYS` do."""
    return bool((mix(key ^ seed) >> np.uint64(32)) < bound)


@kernel
def find_free(columns: Indices, n_columns: int, n_wanted: int) -> Indices:
    """Return the first `n_wanted` columns that no sample has, fewer where there are no more."""
    is_free = np.ones(n_columns, np.bool_)
    for column in columns:
        is_free[column] = False
    free, n_found = np.empty(n_wanted, np.int32), 0
    for column in range(n_columns):
        if n_found == n_wanted:
            break
        if is_free[column]:
            free[n_found] = column
            n_found += 1
    return free[:n_found]


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
def put_rows(table: Points, keys: Keys, rows: Rows, columns: Indices) -> None:
    """Write each of `rows` (n, F) into its column, and its key: a hash of its features."""
    for row in range(rows.shape[0]):
        key = np.uint64(0)
        for feature in range(rows.shape[1]):
            table[feature, columns[row]] = rows[row, feature]
            key = (key ^ np.uint64(rows[row, feature])) * np.uint64(0x100000001B3)
        keys[columns[row]] = mix(key)


@kernel
def take_rows(table: Points, columns: Indices) -> Rows:
    """Return the (n, F) rows of some columns."""
    rows = np.empty((columns.size, table.shape[0]), np.uint8)
    for row in range(columns.size):
        for feature in range(table.shape[0]):
            rows[row, feature] = table[feature, columns[row]]
    return rows


@kernel
def take_points(table: Points, columns: Indices, shift: int) -> Points:
    """Return some columns, without the lowest bits, as the (F, P) points that a tree grows on."""
    points = np.empty((table.shape[0], columns.size), np.uint8)
    for feature in range(table.shape[0]):
        values = table[feature]
        for point in range(columns.size):
            points[feature, point] = values[columns[point]] >> shift
    return points


@kernel
def draw_samples(
    table: Points, columns: Indices, is_salient: Labels, n_drawn: int, state: RandomState
) -> tuple[Indices, Packed]:
    """Draw `n_drawn` samples without replacement and merge equal neighbours.

    Return the (P,) columns and their packed class counts, P <= n_drawn. The pixels of a
    superpixel share a row, so P can be far smaller.
    """
    n_samples = columns.size
    drawn, counts = np.empty(n_drawn, np.int32), np.zeros(n_drawn, np.int64)
    n_points, n_missing = 0, n_drawn
    for sample in range(n_samples):
        if draw_below(state, n_samples - sample) >= n_missing:
            continue
        n_missing -= 1
        column = columns[sample]
        if n_points == 0 or not have_same_row(table, drawn[n_points - 1], column):
            drawn[n_points] = column
            n_points += 1
        counts[n_points - 1] += ONE_SALIENT if is_salient[sample] else 1
    return drawn[:n_points], counts[:n_points]


@kernel
def have_same_row(table: Points, one: int, other: int) -> bool:
    """Tell whether two columns hold the same row."""
    if one != other:
        for feature in range(table.shape[0]):
            if table[feature, one] != table[feature, other]:
                return False
    return True


@kernel
def count_rows(columns: Indices, is_salient: Labels) -> tuple[Indices, Packed]:
    """Return the (R,) columns that samples have, in their order, and packed class counts."""
    rows, counts, n_rows = np.empty(columns.size, np.int32), np.zeros(columns.size, np.int64), 0
    for sample in range(columns.size):
        if n_rows == 0 or rows[n_rows - 1] != columns[sample]:
            rows[n_rows] = columns[sample]
            n_rows += 1
        counts[n_rows - 1] += ONE_SALIENT if is_salient[sample] else 1
    return rows[:n_rows], counts[:n_rows]


@kernel
def draw_rows(
    rows: Indices, counts: Packed, keys: Keys, seed: np.uint64, bound: np.uint64
) -> tuple[Indices, Packed]:
    """Draw rows with all their samples, see `is_drawn`; return columns and class counts."""
    are_drawn, n_drawn = np.empty(rows.size, np.bool_), 0
    for place in range(rows.size):
        are_drawn[place] = is_drawn(keys[rows[place]], seed, bound)
        n_drawn += int(are_drawn[place])
    drawn, drawn_counts = np.empty(n_drawn, np.int32), np.empty(n_drawn, np.int64)
    n_drawn = 0
    for place in range(rows.size):
        if are_drawn[place]:
            drawn[n_drawn], drawn_counts[n_drawn] = rows[place], counts[place]
            n_drawn += 1
    return drawn, drawn_counts


@kernel
def find_unseen(columns: Indices, keys: Keys, seed: np.uint64, bound: np.uint64) -> Indices:
    """Return the places in `columns` of the rows that a tree does not draw."""
    places, n_places = np.empty(columns.size, np.int32), 0
    for place in range(columns.size):
        places[n_places] = place
        n_places += int(not is_drawn(keys[columns[place]], seed, bound))
    return places[:n_places]
