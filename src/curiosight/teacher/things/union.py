"""Sets of nodes that grow by one link at a time (union-find)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]


@njit(cache=True, nogil=True, error_model="numpy")
def join_nodes(parent: Array, one: int, other: int) -> None:
    """Join the sets of two nodes."""
    parent[root_of(parent, one)] = root_of(parent, other)


@njit(cache=True, nogil=True, error_model="numpy")
def join_linked(links: Array, parent: Array) -> None:
    """Join the nodes that an (n, n) bool graph links."""
    for one in range(len(links)):
        for other in range(len(links)):
            if links[one, other]:
                join_nodes(parent, one, other)


@njit(cache=True, nogil=True, error_model="numpy")
def root_of(parent: Array, node: int) -> int:
    """Return the root of a node's tree, and halve the way to it for the next time."""
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = parent[node]
    return node


@njit(cache=True, nogil=True, error_model="numpy")
def number_sets(parent: Array) -> Array:
    """Return the (n,) number of each node's set, in the order of their first nodes.

    parent: (n,) the node that each was joined to; in the beginning each is its own. Ways to a
        root are shortened, the sets stay.
    """
    number, n_roots = np.full(len(parent), -1), 0
    for node in range(len(parent)):
        root = root_of(parent, node)
        if number[root] < 0:
            number[root] = n_roots
            n_roots += 1
        number[node] = number[root]
    return number
