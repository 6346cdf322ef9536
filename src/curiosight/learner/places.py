"""The places of a home: which views are of one place, and which place a view is of.

Nobody tells where a room ends. Two spots are of one place if who stands in one sees the other, or
if both see the same floor; a door lets little through. Where there are no poses, views are of one
place that look like the same others.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.arguments import check_whole
from curiosight.frame import Pose
from curiosight.frame.level import ground_axes
from curiosight.learner.linking import join_linked, keep_numbers, seen_by_each_other, shared_likes
from curiosight.learner.looks import LOOK_SIZE, Look, Looks
from curiosight.learner.sight import Cells, Sight, cell_of

Array = npt.NDArray[Any]
Arrays = Mapping[str, npt.NDArray[np.generic]]
Weights = npt.NDArray[np.float32]
Numbers = npt.NDArray[np.int64]

NOWHERE = -1
# Two groups of spots are two places if on average less than this share of one is seen from the
# other: in a room more than a half is, through a door a twentieth. And of views without a
# pose, if they share fewer of those most like them.
MIN_SEEN, MIN_SHARED = 0.25, 0.03
# Places are told apart anew when there are so many more spots.
GROWTH = 1.1
# A camera stands at a known spot if that is no farther, in cells.
MAX_CELLS = 2.0
# By how much less alike a look is e times less likely; what a pose leaves to the looks.
LOOK_SCALE, POSE_DOUBT = 0.01, 0.02
# A view without a pose that is as alike as this to another shows no new spot.
SAME_LOOK = 0.98
MAX_LOOKS, MAX_LOOKS_PER_SPOT = 1_000, 4
MAX_PLACES = 10_000
# 500 square metres that a camera stood on; beyond, a view is of the spot nearest to it.
MAX_SPOTS = 2_000


class Places:
    """Learn the places of a home from its views, and tell which one a view is of.

    max_places: no more are told apart; those that see each other most are one.

    A *spot* is half a metre square, seen from above, where a camera stood; without poses it is a
    view. `place_of_spot` (n_spots,) changes as more is seen; a place keeps the number that most
    of its views had.
    """

    def __init__(self, max_places: int = 16) -> None:
        check_whole("max_places", max_places, 1, MAX_PLACES)
        self.max_places = max_places
        self.place_of_spot: Numbers = np.empty(0, np.int64)
        self._axes: Array | None = None
        self._cell_numbers: dict[tuple[int, int], int] = {}
        # Of each spot: number of its cell, NOWHERE without a pose; the cell; cells seen; views.
        self._cell_of_spot: Numbers = np.empty(0, np.int64)
        self._xy_of_spot: Numbers = np.empty((0, 2), np.int64)
        self._sees: list[npt.NDArray[np.int64]] = []
        self._n_views: Numbers = np.empty(0, np.int64)
        self._looks = Looks()
        self._spot_of_look: Numbers = np.empty(0, np.int64)
        self._n_clustered = 0
        # The view that was located last, and its weights; until more is known.
        self._located: tuple[tuple[bytes | None, bytes], Weights] | None = None

    @property
    def n_places(self) -> int:
        return int(self.place_of_spot.max(initial=NOWHERE)) + 1

    @property
    def n_views(self) -> Numbers:
        """(n_places,) views that each place is known from."""
        return np.bincount(self.place_of_spot, self._n_views, self.n_places).astype(np.int64)

    def is_known(self, spot: int) -> bool:
        """Tell whether more than one view was taken from a spot; never where none was told."""
        return spot < len(self._n_views) and bool(self._n_views[spot] > 1)

    def add(self, sight: Sight) -> int:
        """Take in a view, and return its spot.

        Which way is up in the world the first view with a pose says, by the top of its image if
        it is not told.
        """
        self._located = None
        pose, look = sight.T_world_camera, sight.look
        if pose is None:
            spot = self._spot_that_looks_like(look)
        else:
            if self._axes is None:
                self._axes = ground_axes(-pose[:3, 1] if sight.up is None else sight.up)
            cell = cell_of(pose, self._axes)
            spot = self._spot_in(cell)
            if self._cell_of_spot[spot] == self._cell_numbers.get(cell):
                self._note_seen(spot, sight.cells(self._axes))
        self._n_views[spot] += 1
        self._note_look(spot, look)
        if self.place_of_spot[spot] == NOWHERE:
            self._place(spot, pose, look)
        return spot

    def locate(self, T_world_camera: Pose | None, look: Look) -> Weights:
        """Return (n_places,) how likely a view is of each place; together 1.

        A pose decides unless the look contradicts it strongly: a pose may be told in another
        world. All 0 where nothing is known.
        """
        asked = (None if T_world_camera is None else T_world_camera.tobytes(), look.tobytes())
        located = self._located
        if located is None or located[0] != asked:
            located = self._located = asked, self._weigh(T_world_camera, look)
        return located[1].copy()

    def _weigh(self, T_world_camera: Pose | None, look: Look) -> Weights:
        by_look = self._by_look(look)
        known = self._by_pose(T_world_camera)
        if known is None or not by_look.any():
            return by_look
        weights = (known + POSE_DOUBT) * by_look
        weights /= weights.sum()
        return weights

    def _by_look(self, look: Look) -> Weights:
        """Return the weights by the look alone: by the most alike look of each place."""
        best = np.full(self.n_places, -np.inf)
        place_of_look = self.place_of_spot[self._spot_of_look]
        is_placed = place_of_look != NOWHERE
        if not is_placed.any():
            return np.zeros(self.n_places, np.float32)
        alike = self._looks.likeness(look)[is_placed]
        np.maximum.at(best, place_of_look[is_placed], alike)
        weights = np.exp((best - best.max()) / LOOK_SCALE)
        likely: Weights = (weights / weights.sum()).astype(np.float32)
        return likely

    def _by_pose(self, T_world_camera: Pose | None) -> Weights | None:
        """Return the share of each place's spots that see where a camera stands, 1 in all.

        None without a pose, and where no spot sees it and none is near.
        """
        if T_world_camera is None or self._axes is None:
            return None
        cell = cell_of(T_world_camera, self._axes)
        number = self._cell_numbers.get(cell)
        placed = np.flatnonzero(self.place_of_spot != NOWHERE)
        here = placed[self._cell_of_spot[placed] == number] if number is not None else placed[:0]
        if not len(here) and number is not None:
            here = placed[np.isin(placed, self._seeing(number))]
        if not len(here):
            here = self._near(cell, placed)
        if not len(here):
            return None
        n_spots = np.bincount(self.place_of_spot[placed], minlength=self.n_places)
        n_here = np.bincount(self.place_of_spot[here], minlength=self.n_places)
        weights: Weights = (n_here / np.maximum(n_spots, 1)).astype(np.float32)
        weights /= weights.sum()
        return weights

    def _near(self, cell: tuple[int, int], spots: Numbers) -> Numbers:
        """Return those of some spots that are closest to a cell, and no farther than counts."""
        posed: Numbers = spots[self._cell_of_spot[spots] != NOWHERE]
        if not len(posed):
            return posed
        distance = self._distances(cell, posed)
        near: Numbers = posed[distance <= min(distance.min(), MAX_CELLS)]
        return near

    def _spot_in(self, cell: tuple[int, int]) -> int:
        number = self._cell_numbers.get(cell, NOWHERE)
        found = np.flatnonzero(self._cell_of_spot == number)
        if number != NOWHERE and len(found):
            return int(found[0])
        if len(self._sees) >= MAX_SPOTS:
            return self._nearest(cell)
        return self._new_spot(self._cell_numbers.setdefault(cell, len(self._cell_numbers)), cell)

    def _nearest(self, cell: tuple[int, int]) -> int:
        """Return the spot nearest to a cell; some spot where none has a pose."""
        posed = np.flatnonzero(self._cell_of_spot != NOWHERE)
        if not len(posed):
            return 0
        return int(posed[self._distances(cell, posed).argmin()])

    def _distances(self, cell: tuple[int, int], posed: Numbers) -> Array:
        """Return (n,) how far some spots with a pose are from a cell, in cells."""
        return np.hypot(*(self._xy_of_spot[posed] - cell).T)  # type: ignore[no-any-return]

    def _seeing(self, number: int) -> Numbers:
        """Return the spots that a cell is seen from."""
        seen = np.concatenate([np.empty(0, np.int64), *self._sees])
        ends = np.cumsum([len(cells) for cells in self._sees])
        spots: Numbers = np.unique(np.searchsorted(ends, np.flatnonzero(seen == number), "right"))
        return spots

    def _spot_that_looks_like(self, look: Look) -> int:
        """Return the spot of a view without a pose; a new one only while no view has a pose."""
        if len(self._looks):
            alike = self._looks.likeness(look)
            nearest = int(alike.argmax())
            is_full = len(self._looks) >= MAX_LOOKS
            if self._axes is not None or is_full or alike[nearest] >= SAME_LOOK:
                return int(self._spot_of_look[nearest])
        return self._new_spot(NOWHERE)

    def _new_spot(self, number: int, cell: tuple[int, int] = (0, 0)) -> int:
        self._cell_of_spot = np.append(self._cell_of_spot, number)
        self._xy_of_spot = np.append(self._xy_of_spot, [cell], axis=0)
        self._n_views = np.append(self._n_views, 0)
        self.place_of_spot = np.append(self.place_of_spot, NOWHERE)
        self._sees.append(np.empty(0, np.int64))
        return len(self._sees) - 1

    def _note_seen(self, spot: int, cells: Cells) -> None:
        numbers = [
            self._cell_numbers.setdefault((int(x), int(y)), len(self._cell_numbers))
            for x, y in cells
        ]
        self._sees[spot] = np.union1d(self._sees[spot], np.array(numbers, np.int64))

    def _note_look(self, spot: int, look: Look) -> None:
        """Keep a look; one of the spot that has most of them leaves where there are too many."""
        of_spot = np.flatnonzero(self._spot_of_look == spot)
        if len(of_spot) >= MAX_LOOKS_PER_SPOT:
            leaving = of_spot[self._n_views[spot] % MAX_LOOKS_PER_SPOT]
            self._looks.replace(int(leaving), look)
            return
        if len(self._looks) >= MAX_LOOKS:
            fullest = np.bincount(self._spot_of_look).argmax()
            leaving = np.flatnonzero(self._spot_of_look == fullest)[0]
            self._looks.remove(int(leaving))
            self._spot_of_look = np.delete(self._spot_of_look, leaving)
        self._looks.append(look)
        self._spot_of_look = np.append(self._spot_of_look, spot)

    def _place(self, spot: int, T_world_camera: Pose | None, look: Look) -> None:
        """Give a new spot a place: tell all apart anew, or take the likeliest."""
        if len(self._sees) >= GROWTH * self._n_clustered:
            self.tell_apart()
            return
        known = self._by_pose(T_world_camera)
        if T_world_camera is None:
            known = self._by_look(look)
        if known is not None and known.any():
            self.place_of_spot[spot] = known.argmax()
        else:
            self.place_of_spot[spot] = min(self.n_places, self.max_places - 1)

    def tell_apart(self) -> None:
        """Divide all spots into places anew."""
        self._located = None
        if not self._sees:
            return
        posed = np.flatnonzero(self._cell_of_spot != NOWHERE)
        others = np.flatnonzero(self._cell_of_spot == NOWHERE)
        groups = np.zeros(len(self._sees), np.int64)
        if len(posed):
            seen = seen_by_each_other(
                [self._sees[spot] for spot in posed],
                self._cell_of_spot[posed],
                len(self._cell_numbers),
            )
            groups[posed] = join_linked(seen, MIN_SEEN, self.max_places)
        if len(others):
            first = groups.max(initial=NOWHERE) + 1 if len(posed) else 0
            n_left = max(1, self.max_places - first)
            groups[others] = first + join_linked(self._shared(others), MIN_SHARED, n_left)
        self.place_of_spot = keep_numbers(groups, self.place_of_spot, self._n_views)
        self._n_clustered = len(self._sees)

    def _shared(self, spots: Numbers) -> Array:
        """Return (n, n) how many of the looks most like theirs two spots without poses share."""
        first = [int(np.flatnonzero(self._spot_of_look == spot)[0]) for spot in spots]
        looks = Looks(self._looks.array()[first])
        return shared_likes(np.stack([looks.likeness(looks[i]) for i in range(len(looks))]))

    def settings(self) -> dict[str, int]:
        """Return what `__init__` needs for other such places."""
        return {"max_places": self.max_places}

    def state_arrays(self) -> dict[str, Array]:
        """Return all that is known, as flat arrays."""
        cells = np.array(list(self._cell_numbers), np.int32).reshape(-1, 2)
        return {
            "places_axes": np.empty((0, 3)) if self._axes is None else self._axes,
            "places_cells": cells,
            "places_of_spot": self.place_of_spot,
            "places_cell_of_spot": self._cell_of_spot,
            "places_views": self._n_views,
            "places_seen": np.concatenate([np.empty(0, np.int64), *self._sees]),
            "places_n_seen": np.array([len(cells) for cells in self._sees], np.int64),
            "places_looks": self._looks.array(),
            "places_spot_of_look": self._spot_of_look,
            "places_clustered": np.array(self._n_clustered),
        }

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state_arrays` returned; ValueError for what it was not of."""
        for name, like in self.state_arrays().items():
            found = arrays.get(name)
            if found is None or found.dtype != like.dtype or found.ndim != like.ndim:
                raise ValueError(f"{name}: expected {like.dtype} of {like.ndim} axes")
        names = self.state_arrays()
        known: dict[str, Array] = {n.removeprefix("places_"): np.array(arrays[n]) for n in names}
        n_spots, n_cells = len(known["of_spot"]), len(known["cells"])
        of_each = (known[name] for name in ("cell_of_spot", "views", "n_seen"))
        if any(len(numbers) != n_spots for numbers in of_each):
            raise ValueError(f"places: expected numbers of {n_spots} spots")
        if known["n_seen"].sum() != len(known["seen"]) or known["n_seen"].min(initial=0) < 0:
            raise ValueError("places_seen: expected the cells that each spot sees")
        for name, least, n_values in (
            ("seen", 0, n_cells),
            ("of_spot", NOWHERE, self.max_places),
            ("cell_of_spot", NOWHERE, n_cells),
            ("spot_of_look", 0, n_spots),
        ):
            if not ((known[name] >= least) & (known[name] < n_values)).all():
                raise ValueError(f"places_{name}: expected numbers below {n_values}")
        if known["axes"].shape[1] != 3 or len({tuple(cell) for cell in known["cells"]}) != n_cells:
            raise ValueError("places_axes, places_cells: expected directions, and each cell once")
        if not np.isfinite(known["axes"]).all():
            raise ValueError("places_axes: expected finite numbers")
        if known["looks"].shape != (len(known["spot_of_look"]), LOOK_SIZE):
            raise ValueError(f"places_looks: expected (n, {LOOK_SIZE}), got {known['looks'].shape}")
        self._axes = known["axes"] if len(known["axes"]) else None
        self._cell_numbers = {(int(x), int(y)): i for i, (x, y) in enumerate(known["cells"])}
        self.place_of_spot = known["of_spot"]
        self._cell_of_spot, self._n_views = known["cell_of_spot"], known["views"]
        self._xy_of_spot = _xy_of(known["cells"], known["cell_of_spot"])
        self._sees = np.split(known["seen"], np.cumsum(known["n_seen"])[:-1]) if n_spots else []
        self._looks, self._spot_of_look = Looks(known["looks"]), known["spot_of_look"]
        self._located = None
        self._n_clustered = int(known["clustered"])


def _xy_of(cells: Array, cell_of_spot: Numbers) -> Numbers:
    """Return (n_spots, 2) the cell of each spot; 0, 0 of one without a pose."""
    xy = np.zeros((len(cell_of_spot), 2), np.int64)
    has_pose = cell_of_spot != NOWHERE
    xy[has_pose] = cells[cell_of_spot[has_pose]]
    return xy
