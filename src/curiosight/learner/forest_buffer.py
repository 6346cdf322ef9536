"""The forest's buffer: labelled samples whose rows stay where they are while others come and go."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest_draws import (
    Keys,
    Labels,
    find_free,
    find_runs,
    put_rows,
    take_rows,
)
from curiosight.learner.forest_kernels import Indices, Points, Rows

# A table that is too small becomes so many times as wide.
GROWTH = 1.5


class Samples(NamedTuple):
    """Labelled samples, oldest first, and the table of their rows.

    table: (F, C) uint8, a row of features in each column; some columns no sample has.
    keys: (C,) uint64, a hash of each column.
    columns: (n,) int32, each sample's; equal samples that follow each other share one.
    is_salient, groups: (n,) bool and int32, each sample's.

    The last three never change. `with_more` writes to columns that no sample here has, so these
    samples stay what they are until it is called for those that it returned.
    """

    table: Points
    keys: Keys
    columns: Indices
    is_salient: Labels
    groups: Indices

    @classmethod
    def none(cls, n_features: int) -> Self:
        """Return an empty buffer."""
        table, keys = np.empty((n_features, 0), np.uint8), np.empty(0, np.uint64)
        nothing = np.empty(0, np.int32)
        return cls(table, keys, nothing, np.empty(0, np.bool_), nothing)

    @classmethod
    def of(cls, rows: Rows, is_salient: Labels, groups: Indices) -> Self:
        """Return a buffer of (n, F) rows with (n,) labels and groups, in their order."""
        return cls.none(rows.shape[1])._appended(rows, is_salient, groups)

    def rows(self) -> Rows:
        """Return the (n, F) rows of the samples."""
        return take_rows(self.table, self.columns)

    def has_both(self) -> bool:
        """Tell whether both classes are among the samples."""
        return bool(self.is_salient.any() and not self.is_salient.all())

    def with_more(
        self,
        rows: Rows,
        is_salient: Labels,
        groups: npt.NDArray[np.int32],
        max_samples: int,
        rng: np.random.Generator,
    ) -> Self:
        """Return these samples and more, without the random ones that are too many, new or old.

        rows: (n, F); equal ones come side by side, so that they share a column.
        """
        order = np.argsort(rows.view((np.void, rows.shape[1])).ravel(), kind="stable")
        n_old = len(self.columns)
        n_samples = n_old + len(rows)
        n_evicted = max(0, n_samples - max_samples)
        if n_evicted == 0:
            return self._appended(rows[order], is_salient[order], groups[order])
        evicted = rng.choice(n_samples, n_evicted, replace=False)
        order = np.delete(order, evicted[evicted >= n_old] - n_old)
        kept = np.delete(np.arange(n_old), evicted[evicted < n_old])
        return self._appended(rows[order], is_salient[order], groups[order], kept)

    def _appended(
        self,
        rows: Rows,
        is_salient: Labels,
        groups: Indices,
        kept: npt.NDArray[np.int64] | None = None,
    ) -> Self:
        """Return the samples that are kept, None = all, and new ones behind them."""
        if len(rows) == 0 and kept is None:
            return self
        runs = find_runs(rows)
        firsts = np.flatnonzero(np.diff(runs, prepend=-1))
        table, keys, free = self._room(len(firsts))
        put_rows(table, keys, rows[firsts], free)
        old = self[2:] if kept is None else [values[kept] for values in self[2:]]
        more = (free[runs], is_salient, groups)
        together = [np.concatenate(pair) for pair in zip(old, more, strict=True)]
        return type(self)(table, keys, *together)

    def _room(self, n_wanted: int) -> tuple[Points, Keys, Indices]:
        """Return the table and its keys, wider where they must be, and so many free columns."""
        n_columns = len(self.keys)
        free = find_free(self.columns, n_columns, n_wanted)
        n_missing = n_wanted - len(free)
        if n_missing == 0:
            return self.table, self.keys, free
        n_wider = max(n_columns + n_missing, int(GROWTH * n_columns))
        table, keys = np.zeros((len(self.table), n_wider), np.uint8), np.zeros(n_wider, np.uint64)
        table[:, :n_columns], keys[:n_columns] = self.table, self.keys
        new = np.arange(n_columns, n_columns + n_missing, dtype=np.int32)
        return table, keys, np.concatenate([free, new])
