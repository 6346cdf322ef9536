"""The navigation graph of regions: what the authors' program knows of the ways between them.

Their unit of time is what a look takes, so a second here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.datasets.layouts.rl_iac_tables import GraphNode
from curiosight.explorer.ground import LOOK_SECONDS
from curiosight.frame import Viewpoint
from curiosight.frame.assignment import best_pairs

Floats = npt.NDArray[np.float64]

# The actions of a region, by where they lead on the map: up, down, left, right.
_DIRECTIONS = np.array([[0.0, 1.0], [0.0, -1.0], [-1.0, 0.0], [1.0, 0.0]])
N_MOVES = len(_DIRECTIONS)


def shortest_seconds(nodes: Sequence[GraphNode]) -> Floats:
    """Return (n, n) seconds of the shortest ways from region to region; inf = no way leads there.

    On the diagonal how long it takes to stay and look from another view: the shortest action
    that leads nowhere else; 0 where there is none.
    """
    n_regions = len(nodes)
    seconds = np.full((n_regions, n_regions), np.inf)
    for region, node in enumerate(nodes):
        for neighbour, duration in zip(node.neighbours, node.durations, strict=True):
            seconds[region, neighbour] = min(seconds[region, neighbour], duration)
    staying = np.diag(seconds).copy()
    np.fill_diagonal(seconds, 0.0)
    for middle in range(n_regions):
        through = seconds[:, middle, None] + seconds[middle]
        seconds = np.minimum(seconds, through)
    np.fill_diagonal(seconds, np.where(np.isinf(staying), 0.0, staying))
    return seconds * LOOK_SECONDS


class RegionWays:
    """The seconds between viewpoints where only those between their regions are known.

    seconds: (n_regions, n_regions), on the diagonal from one view to another.
    """

    def __init__(self, seconds: Floats) -> None:
        self._seconds = seconds

    def __call__(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
        """Return the (n,) seconds to viewpoints; 0 from or to one that is in no region."""
        regions = np.array([goal.region for goal in goals], np.int64)
        is_known = (regions >= 0) & [goal.index != start.index for goal in goals]
        if start.region < 0:
            return np.zeros(len(goals))
        known: Floats = np.where(is_known, self._seconds[start.region, regions], 0.0)
        return known


def make_graph(between: Floats, inside: Floats, places: Floats) -> tuple[GraphNode, ...]:
    """Return a navigation graph of regions, with up to four ways from each, both ways alike.

    The shortest ways come first, but every region can be reached. Durations are whole seconds,
    1 at least. Which of a region's ways is up, down, left or right its place tells.

    between: (n, n) seconds from region to region. inside: (n,) from a view to the next in it.
    places: (n, 2) of the regions on the map, y up.
    """
    both = (between + between.T) / 2
    linked = _link(both)
    nodes = []
    for region in range(len(both)):
        neighbours = np.full(N_MOVES + 1, region)
        to = np.flatnonzero(linked[region])
        towards = places[to] - places[region]
        towards /= np.maximum(np.linalg.norm(towards, axis=1), 1e-9)[:, None]
        chosen, moves = best_pairs(towards @ _DIRECTIONS.T)
        neighbours[moves] = to[chosen]
        seconds = np.where(neighbours == region, inside[region], both[region, neighbours])
        durations = np.maximum(np.rint(seconds / LOOK_SECONDS), 1).astype(int)
        nodes.append(GraphNode(tuple(neighbours.tolist()), tuple(durations.tolist())))
    return tuple(nodes)


def _link(seconds: Floats) -> npt.NDArray[np.bool_]:
    """Return (n, n) which regions are linked: none by more than four ways, all of them together.

    Shortest first, those that join what is not joined yet; then what else there is room for.
    A group that is joined as a tree always has room, so that nothing stays apart.
    """
    n_regions = len(seconds)
    pairs = np.argwhere(np.triu(np.ones((n_regions, n_regions), dtype=bool), 1))
    order = pairs[np.argsort(seconds[pairs[:, 0], pairs[:, 1]], kind="stable")]
    linked = np.zeros((n_regions, n_regions), dtype=bool)
    group = np.arange(n_regions)
    for joins in (True, False):
        for a, b in order:
            has_room = max(linked[a].sum(), linked[b].sum()) < N_MOVES
            if has_room and not linked[a, b] and not (joins and group[a] == group[b]):
                linked[a, b] = linked[b, a] = True
                group[group == group[b]] = group[a]
    return linked
