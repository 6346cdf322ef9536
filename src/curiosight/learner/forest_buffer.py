"""The forest's buffer: labelled samples whose rows stay where they are while others come and go."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest_draws import (
    ALL_KEYS,
    Keys,
    Labels,
    count_rows,
    draw_rows,
    draw_samples,
    draw_some,
    find_free,
    find_runs,
    put_rows,
)
from curiosight.learner.forest_kernels import Indices, Packed, RandomState, Rows

# A table that is too small becomes so many times as long.
GROWTH = 1.5


class DistinctRows(NamedTuple):
    """The rows of samples: (R,) places in the table, and packed class counts of each."""

    places: Indices
    counts: Packed


class Samples(NamedTuple):
    """Labelled samples, oldest first, and the table of their rows.

    table: (C, F) uint8, rows of features in no order; some no sample has.
    keys: (C,) uint64, a hash of each row.
    places: (n,) int32, in the table, each sample's; equal samples that follow each other share one.
    is_salient, groups: (n,) bool and int32, each sample's.

    The last three never change. `with_more` writes to places that no sample here has, so these
    samples stay what they are until it is called for those that it returned.
    """

    table: Rows
    keys: Keys
    places: Indices
    is_salient: Labels
    groups: Indices

    @classmethod
    def none(cls, n_features: int) -> Self:
        """Return an empty buffer."""
        table, keys = np.empty((0, n_features), np.uint8), np.empty(0, np.uint64)
        nothing = np.empty(0, np.int32)
        return cls(table, keys, nothing, np.empty(0, np.bool_), nothing)

    @classmethod
    def of(cls, rows: Rows, is_salient: Labels, groups: Indices) -> Self:
        """Return a buffer of (n, F) rows with (n,) labels and groups, in their order."""
        return cls.none(rows.shape[1])._appended(rows, is_salient, groups)

    def rows(self) -> Rows:
        """Return the (n, F) rows of the samples."""
        return self.table.take(self.places, axis=0)

    def has_both(self) -> bool:
        """Tell whether both classes are among the samples."""
        return bool(self.is_salient.any() and not self.is_salient.all())

    def distinct_rows(self) -> DistinctRows:
        """Return the rows of the samples, one for those that share a place, in their order."""
        return DistinctRows(*count_rows(self.places, self.is_salient))

    def draw_samples(self, share: float, state: RandomState) -> DistinctRows:
        """Draw a share of the samples, one at least, and return the rows they have."""
        n_drawn = max(1, round(share * len(self.places)))
        return DistinctRows(*draw_samples(self.table, self.places, self.is_salient, n_drawn, state))

    def draw_rows(self, rows: DistinctRows, seed: int, bound: int) -> tuple[DistinctRows, int]:
        """Draw some rows with all their samples, see `is_drawn`; all rows if that draws none.

        Return them and the bound: `ALL_KEYS` where all are drawn.
        """
        drawn = draw_rows(*rows, self.keys, np.uint64(seed), np.uint64(bound))
        if len(drawn[0]) == 0:
            return DistinctRows(rows.places, rows.counts.copy()), ALL_KEYS
        return DistinctRows(*drawn), bound

    def with_more(
        self,
        rows: Rows,
        is_salient: Labels,
        groups: npt.NDArray[np.int32],
        max_samples: int,
        rng: np.random.Generator,
    ) -> Self:
        """Return these samples and more, without those that are too many.

        Random ones leave, new or old, of those groups that have most, so that no group takes the
        room of others because it came later.

        rows: (n, F); equal ones come side by side, so that they share a place.
        """
        order = np.argsort(rows.view((np.void, rows.shape[1])).ravel(), kind="stable")
        n_old = len(self.places)
        if n_old + len(rows) <= max_samples:
            return self._appended(rows[order], is_salient[order], groups[order])
        evicted = _too_many(np.concatenate([self.groups, groups[order]]), max_samples, rng)
        order = np.delete(order, evicted[evicted >= n_old] - n_old)
        left = evicted[evicted < n_old]
        return self._appended(rows[order], is_salient[order], groups[order], left)

    def without_oldest(self, n_oldest: int) -> Self:
        """Return all but the oldest samples."""
        return self._replace(
            places=self.places[n_oldest:],
            is_salient=self.is_salient[n_oldest:],
            groups=self.groups[n_oldest:],
        )

    def _appended(
        self,
        rows: Rows,
        is_salient: Labels,
        groups: Indices,
        left: npt.NDArray[np.int64] | tuple[()] = (),
    ) -> Self:
        """Return the samples without those that have left, and new ones behind them."""
        runs = find_runs(rows)
        firsts = np.flatnonzero(np.diff(runs, prepend=-1))
        table, keys, free = self._room(len(firsts))
        put_rows(table, keys, rows[firsts], free)
        old = [np.delete(values, left) if len(left) else values for values in self[2:]]
        more = (free[runs], is_salient, groups)
        together = [np.concatenate(pair) for pair in zip(old, more, strict=True)]
        return type(self)(table, keys, *together)

    def _room(self, n_wanted: int) -> tuple[Rows, Keys, Indices]:
        """Return the table and its keys, longer where they must be, and so many free places."""
        n_places = len(self.keys)
        free = find_free(self.places, n_places, n_wanted)
        n_missing = n_wanted - len(free)
        if n_missing == 0:
            return self.table, self.keys, free
        n_longer = max(n_places + n_missing, int(GROWTH * n_places))
        table = np.zeros((n_longer, self.table.shape[1]), np.uint8)
        keys = np.zeros(n_longer, np.uint64)
        table[:n_places], keys[:n_places] = self.table, self.keys
        new = np.arange(n_places, n_places + n_missing, dtype=np.int32)
        return table, keys, np.concatenate([free, new])


def _too_many(groups: Indices, n_kept: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return which samples of (n,) groups leave, so that so many stay."""
    # Those of a frame are of one group and lie side by side: what is counted are runs.
    starts = np.append(0, np.flatnonzero(groups[1:] != groups[:-1]) + 1)
    n_in_run = np.diff(starts, append=len(groups))
    _, of_run = np.unique(groups[starts], return_inverse=True)
    n_members = np.bincount(of_run, n_in_run).astype(np.int64)
    n_leaving = n_members - _fair_shares(n_members, n_kept)
    of_sample = np.repeat(of_run, n_in_run)
    return np.flatnonzero(draw_some(of_sample, n_members, n_leaving, rng.random(len(groups))))


def _fair_shares(wanted: npt.NDArray[np.int64], n: int) -> npt.NDArray[np.int64]:
    """Divide `n` among those who want so many each: who wants little has it, others share."""
    order = np.argsort(wanted, kind="stable")
    shares = np.empty_like(wanted)
    left = n
    for rank, number in enumerate(order.tolist()):
        shares[number] = min(wanted[number], left // (len(order) - rank))
        left -= int(shares[number])
    return shares
