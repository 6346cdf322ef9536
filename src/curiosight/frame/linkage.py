"""Groups of what is near, by the mean distance between them (hierarchical clustering)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class AverageLinkage:
    """The tree in which those groups are joined first whose members are nearest on average.

    distances: (n, n) symmetric, n at least 2; what stands on the diagonal does not matter.
    """

    def __init__(self, distances: npt.ArrayLike) -> None:
        matrix = np.array(distances, np.float64)
        n = len(matrix)
        if n < 2 or matrix.shape != (n, n):
            raise ValueError(f"distances: expected (n, n), n at least 2, got {matrix.shape}")
        joined, heights = _nearest_neighbour_chain(matrix)
        order = np.argsort(heights, kind="stable")
        self._n, self._heights = n, heights[order]
        self._children = _as_tree(joined[order], n)

    def within(self, height: float) -> Ints:
        """Return the (n,) group of each, from 0: those joined at a mean distance of at most so."""
        return self._number(self._heights <= height)

    def at_most(self, n_groups: int) -> Ints:
        """Return the (n,) group of each, from 0: the fewest joined that leave so many groups."""
        n_joined = max(0, self._n - n_groups)
        if n_joined == 0:
            return self._number(np.zeros(self._n - 1, np.bool_))
        # What is joined at the same height is joined together.
        return self._number(self._heights <= self._heights[n_joined - 1])

    def _number(self, is_joined: npt.NDArray[np.bool_]) -> Ints:
        """Number the groups from the root on: of a join first what was joined, then single ones."""
        group, n_groups = np.empty(self._n, np.int64), 0
        waiting = [(2 * self._n - 2, -1)]  # a node, and the group that it is in, -1 = none yet
        while waiting:
            node, number = waiting.pop()
            if number < 0 and (node < self._n or is_joined[node - self._n]):
                number, n_groups = n_groups, n_groups + 1
            if node < self._n:
                group[node] = number
            else:
                below = self._children[node - self._n]
                single = [child for child in below if child < self._n]
                inner = [child for child in below if child >= self._n]
                # The last is taken first.
                waiting += [(child, number) for child in (*single[::-1], *inner[::-1])]
        return group


def _nearest_neighbour_chain(matrix: Floats) -> tuple[Ints, Floats]:
    """Return which (n - 1, 2) rows are joined, and at what height, in no order of heights.

    Groups that are each other's nearest can be joined at once, whatever becomes of the others.
    The second row of a pair goes on as the two; matrix is used up.
    """
    n = len(matrix)
    np.fill_diagonal(matrix, np.inf)
    sizes = np.ones(n)
    joined, heights = np.empty((n - 1, 2), np.int64), np.empty(n - 1)
    chain: list[int] = []
    for step in range(n - 1):
        if not chain:
            chain.append(int(np.argmax(sizes > 0)))
        while True:
            here = chain[-1]
            row = matrix[here]
            # Of equally near ones the one before in the chain, that it may end.
            near = chain[-2] if len(chain) > 1 else here
            least = int(row.argmin())
            if row[least] < row[near]:
                near = least
            if len(chain) > 1 and near == chain[-2]:
                break
            chain.append(near)
        one, other = sorted((chain.pop(), chain.pop()))
        joined[step], heights[step] = (one, other), matrix[one, other]
        mean = (sizes[one] * matrix[one] + sizes[other] * matrix[other]) / (
            sizes[one] + sizes[other]
        )
        mean[other] = np.inf
        matrix[other], matrix[:, other] = mean, mean
        matrix[one], matrix[:, one] = np.inf, np.inf
        sizes[other] += sizes[one]
        sizes[one] = 0
    return joined, heights


def _as_tree(joined: Ints, n: int) -> list[tuple[int, int]]:
    """Return the two nodes below each join, in order: 0 to n - 1 leaves, then earlier joins."""
    above = list(range(2 * n - 1))

    def root(node: int) -> int:
        while above[node] != node:
            above[node] = above[above[node]]
            node = above[node]
        return node

    children = []
    for place, (one, other) in enumerate(joined.tolist()):
        left, right = sorted((root(one), root(other)))
        above[left] = above[right] = n + place
        children.append((left, right))
    return children
