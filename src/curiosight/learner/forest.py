"""The on-line random forest: a buffer of labelled rows, and trees that are regrown from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Literal, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from curiosight.errors.arguments import check_share, check_whole
from curiosight.learner.forest_buffer import DistinctRows, Samples
from curiosight.learner.forest_draws import ALL_KEYS, take_points
from curiosight.learner.forest_growth import grow_tree
from curiosight.learner.forest_kernels import FEATURE_BITS, N_BINS, Indices, Rows
from curiosight.learner.forest_trees import Arrays, Tree, pack_draws, pack_trees, unpack_trees
from curiosight.learner.forest_votes import add_votes

Scalar = TypeVar("Scalar", bound=np.generic)
Result = TypeVar("Result")

# By how many of its lowest bits a value may lose.
# Far over what helps: beyond them a setting is a slip of the pen, and would never end.
MAX_TREES, MAX_DEPTH, MAX_SAMPLES, MAX_THREADS = 1000, 1000, 10**8, 1024
LEVELS = tuple(N_BINS >> shift for shift in range(8))


class Known(NamedTuple):
    """What a forest has learned: its trees, none while untrained, and the buffer."""

    trees: tuple[Tree, ...]
    samples: Samples


class Forest:
    """Learn the saliency of rows of 8-bit features, a few trees at a time (sec. II-A.3).

    Every update adds labelled samples to a buffer and grows `n_regrown` random trees anew,
    each on another `share` of the buffer. Inside a tree both classes weigh the same, however
    rare one is: 0.5 means that a row is equally typical of both.

    max_samples: size of the buffer; beyond it random samples leave, new or old, of those groups
        that have most.
    min_split: a node of fewer samples is a leaf; so are pure nodes and those at `max_depth`.
    n_split_features: how many random features a split chooses from; None = all.
    leaf_share: a node of less than this share of what a tree draws is a leaf, too: the more is
        known, the larger are leaves, and labels that are wrong here and there do not sway them.
    n_levels: how many values of a feature a split tells apart, a power of 2.
    max_rows: a tree draws rows, with all samples that share each, instead of samples, and some
        `max_rows` at most. The oldest trees regrow; while they are small, more than `n_regrown`,
        as many as draw no more than `n_regrown * max_rows` together. So an update takes the same
        time, however full the buffer. None = neither, as the paper has it.
    vote: what a tree answers: `hard` = its leaf's majority, 0 or 1 (a tie is 0); `soft` = the
        salient share of its leaf.
    n_threads: trees grown at the same time; the result does not depend on it.

    A tree whose share holds one class only is a single leaf of that class.

    One thread at a time may learn; any number may predict meanwhile. All that learns puts its
    new trees and samples into place in one assignment, so every call of `predict`, `votes`,
    `rows` and `state_arrays` answers from the forest as it was before, or as it is after, never
    from a mixture.
    """

    def __init__(
        self,
        *,
        n_features: int,
        n_trees: int = 30,
        n_regrown: int = 4,
        share: float = 0.7,
        max_samples: int = 100_000,
        max_depth: int = 10,
        min_split: int = 11,
        n_split_features: int | None = None,
        leaf_share: float = 0.0,
        n_levels: int = N_BINS,
        max_rows: int | None = None,
        vote: Literal["hard", "soft"] = "hard",
        seed: int | np.random.Generator = 0,
        n_threads: int = 1,
    ) -> None:
        n_split_features = n_features if n_split_features is None else n_split_features
        check_whole("n_features", n_features, 1, FEATURE_BITS)
        check_whole("n_trees", n_trees, 1, MAX_TREES)
        check_whole("n_regrown", n_regrown, 1, n_trees)
        check_whole("max_samples", max_samples, 1, MAX_SAMPLES)
        check_whole("max_depth", max_depth, 0, MAX_DEPTH)
        check_whole("min_split", min_split, 2, MAX_SAMPLES)
        check_whole("n_split_features", n_split_features, 1, n_features)
        check_share("leaf_share", leaf_share)
        check_whole("n_levels", n_levels, 2, N_BINS)
        if n_levels not in LEVELS:
            raise ValueError(f"n_levels: expected one of {LEVELS}, got {n_levels}")
        check_whole("max_rows", 1 if max_rows is None else max_rows, 1, MAX_SAMPLES)
        check_whole("n_threads", n_threads, 1, MAX_THREADS)
        if isinstance(share, bool) or not 0 < share <= 1:
            raise ValueError(f"share: expected a number in (0, 1], got {share}")
        if vote not in ("hard", "soft"):
            raise ValueError(f"vote: expected 'hard' or 'soft', got {vote!r}")
        self.n_features = n_features
        self.n_trees = n_trees
        self.n_regrown = n_regrown
        self.share = share
        self.max_samples = max_samples
        self.max_depth = max_depth
        self.min_split = min_split
        self.n_split_features = n_split_features
        self.leaf_share = leaf_share
        self.n_levels = n_levels
        self.max_rows = max_rows
        self.vote = vote
        self.n_threads = n_threads
        self._rng = np.random.default_rng(seed)
        # Never changed, only replaced: whoever reads it while another thread learns keeps his.
        self._known = Known((), Samples.none(n_features))

    @property
    def is_trained(self) -> bool:
        """Tell whether both classes have been seen; until then every prediction is 0."""
        return bool(self._trees)

    @property
    def rng(self) -> np.random.Generator:
        """The source of chance, which forests that are made by `another` share."""
        return self._rng

    @property
    def n_samples(self) -> int:
        return len(self._known.samples.places)

    @property
    def n_drawn(self) -> int:
        """Return about how many rows a tree of an update draws; without `max_rows`, samples."""
        if self.max_rows is None:
            return max(1, round(self.share * self.n_samples))
        n_rows = len(self._known.samples.distinct_rows().places)
        return round(n_rows * self._bound(n_rows, is_limited=True) / ALL_KEYS)

    @property
    def rows(self) -> Rows:
        """Return a copy of the buffer's (n_samples, F) rows, oldest first."""
        return self._read(lambda known: known.samples.rows())

    @property
    def is_salient(self) -> npt.NDArray[np.bool_]:
        """Show the (n_samples,) labels; like the groups in the order of `rows`, read-only."""
        return _read_only(self._known.samples.is_salient)

    @property
    def groups(self) -> npt.NDArray[np.int32]:
        return _read_only(self._known.samples.groups)

    @property
    def _trees(self) -> tuple[Tree, ...]:
        return self._known.trees

    def update(
        self,
        rows: Rows,
        is_salient: npt.NDArray[np.bool_],
        group: int | npt.NDArray[np.int32] = 0,
    ) -> tuple[int, ...]:
        """Add (n, F) rows with (n,) labels, regrow some trees and return their indices.

        All trees grow as soon as both classes have been seen, none before, and none if there
        are no rows. `group` is kept with the samples: one number for all or (n,); none has more
        room in the buffer than another.
        """
        new = self._check_samples(rows, is_salient, group)
        if len(rows) == 0:
            return ()
        trees, samples = self._known
        return self._regrow(None, trees, samples.with_more(*new, self.max_samples, self._rng))

    def add(
        self,
        rows: Rows,
        is_salient: npt.NDArray[np.bool_],
        group: int | npt.NDArray[np.int32] = 0,
    ) -> None:
        """Add samples as `update` does, and regrow nothing."""
        new = self._check_samples(rows, is_salient, group)
        trees, samples = self._known
        self._known = Known(trees, samples.with_more(*new, self.max_samples, self._rng))

    def forget(self, n_oldest: int) -> None:
        """Drop the oldest samples; trees that grew from them stay until they regrow."""
        trees, samples = self._known
        self._known = Known(trees, samples.without_oldest(n_oldest))

    def regrow(self, trees: Sequence[int] | None = None) -> tuple[int, ...]:
        """Grow these trees anew from the buffer, and return them; None = those of an update.

        A forest that is untrained grows all of them, or none while there is one class only.
        """
        if trees is None:
            return self._regrow(None, *self._known)
        for index in trees:
            check_whole("trees", index, 0, self.n_trees - 1)
        return self._regrow(np.unique(np.asarray(trees, np.int64)), *self._known)

    def fit(
        self,
        rows: Rows,
        is_salient: npt.NDArray[np.bool_],
        group: int | npt.NDArray[np.int32] = 0,
    ) -> tuple[int, ...]:
        """Forget everything, then grow all trees on these samples: the off-line model.

        Of more than `max_samples` rows a uniformly random choice is kept: all are there at once,
        so that none need be kept from those that came later. `max_rows` limits no tree here:
        nothing waits for it.
        """
        new = self._check_samples(rows, is_salient, group)
        if len(rows) > self.max_samples:
            kept = np.sort(self._rng.choice(len(rows), self.max_samples, replace=False))
            new = new[0][kept], new[1][kept], new[2][kept]
        nothing = Samples.none(self.n_features)
        samples = nothing.with_more(*new, self.max_samples, self._rng)
        return self._regrow(None, (), samples, is_limited=False)

    def predict(self, rows: Rows) -> npt.NDArray[np.float32]:
        """Return the (n,) mean votes of (n, F) rows, in [0, 1]; 0 while untrained."""
        rows = self._check_rows(rows)
        total = np.zeros(len(rows), np.float32)
        for tree in self._trees:
            add_votes(tree.nodes, tree.values, tree.depth, rows, self.vote == "hard", total)
        total /= self.n_trees
        return total

    def votes(self, rows: Rows, trees: Sequence[int] | None = None) -> npt.NDArray[np.float32]:
        """Return the (n, len(trees)) votes of some trees, None = all; 0 while untrained.

        The mean of all columns is `predict`, so a fixed test set needs only the trees that
        `update` returned.
        """
        rows = self._check_rows(rows)
        chosen = range(self.n_trees) if trees is None else trees
        votes = np.zeros((len(chosen), len(rows)), np.float32)
        if grown := self._trees:
            for index, votes_of_tree in zip(chosen, votes, strict=True):
                tree = grown[index]
                is_hard = self.vote == "hard"
                add_votes(tree.nodes, tree.values, tree.depth, rows, is_hard, votes_of_tree)
        return votes.T

    def settings(self) -> dict[str, int | float | str]:
        """Return what `__init__` needs for another such forest, but seed and threads.

        What version 0.1 did not have is among them only where it is set.
        """
        settings: dict[str, int | float | str] = {
            "n_features": self.n_features,
            "n_trees": self.n_trees,
            "n_regrown": self.n_regrown,
            "share": self.share,
            "max_samples": self.max_samples,
            "max_depth": self.max_depth,
            "min_split": self.min_split,
            "n_split_features": self.n_split_features,
            "vote": self.vote,
        }
        if self.leaf_share:
            settings["leaf_share"] = self.leaf_share
        if self.n_levels != N_BINS:
            settings["n_levels"] = self.n_levels
        if self.max_rows is not None:
            settings["max_rows"] = self.max_rows
        return settings

    def another(self, *, max_samples: int, n_regrown: int) -> Forest:
        """Return an empty forest with all other settings, and the same source of chance."""
        settings = self.settings() | {"max_samples": max_samples, "n_regrown": n_regrown}
        return Forest(**settings, seed=self._rng, n_threads=self.n_threads)  # type: ignore[arg-type]

    def state_arrays(self) -> Arrays:
        """Return buffer and trees as flat arrays, see `pack_trees`; `settings` are not among them.

        With `max_rows` those of `pack_draws` are among them, too. No trees while untrained.
        """
        return self._read(self._packed)

    def _packed(self, known: Known) -> Arrays:
        trees, samples = known
        return {
            "rows": samples.rows(),
            "is_salient": samples.is_salient.copy(),
            "groups": samples.groups.copy(),
            **pack_trees(trees),
            **(pack_draws(trees) if self.max_rows is not None else {}),
        }

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state_arrays` of a forest with the same settings returned.

        Raises ValueError, and changes nothing, if the arrays do not fit this forest.
        """
        nothing = Samples.none(self.n_features)
        expected = {
            "rows": nothing.rows(),
            "is_salient": nothing.is_salient,
            "groups": nothing.groups,
            **pack_trees(()),
        }
        for name, like in expected.items():
            found = arrays.get(name, np.empty(0, np.void))
            if found.dtype != like.dtype or found.shape[1:] != like.shape[1:]:
                raise ValueError(
                    f"{name}: expected (n, *{like.shape[1:]}) {like.dtype}, "
                    f"got {found.shape} {found.dtype}"
                )
        trees = unpack_trees(arrays, self.n_features, self.max_depth)
        if len(trees) not in (0, self.n_trees):
            raise ValueError(f"tree_sizes: expected {self.n_trees} trees or 0, got {len(trees)}")
        if not len(arrays["rows"]) == len(arrays["is_salient"]) == len(arrays["groups"]):
            raise ValueError("rows, is_salient, groups: expected the same length")
        samples = Samples.of(
            np.array(arrays["rows"], np.uint8),
            np.array(arrays["is_salient"], np.bool_),
            np.array(arrays["groups"], np.int32),
        )
        self._known = Known(tuple(trees), samples)

    def _read(self, take: Callable[[Known], Result]) -> Result:
        """Return what is taken from the forest at one moment.

        Learning writes where the present samples have no rows. Only where other samples took
        their place meanwhile may theirs be overwritten: then it is taken again.
        """
        while True:
            known = self._known
            result = take(known)
            if self._known is known:
                return result

    def _check_samples(
        self, rows: Rows, is_salient: npt.NDArray[np.bool_], group: int | npt.NDArray[np.int32]
    ) -> tuple[Rows, npt.NDArray[np.bool_], Indices]:
        """Return the samples with one group each."""
        rows = self._check_rows(rows)
        if is_salient.shape != (len(rows),) or is_salient.dtype != np.bool_:
            raise ValueError(
                f"is_salient: expected ({len(rows)},) bool, "
                f"got {is_salient.shape} {is_salient.dtype}"
            )
        groups = np.asarray(group, np.int32)
        if groups.shape not in ((), (len(rows),)):
            raise ValueError(f"group: expected a number or ({len(rows)},), got {groups.shape}")
        return rows, is_salient, np.broadcast_to(groups, len(rows))

    def _regrow(
        self,
        indices: npt.NDArray[np.int64] | None,
        trees: tuple[Tree, ...],
        samples: Samples,
        *,
        is_limited: bool = True,
    ) -> tuple[int, ...]:
        """Grow these trees anew, None = some, and take them, the others and the samples over.

        is_limited: by `max_rows`. Each tree has its own seed, drawn before any thread starts.
        """
        rows = None if self.max_rows is None else samples.distinct_rows()
        bound = ALL_KEYS if rows is None else self._bound(len(rows.places), is_limited)
        if not trees:
            indices = np.arange(self.n_trees if samples.has_both() else 0)
        elif indices is None:
            indices = self._choose(trees, rows, bound)
        seeds = self._rng.integers(0, 2**64, indices.size, dtype=np.uint64).tolist()
        birth = 1 + max((tree.birth for tree in trees), default=0)
        grow = partial(self._grow, samples, rows, bound, birth)
        if self.n_threads == 1:
            grown = [grow(seed) for seed in seeds]
        else:
            with ThreadPoolExecutor(self.n_threads) as pool:
                grown = list(pool.map(grow, seeds))
        after = dict(enumerate(trees)) | dict(zip(indices.tolist(), grown, strict=True))
        self._known = Known(tuple(after[index] for index in sorted(after)), samples)
        return tuple(indices.tolist())

    def _bound(self, n_rows: int, is_limited: bool) -> int:
        """Return how many of `ALL_KEYS` a tree draws of so many rows."""
        most = n_rows if self.max_rows is None or not is_limited else self.max_rows
        return round(ALL_KEYS * min(self.share, most / max(1, n_rows)))

    def _choose(
        self, trees: tuple[Tree, ...], rows: DistinctRows | None, bound: int
    ) -> npt.NDArray[np.int64]:
        """Return the trees that an update grows anew, see `max_rows`."""
        if rows is None or self.max_rows is None:
            return self._rng.choice(self.n_trees, self.n_regrown, replace=False)
        n_drawn = bound / ALL_KEYS * len(rows.places)
        n_affordable = int(self.n_regrown * self.max_rows / max(1.0, n_drawn))
        n_regrown = min(self.n_trees, max(self.n_regrown, n_affordable))
        return np.argsort([tree.birth for tree in trees], kind="stable")[:n_regrown]

    def _grow(
        self, samples: Samples, rows: DistinctRows | None, bound: int, birth: int, seed: int
    ) -> Tree:
        """Grow one tree on what it draws: of the rows, or of the samples where there are none."""
        state, shift = np.array([seed], np.uint64), LEVELS.index(self.n_levels)
        if rows is None:
            drawn = samples.draw_samples(self.share, state)
        else:
            drawn, bound = samples.draw_rows(rows, seed, bound)
        n_drawn = len(samples.places) * (self.share if rows is None else bound / ALL_KEYS)
        nodes, values, depth = grow_tree(
            take_points(samples.table, drawn.places, shift),
            drawn.counts,
            self.max_depth,
            max(self.min_split, int(self.leaf_share * n_drawn)),
            self.n_split_features,
            shift,
            state,
        )
        return Tree(nodes.copy(), values.copy(), depth, seed, bound, birth)

    def _check_rows(self, rows: Rows) -> Rows:
        """Return `rows` in the one memory layout that the kernels are compiled for."""
        if rows.ndim != 2 or rows.shape[1] != self.n_features or rows.dtype != np.uint8:
            raise ValueError(
                f"rows: expected (n, {self.n_features}) uint8, got {rows.shape} {rows.dtype}"
            )
        return np.require(rows, requirements=["C_CONTIGUOUS", "WRITEABLE"])


def _read_only(array: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    view = array.view()
    view.flags.writeable = False
    return view
