"""The forest's trees as flat arrays, as they stand in a model file, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest_draws import ALL_KEYS
from curiosight.learner.forest_kernels import FEATURE_BITS

Numbers = npt.NDArray[Any]
Arrays = dict[str, npt.NDArray[np.generic]]


class Tree(NamedTuple):
    """One grown tree, in the packed form that `forest_kernels` describes.

    seed, bound: which rows it drew, see `is_drawn`; a bound of `ALL_KEYS`: all, or none knows.
    birth: the turn in which it grew; the larger the later.
    """

    nodes: npt.NDArray[np.int64]
    values: npt.NDArray[np.float32]
    depth: int
    seed: int = 0
    bound: int = ALL_KEYS
    birth: int = 0


def pack_trees(trees: Sequence[Tree]) -> Arrays:
    """Return nodes one tree after the other; `tree_sizes` (T,) says how many each has.

    A node's right child follows its left child.
    """
    nodes = np.concatenate([np.empty(0, np.int64), *(tree.nodes for tree in trees)])
    values = np.concatenate([np.empty(0, np.float32), *(tree.values for tree in trees)])
    return {
        "tree_sizes": np.array([tree.nodes.size for tree in trees], np.int32),
        "tree_depths": np.array([tree.depth for tree in trees], np.int32),
        "node_features": (nodes >> 8 & FEATURE_BITS).astype(np.uint16),
        "node_thresholds": (nodes & 255).astype(np.uint8),
        "node_left_children": (nodes >> 24).astype(np.int32),
        "node_values": values,
    }


def pack_draws(trees: Sequence[Tree]) -> Arrays:
    """Return what each of (T,) trees drew, and when it grew."""
    return {
        "tree_seeds": np.array([tree.seed for tree in trees], np.uint64),
        "tree_bounds": np.array([tree.bound for tree in trees], np.uint64),
        "tree_births": np.array([tree.birth for tree in trees], np.int64),
    }


def unpack_trees(arrays: Arrays, n_features: int, max_depth: int) -> list[Tree]:
    """Build the trees again; ValueError where a walk would leave its tree or end inside it.

    Without the arrays of `pack_draws` it is not known which rows the trees drew.
    """
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
    if not ((values >= 0) & (values <= 1)).all():  # what is NaN compares false
        raise ValueError("node_values: expected shares from 0 to 1")
    nodes = left << 24 | features << 8 | thresholds
    _check_depths(arrays["tree_depths"], starts, left + starts.repeat(sizes), is_split, max_depth)
    depths, draws = arrays["tree_depths"], _unpack_draws(arrays, sizes.size)
    return [
        Tree(nodes[start : start + size].copy(), values[start : start + size].copy(), *rest)
        for start, size, *rest in zip(starts, sizes, depths.tolist(), *draws, strict=True)
    ]


def _check_depths(
    depths: Numbers, starts: Numbers, left: Numbers, is_split: Numbers, max_depth: int
) -> None:
    """Raise ValueError where a tree's depth is not that of its deepest leaf, or not allowed.

    starts: (T,) places of the roots among all nodes. left: (n,) those of left children.
    """
    n_levels = np.zeros(len(starts), np.int64)
    here, tree = starts, np.arange(len(starts))
    for level in range(1, max_depth + 2):
        goes_on = is_split[here]
        here, tree = left[here[goes_on]], tree[goes_on]
        if not len(here):
            break
        n_levels[tree] = level
        # A node with two parents is looked at once.
        here, first = np.unique(np.concatenate([here, here + 1]), return_index=True)
        tree = np.tile(tree, 2)[first]
    if (n_levels > max_depth).any() or (depths != n_levels).any():
        raise ValueError(f"tree_depths: expected those of the trees, {max_depth} at most")


def _unpack_draws(arrays: Arrays, n_trees: int) -> list[list[Any]]:
    """Return seeds, bounds and births of the trees."""
    without = Tree(np.empty(0, np.int64), np.empty(0, np.float32), 0)
    draws = []
    for name, like in pack_draws([without] * n_trees).items():
        found = arrays.get(name, like)
        if found.shape != like.shape or found.dtype != like.dtype:
            raise ValueError(
                f"{name}: expected {like.shape} {like.dtype}, got {found.shape} {found.dtype}"
            )
        draws.append(found.tolist())
    if max(draws[1], default=0) > ALL_KEYS:
        raise ValueError(f"tree_bounds: expected 0 to {ALL_KEYS}, got {max(draws[1])}")
    return draws
