"""The places of two models as those of one: matched by poses, or by what they look like."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.learner.looks import Looks
from curiosight.learner.places import MAX_LOOKS, MAX_LOOKS_PER_SPOT, NOWHERE, Places

Array = npt.NDArray[Any]
Numbers = npt.NDArray[np.int64]

# Views of one place look like another of it by this much on average; of two places, by less.
MIN_ALIKE = 0.77
# If at least so many views look like one of the other model, and most of these were taken farther
# than this from it, in cells, the two have poses in two worlds.
MIN_TELLING, FAR = 3, 12.0


def join_places(one: Places, other: Places) -> tuple[Places, Numbers]:
    """Return the places of both, and (n,) the spots that the other's spots are in it.

    The poses of both count where they are of one world; else the other's places are known by
    their looks alone.
    """
    mine, theirs = _Known(one.state_arrays()), _Known(other.state_arrays())
    if theirs.has_poses and mine.has_poses and not _are_of_one_world(mine, theirs):
        theirs.forget_poses()
    spots = mine.take_in(theirs)
    places = Places(**one.settings())
    places.restore(mine.arrays())
    places.tell_apart()
    places.place_of_spot = _joined_by_looks(places.place_of_spot, mine)
    return places, spots


class _Known:
    """What is known of places, spot by spot: see `Places.state_arrays`."""

    def __init__(self, arrays: dict[str, Array]) -> None:
        # Copies: the places that they are of stay as they are.
        known = {name.removeprefix("places_"): array.copy() for name, array in arrays.items()}
        self.axes: Array = known["axes"]
        self.cells = [(int(x), int(y)) for x, y in known["cells"]]
        self.place_of_spot: Numbers = known["of_spot"]
        self.cell_of_spot: Numbers = known["cell_of_spot"]
        self.views: Numbers = known["views"]
        self.sees = np.split(known["seen"], np.cumsum(known["n_seen"])[:-1])[: len(self.views)]
        self.looks: npt.NDArray[np.uint8] = known["looks"]
        self.spot_of_look: Numbers = known["spot_of_look"]

    @property
    def has_poses(self) -> bool:
        return len(self.axes) > 0

    def forget_poses(self) -> None:
        """Know places by what they look like alone."""
        self.axes, self.cells = np.empty((0, 3)), []
        self.cell_of_spot = np.full(len(self.views), NOWHERE)
        self.sees = [np.empty(0, np.int64) for _ in self.sees]

    def cells_along(self, axes: Array) -> list[tuple[int, int]]:
        """Return its cells in the grid of other axes, see `ground_axes`."""
        middles = np.array(self.cells, float).reshape(-1, 2) + 0.5
        turned = np.floor(middles @ (axes @ self.axes.T).T) if len(self.cells) else middles
        return [(int(x), int(y)) for x, y in turned]

    def take_in(self, other: _Known) -> Numbers:
        """Add what another knows, and return the spots that its spots are here."""
        if not self.has_poses:
            self.axes = other.axes
        number_of = {cell: number for number, cell in enumerate(self.cells)}
        theirs = other.cells_along(self.axes)
        cells = np.array([number_of.setdefault(cell, len(number_of)) for cell in theirs], np.int64)
        self.cells = list(number_of)
        spot_in = {int(c): s for s, c in enumerate(self.cell_of_spot) if c != NOWHERE}
        spots = np.empty(len(other.views), np.int64)
        for spot, cell in enumerate(other.cell_of_spot.tolist()):
            cell = NOWHERE if cell == NOWHERE else int(cells[cell])
            spots[spot] = spot_in.get(cell, len(self.views))
            if spots[spot] == len(self.views):
                self._add_spot(cell)
            here = int(spots[spot])
            self.views[here] += other.views[spot]
            self.sees[here] = np.union1d(self.sees[here], cells[other.sees[spot]])
        self._add_looks(other.looks, spots[other.spot_of_look])
        return spots

    def _add_spot(self, cell: int) -> None:
        self.place_of_spot = np.append(self.place_of_spot, NOWHERE)
        self.cell_of_spot = np.append(self.cell_of_spot, cell)
        self.views = np.append(self.views, 0)
        self.sees.append(np.empty(0, np.int64))

    def _add_looks(self, looks: Array, spot_of_look: Numbers) -> None:
        """Keep the looks of both, of each spot the first ones of both."""
        every = np.concatenate([self.spot_of_look, spot_of_look])
        ranks = np.concatenate([_ranks(self.spot_of_look), _ranks(spot_of_look)])
        order = np.argsort(ranks, kind="stable")
        order = order[_ranks(every[order]) < MAX_LOOKS_PER_SPOT][:MAX_LOOKS]
        self.looks = np.concatenate([self.looks, looks])[order]
        self.spot_of_look = every[order]

    def arrays(self) -> dict[str, Array]:
        """Return them as `Places.restore` takes them."""
        known = {
            "axes": self.axes,
            "cells": np.array(self.cells, np.int32).reshape(-1, 2),
            "of_spot": self.place_of_spot,
            "cell_of_spot": self.cell_of_spot,
            "views": self.views,
            "seen": np.concatenate([np.empty(0, np.int64), *self.sees]),
            "n_seen": np.array([len(cells) for cells in self.sees], np.int64),
            "looks": self.looks,
            "spot_of_look": self.spot_of_look,
            "clustered": np.array(len(self.views)),
        }
        return {f"places_{name}": array for name, array in known.items()}


def _ranks(spots: Numbers) -> Numbers:
    """Return (n,) how many before each are of the same spot."""
    seen: dict[int, int] = {}
    ranks = np.empty(len(spots), np.int64)
    for i, spot in enumerate(spots.tolist()):
        ranks[i] = seen.get(spot, 0)
        seen[spot] = ranks[i] + 1
    return ranks


def _are_of_one_world(mine: _Known, theirs: _Known) -> bool:
    """Tell whether views that look alike were taken from about the same place."""
    looks, n_alike, n_far = Looks(mine.looks), 0, 0
    their_cells = theirs.cells_along(mine.axes)
    for look, spot in zip(theirs.looks, theirs.spot_of_look, strict=True):
        alike = looks.likeness(look)
        cell = theirs.cell_of_spot[spot]
        if cell == NOWHERE or not len(alike) or alike.max() < MIN_ALIKE:
            continue
        its_cell = mine.cell_of_spot[mine.spot_of_look[int(alike.argmax())]]
        if its_cell != NOWHERE:
            n_alike += 1
            away = np.subtract(their_cells[cell], mine.cells[its_cell])
            n_far += bool(np.hypot(*away) > FAR)
    return n_alike < MIN_TELLING or 2 * n_far <= n_alike


def _joined_by_looks(place_of_spot: Numbers, known: _Known) -> Numbers:
    """Return places of which those without poses are one with the one that they look like."""
    is_posed = known.cell_of_spot != NOWHERE
    posed = np.unique(place_of_spot[is_posed])
    joined = place_of_spot.copy()
    place_of_look, looks = place_of_spot[known.spot_of_look], Looks(known.looks)
    for place in np.setdiff1d(place_of_spot, posed):
        shown = np.flatnonzero(place_of_look == place)
        if not len(shown) or not len(posed):
            continue
        alike = np.stack([looks.likeness(looks[int(i)]) for i in shown])
        best = [
            np.mean(alike[:, place_of_look == other].max(axis=1, initial=0.0)) for other in posed
        ]
        if max(best) >= MIN_ALIKE:
            joined[place_of_spot == place] = posed[int(np.argmax(best))]
    _, dense = np.unique(joined, return_inverse=True)
    return dense.astype(np.int64)
