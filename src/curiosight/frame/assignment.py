"""Pair the rows of a matrix with its columns so that their sum is largest (Hungarian method)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


def best_pairs(gains: npt.ArrayLike) -> tuple[Ints, Ints]:
    """Return the rows, in order, and the columns of the pairs whose gains sum up to most.

    gains: (n, m) finite. Each row and each column is in one pair at most, and there are as many
    pairs as can be: the fewer of n and m.
    """
    costs = -np.asarray(gains, np.float64)
    if costs.ndim != 2 or not np.isfinite(costs).all():
        raise ValueError(f"gains: expected (n, m) finite numbers, got {costs.shape}")
    if costs.shape[0] > costs.shape[1]:
        columns = _columns_of_rows(costs.T)
        order = np.argsort(columns)
        return columns[order], order
    return np.arange(len(costs)), _columns_of_rows(costs)


def _columns_of_rows(costs: Floats) -> Ints:
    """Return the column of each of n rows, n at most as many as columns.

    Row by row, along the way of alternating pairs that costs least more (shortest augmenting
    path); the prices of rows and columns keep all reduced costs from being negative.
    """
    n_rows, n_columns = costs.shape
    row_prices, column_prices = np.zeros(n_rows), np.zeros(n_columns)
    row_of, column_of = np.full(n_columns, -1), np.full(n_rows, -1)
    for start in range(n_rows):
        reached, before = np.full(n_columns, np.inf), np.full(n_columns, -1)
        waiting = np.arange(n_columns)[::-1].copy()
        row, least, passed = start, 0.0, [start]
        while True:
            cost = least + costs[row, waiting] - row_prices[row] - column_prices[waiting]
            nearer = waiting[cost < reached[waiting]]
            before[nearer] = row
            reached[waiting] = np.minimum(reached[waiting], cost)
            least = float(reached[waiting].min())
            # Of equally near columns one that is free, that the way may end.
            nearest = np.flatnonzero(reached[waiting] == least)
            free = nearest[row_of[waiting[nearest]] < 0]
            place = free[-1] if len(free) else nearest[0]
            column = int(waiting[place])
            waiting[place] = waiting[-1]
            waiting = waiting[:-1]
            if row_of[column] < 0:
                break
            row = int(row_of[column])
            passed.append(row)
        row_prices[start] += least
        for other in passed[1:]:
            row_prices[other] += least - reached[column_of[other]]
        is_done = np.ones(n_columns, np.bool_)
        is_done[waiting] = False
        column_prices[is_done] -= least - reached[is_done]
        while True:
            row = int(before[column])
            row_of[column] = row
            column, column_of[row] = int(column_of[row]), column
            if row == start:
                break
    return column_of
