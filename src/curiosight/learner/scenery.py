"""How bright surfaces were, and where things stood: what a look is compared with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.learner.glance import BLOCK, N_ACROSS, N_DOWN, Glance
from curiosight.learner.scenery_kernels import (
    FREE,
    N_COLUMNS,
    compare_colours,
    count_new,
    find_slots,
    find_voxels,
    look_for_things,
    move_voxels,
    sum_up,
    take_in,
)

Array = npt.NDArray[Any]

N_PIXELS = N_DOWN * N_ACROSS
# Metres; what is farther is seen too coarsely.
SIDE, MAX_RANGE = 0.1, 4.0
# Some 1300 m² of surfaces, in 8 MB.
MAX_VOXELS, FIRST_SLOTS = 1 << 17, 1 << 12
# A view tells nothing of change where it shows less of what is known, of its readings; nor one with
# fewer voxels or pixels of things, or fewer blocks that are a quarter full.
MIN_KNOWN, MIN_VOXELS, MIN_PIXELS, MIN_BLOCKS = 0.6, 20, 25, 6


@dataclass(frozen=True, slots=True)
class Signs:
    """By how much a view is other than what was seen of the same surfaces; None = it cannot tell.

    light: how much brighter or darker parts of it are, beside the view as a whole (logarithm).
    tint: how much redder or bluer the whole is (likewise). gone: the share of the things in view
    that is seen through. new: the share of what is salient that stands where nothing stood.
    """

    light: float | None = None
    tint: float | None = None
    gone: float | None = None
    new: float | None = None


class Scenery:
    """Remember surfaces by the voxels that they lie in, in a world that poses tell.

    max_voxels: about so many are kept; of more the half is forgotten that was not seen for longest.
    """

    def __init__(self, *, side: float = SIDE, max_voxels: int = MAX_VOXELS) -> None:
        self.side, self._max_voxels = side, max_voxels
        self._n_views, self._n_voxels, self._n_things = 0, 0, 0
        self._make_table(FIRST_SLOTS)
        # The voxels that something salient was seen in.
        self._things = np.empty(0, np.int64)

    def __len__(self) -> int:
        """Count the voxels that are known."""
        return self._n_voxels

    def __getstate__(self) -> dict[str, Any]:
        """Return what is copied and pickled: of the table only what is not free."""
        used = np.flatnonzero(self._voxels != FREE)
        table = len(self._voxels), used, self._voxels[used], self._values[used], self._last[used]
        things = self._things[: self._n_things].copy()
        left_out = dict.fromkeys(("_values", "_last"))
        return vars(self) | left_out | {"_voxels": table, "_things": things}

    def __setstate__(self, state: dict[str, Any]) -> None:
        n_slots, used, voxels, values, last = state["_voxels"]
        vars(self).update(state)
        self._make_table(n_slots)
        self._voxels[used], self._values[used], self._last[used] = voxels, values, last

    def look(self, glance: Glance) -> Signs:
        """Compare a view with what is known, and take it in."""
        seen = find_voxels(
            glance.depth, glance.pinhole, glance.T_world_camera, 1 / self.side, MAX_RANGE
        )
        self._make_room()
        colours = glance.colours
        table, slots = (self._voxels, self._values), find_slots(self._voxels, seen)
        sums, counts, n_seen, n_known = compare_colours(
            self._values, seen, slots, colours, glance.is_salient, BLOCK
        )
        light, tint, brighter, n_blocks = sum_up(sums, counts, BLOCK**2 / 4)
        is_known = n_blocks >= MIN_BLOCKS and n_known >= MIN_KNOWN * n_seen
        n_pixels, n_new = count_new(*table, seen, slots, glance.is_salient)
        n_gone, n_there, self._n_things = look_for_things(
            *table,
            self._things[: self._n_things],
            glance.depth,
            glance.pinhole,
            np.linalg.inv(glance.T_world_camera),
            self.side,
            MAX_RANGE,
        )
        self._n_views += 1
        n_added, self._n_things = take_in(
            *table,
            self._last,
            self._things,
            self._n_things,
            self._n_views,
            seen,
            slots,
            colours,
            glance.is_salient,
            brighter,
        )
        self._n_voxels += n_added
        n_things = n_gone + n_there
        return Signs(
            light if is_known else None,
            tint if is_known else None,
            n_gone / n_things if n_things >= MIN_VOXELS else None,
            n_new / n_pixels if is_known and n_pixels >= MIN_PIXELS else None,
        )

    def _make_room(self) -> None:
        """Make the table large enough for one view more."""
        if self._n_voxels + N_PIXELS > max(self._max_voxels, 2 * N_PIXELS):
            self._forget_unseen()
        while 2 * (self._n_voxels + N_PIXELS) > len(self._voxels):
            self._move(2 * len(self._voxels))
        if self._n_things + N_PIXELS > len(self._things):
            self._things = np.append(self._things, np.empty(2 * N_PIXELS, np.int64))

    def _forget_unseen(self) -> None:
        """Forget the half of the voxels that was not seen for longest."""
        last = self._last[self._voxels != FREE]
        since = int(np.partition(last, len(last) // 2)[len(last) // 2])
        # Where all are of one view none is older.
        self._move(len(self._voxels), since=since if since > last.min() else since + 1)

    def _move(self, n_slots: int, *, since: int = 0) -> None:
        """Put the voxels that were seen since a view into a table of another size."""
        old = self._voxels, self._values, self._last
        self._make_table(n_slots)
        self._n_voxels = move_voxels(*old, since, self._voxels, self._values, self._last)

    def _make_table(self, n_slots: int) -> None:
        self._voxels = np.full(n_slots, FREE)
        self._values = np.zeros((n_slots, N_COLUMNS), np.float32)
        self._last = np.zeros(n_slots, np.int32)
