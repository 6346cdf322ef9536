"""The on-line random forest: a buffer of labelled rows, and trees that are regrown from it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Literal, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest_kernels import FEATURE_BITS, add_votes, draw_points, grow_tree

Rows = npt.NDArray[np.uint8]
Arrays = dict[str, npt.NDArray[np.generic]]
Scalar = TypeVar("Scalar", bound=np.generic)


class Tree(NamedTuple):
    """One grown tree, in the packed form that `forest_kernels` describes."""

    nodes: npt.NDArray[np.int64]
    values: npt.NDArray[np.float32]
    depth: int


class Samples(NamedTuple):
    """The buffer: (n, F) rows, whether each is salient, and its group, oldest first."""

    rows: Rows
    is_salient: npt.NDArray[np.bool_]
    groups: npt.NDArray[np.int32]


class Known(NamedTuple):
    """What a forest has learned: its trees, none while untrained, and the buffer."""

    trees: tuple[Tree, ...]
    samples: Samples


class Forest:
    """Learn the saliency of rows of 8-bit features, a few trees at a time (sec. II-A.3).

    Every update adds labelled samples to a buffer and grows `n_regrown` random trees anew,
    each on another `share` of the buffer. Inside a tree both classes weigh the same, however
    rare one is: 0.5 means that a row is equally typical of both.

    max_samples: size of the buffer; beyond it uniformly random samples leave, new or old.
    min_split: a node of fewer samples is a leaf; so are pure nodes and those at `max_depth`.
    n_split_features: how many random features a split chooses from; None = all.
    vote: what a tree answers: `hard` = its leaf's majority, 0 or 1 (a tie is 0); `soft` = the
        salient share of its leaf.
    n_threads: trees grown at the same time; the result does not depend on it.

    A tree whose share holds one class only is a single leaf of that class.

    One thread at a time may learn; any number may predict meanwhile. `update`, `fit` and `restore`
    put their new trees and samples into place in one assignment each, so every call of
    `predict`, `votes` and `state_arrays` answers from the forest as it was before, or as it is
    after, never from a mixture.
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
        vote: Literal["hard", "soft"] = "hard",
        seed: int | np.random.Generator = 0,
        n_threads: int = 1,
    ) -> None:
        n_split_features = n_features if n_split_features is None else n_split_features
        _check_range("n_features", n_features, 1, FEATURE_BITS)
        _check_range("n_trees", n_trees, 1)
        _check_range("n_regrown", n_regrown, 1, n_trees)
        _check_range("max_samples", max_samples, 1)
        _check_range("max_depth", max_depth, 0)
        _check_range("min_split", min_split, 2)
        _check_range("n_split_features", n_split_features, 1, n_features)
        _check_range("n_threads", n_threads, 1)
        if not 0 < share <= 1:
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
        self.vote = vote
        self.n_threads = n_threads
        self._rng = np.random.default_rng(seed)
        # Never changed, only replaced: whoever reads it while another thread learns keeps his.
        self._known = Known((), self._no_samples())

    @property
    def is_trained(self) -> bool:
        """Tell whether both classes have been seen; until then every prediction is 0."""
        return bool(self._trees)

    @property
    def n_samples(self) -> int:
        return len(self._known.samples.rows)

    @property
    def rows(self) -> Rows:
        """Show the buffer's (n_samples, F) rows; like the next two, oldest first, read-only."""
        return _read_only(self._known.samples.rows)

    @property
    def is_salient(self) -> npt.NDArray[np.bool_]:
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
        are no rows. `group` is kept with the samples, one number for all or (n,).
        """
        new = self._check_samples(rows, is_salient, group)
        if len(rows) == 0:
            return ()
        trees, samples = self._known.trees, self._added(self._known.samples, new)
        indices = self._all_if_both(samples)
        if trees:
            indices = self._rng.choice(self.n_trees, self.n_regrown, replace=False)
        return self._regrow(indices, trees, samples)

    def fit(
        self,
        rows: Rows,
        is_salient: npt.NDArray[np.bool_],
        group: int | npt.NDArray[np.int32] = 0,
    ) -> tuple[int, ...]:
        """Forget everything, then grow all trees on these samples: the off-line model.

        Of more than `max_samples` rows a uniformly random choice is kept.
        """
        new = self._check_samples(rows, is_salient, group)
        samples = self._added(self._no_samples(), new)
        return self._regrow(self._all_if_both(samples), (), samples)

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
        """Return what `__init__` needs for another such forest, but seed and threads."""
        return {
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

    def another(self, *, max_samples: int, n_regrown: int) -> Forest:
        """Return an empty forest with all other settings, and the same source of chance."""
        settings = self.settings() | {"max_samples": max_samples, "n_regrown": n_regrown}
        return Forest(**settings, seed=self._rng, n_threads=self.n_threads)  # type: ignore[arg-type]

    def state_arrays(self) -> Arrays:
        """Return buffer and trees as flat arrays; `settings` are not among them.

        The nodes of all trees follow each other; `tree_sizes` (n_trees,) says how many each
        has, 0 trees while untrained. A node's right child follows its left child.
        """
        trees, samples = self._known
        nodes = np.concatenate([np.empty(0, np.int64), *(tree.nodes for tree in trees)])
        values = np.concatenate([np.empty(0, np.float32), *(tree.values for tree in trees)])
        return {
            "rows": samples.rows.copy(),
            "is_salient": samples.is_salient.copy(),
            "groups": samples.groups.copy(),
            "tree_sizes": np.array([tree.nodes.size for tree in trees], np.int32),
            "tree_depths": np.array([tree.depth for tree in trees], np.int32),
            "node_features": (nodes >> 8 & FEATURE_BITS).astype(np.uint16),
            "node_thresholds": (nodes & 255).astype(np.uint8),
            "node_left_children": (nodes >> 24).astype(np.int32),
            "node_values": values,
        }

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state_arrays` of a forest with the same settings returned.

        Raises ValueError, and changes nothing, if the arrays do not fit this forest.
        """
        for name, like in self.state_arrays().items():
            found = arrays.get(name, np.empty(0, np.void))
            if found.dtype != like.dtype or found.shape[1:] != like.shape[1:]:
                raise ValueError(
                    f"{name}: expected (n, *{like.shape[1:]}) {like.dtype}, "
                    f"got {found.shape} {found.dtype}"
                )
        trees = _unpack_trees(arrays, self.n_features)
        if len(trees) not in (0, self.n_trees):
            raise ValueError(f"tree_sizes: expected {self.n_trees} trees or 0, got {len(trees)}")
        if not len(arrays["rows"]) == len(arrays["is_salient"]) == len(arrays["groups"]):
            raise ValueError("rows, is_salient, groups: expected the same length")
        samples = Samples(
            np.array(arrays["rows"], np.uint8),
            np.array(arrays["is_salient"], np.bool_),
            np.array(arrays["groups"], np.int32),
        )
        self._known = Known(tuple(trees), samples)

    def _no_samples(self) -> Samples:
        rows = np.empty((0, self.n_features), np.uint8)
        return Samples(rows, np.empty(0, np.bool_), np.empty(0, np.int32))

    def _check_samples(
        self, rows: Rows, is_salient: npt.NDArray[np.bool_], group: int | npt.NDArray[np.int32]
    ) -> Samples:
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
        return Samples(rows, is_salient, np.broadcast_to(groups, len(rows)))

    def _added(self, kept: Samples, new: Samples) -> Samples:
        """Return the buffer with more samples behind, and with what is too much evicted."""
        # Equal rows side by side: `draw_points` merges them, so superpixels grow trees faster.
        order = np.argsort(new.rows.view((np.void, self.n_features)).ravel(), kind="stable")
        samples = Samples(
            np.concatenate([kept.rows, new.rows[order]]),
            np.concatenate([kept.is_salient, new.is_salient[order]]),
            np.concatenate([kept.groups, new.groups[order]]),
        )
        n_samples = len(samples.rows)
        n_evicted = n_samples - self.max_samples
        if n_evicted <= 0:
            return samples
        is_kept = np.ones(n_samples, np.bool_)
        is_kept[self._rng.choice(n_samples, n_evicted, replace=False)] = False
        rows, is_salient, groups = samples
        return Samples(rows[is_kept], is_salient[is_kept], groups[is_kept])

    def _all_if_both(self, samples: Samples) -> npt.NDArray[np.int64]:
        """Return every tree's index, or none while the buffer holds one class only."""
        has_both = samples.is_salient.any() and not samples.is_salient.all()
        return np.arange(self.n_trees if has_both else 0)

    def _regrow(
        self, indices: npt.NDArray[np.int64], trees: tuple[Tree, ...], samples: Samples
    ) -> tuple[int, ...]:
        """Grow these trees anew, and take them, the other trees and the samples over.

        Each tree has its own seed, drawn before any thread starts.
        """
        seeds = self._rng.integers(0, 2**64, indices.size, dtype=np.uint64)
        if self.n_threads == 1:
            grown = [self._grow(samples, seed) for seed in seeds]
        else:
            with ThreadPoolExecutor(self.n_threads) as pool:
                grown = list(pool.map(partial(self._grow, samples), seeds))
        after = dict(enumerate(trees)) | dict(zip(indices.tolist(), grown, strict=True))
        self._known = Known(tuple(after[index] for index in sorted(after)), samples)
        return tuple(indices.tolist())

    def _grow(self, samples: Samples, seed: np.uint64) -> Tree:
        """Grow one tree on a new share of the samples."""
        state = np.array([seed], np.uint64)
        n_drawn = max(1, round(self.share * len(samples.rows)))
        points, counts = draw_points(samples.rows, samples.is_salient, n_drawn, state)
        nodes, values, depth = grow_tree(
            points, counts, self.max_depth, self.min_split, self.n_split_features, state
        )
        return Tree(nodes.copy(), values.copy(), depth)

    def _check_rows(self, rows: Rows) -> Rows:
        """Return `rows` in the one memory layout that the kernels are compiled for."""
        if rows.ndim != 2 or rows.shape[1] != self.n_features or rows.dtype != np.uint8:
            raise ValueError(
                f"rows: expected (n, {self.n_features}) uint8, got {rows.shape} {rows.dtype}"
            )
        return np.require(rows, requirements=["C_CONTIGUOUS", "WRITEABLE"])


def _unpack_trees(arrays: Arrays, n_features: int) -> list[Tree]:
    """Build the trees of `state_arrays`; ValueError where a walk would leave its tree."""
    sizes = arrays["tree_sizes"].astype(np.int64)
    features = arrays["node_features"].astype(np.int64)
    thresholds = arrays["node_thresholds"].astype(np.int64)
    left = arrays["node_left_children"].astype(np.int64)
    values = arrays["node_values"].astype(np.float32)
    n_nodes = int(sizes.sum())
    lengths = {n_nodes, features.size, thresholds.size, left.size, values.size}
    if len(lengths) > 1 or sizes.size != arrays["tree_depths"].size or (sizes < 1).any():
        raise ValueError(f"tree_sizes: expected sizes of trees with {left.size} nodes in all")
    starts = np.cumsum(sizes) - sizes
    place = np.arange(n_nodes) - np.repeat(starts, sizes)
    is_leaf = (left == place) & (thresholds == 255)
    is_split = (left > place) & (left + 1 < np.repeat(sizes, sizes))
    if not (is_leaf | is_split).all() or (features >= n_features).any():
        raise ValueError(f"node_left_children: expected trees over {n_features} features")
    nodes = left << 24 | features << 8 | thresholds
    return [
        Tree(nodes[start : start + size].copy(), values[start : start + size].copy(), int(depth))
        for start, size, depth in zip(starts, sizes, arrays["tree_depths"], strict=True)
    ]


def _check_range(name: str, value: int, low: int, high: float = float("inf")) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name}: expected {low} to {high}, got {value}")


def _read_only(array: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    view = array.view()
    view.flags.writeable = False
    return view
