"""What many views say of the surfaces of a place: votes on the voxels of the world.

The voxels are kept in a hash table with open addressing, so that the place may be of any size.
A view that is off by some centimetres puts a surface into the next voxel: so what is salient
counts in the voxels around it too, once a view.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Camera, Depth, Label, Pose

Array = npt.NDArray[Any]

FREE = np.int64(-1)
# A voxel's place is three whole numbers of 21 bits, from this one on.
ORIGIN = 1 << 20
_BITS = (1 << 21) - 1
SALIENT, NOT_SALIENT = np.uint8(Label.SALIENT), np.uint8(Label.NOT_SALIENT)
# Beside these, of ballots: a cluster that is no object. It may still be a part of one.
REJECTED = np.uint8(1)
# Columns of a voxel's votes: views that saw here what is salient, what is not salient or rejected,
# of these what is surely not salient, and what is salient here or beside; the last of these, from
# 1; by how many pixels salient leads in this view before the one and before the other; and the
# last view that told anything of it, from 1.
N_COLUMNS = 8
HERE, AGAINST, SETTLED, BESIDE, LAST, AHEAD, AHEAD_OF_SETTLED, TOLD = range(N_COLUMNS)
# Some 2600 m² of surfaces, in 84 MB.
MAX_VOXELS = 1 << 20


@dataclass(frozen=True, slots=True, eq=False)
class ViewVote:
    """All that one view told, for `VoxelVotes.add_again`.

    codes: (n,) uint16 of its voxels, in the order in which it came to them first: by how many rows,
    columns and layers each is behind the one before, 8 added, four bits each; then by whom its
    pixels are led: 3 times the sign of `AHEAD`, and that of `AHEAD_OF_SETTLED`, 4 added.
    far: (m,) int64, the voxels that are farther than 7 from the one before, whose bits are 0.
    n_runs, n_salient: see `_count_runs`.
    """

    codes: Array
    far: Array
    n_runs: int
    n_salient: int

    @classmethod
    def of(cls, voxels: Array, votes: Array, touched: Array, n_runs: int, n_salient: int) -> Self:
        """Return that of (n,) touched slots of the tables, before votes are cast."""
        codes, far = np.empty(len(touched), np.uint16), np.empty(len(touched), np.int64)
        n_far = _encode_touched(voxels, votes, touched, codes, far)
        return cls(codes, far[:n_far].copy(), n_runs, n_salient)


class VoxelVotes:
    """For each voxel of the world, in how many views its surface was salient, and was not.

    side: of a voxel, metres; more than poses drift.
    max_voxels: about so many are kept, so that memory has an end where space has none: of more
        the half is forgotten that was not seen for longest.
    """

    def __init__(
        self, *, side: float = 0.05, capacity: int = 1 << 16, max_voxels: int = MAX_VOXELS
    ) -> None:
        self.side = side
        self._max_voxels = max_voxels
        self._n_views, self._n_voxels, self._n_salient = 0, 0, 0
        self._voxels = np.full(capacity, FREE)
        self._votes = np.zeros((capacity, N_COLUMNS), np.int32)
        # The voxels that something salient was seen in or beside.
        self._salient = np.empty(0, np.int64)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is copied and pickled: of the table only what is not free."""
        used = np.flatnonzero(self._voxels != FREE)
        table = len(self._voxels), used, self._voxels[used], self._votes[used]
        salient = self._salient[: self._n_salient].copy()
        return vars(self) | {"_voxels": table, "_votes": None, "_salient": salient}

    def __setstate__(self, state: dict[str, Any]) -> None:
        capacity, used, voxels, votes = state["_voxels"]
        table = np.full(capacity, FREE), np.zeros((capacity, N_COLUMNS), np.int32)
        table[0][used], table[1][used] = voxels, votes
        vars(self).update(state, _voxels=table[0], _votes=table[1])

    def __len__(self) -> int:
        """Return how many voxels have been voted on."""
        return self._n_voxels

    def voxels_of(
        self, depth: Depth, camera: Camera, T_world_camera: Pose, *, stride: int = 1
    ) -> Array:
        """(h, w) int64: the voxel of the surface at every `stride`-th pixel.

        FREE where there is no reading. Places are up to 50 km from the origin.
        """
        coarse = depth[::stride, ::stride]
        found = np.empty(coarse.shape, np.int64)
        x = (stride * np.arange(coarse.shape[1]) - camera.cx) / camera.fx
        y = (stride * np.arange(coarse.shape[0]) - camera.cy) / camera.fy
        _find_voxels(coarse, x, y, T_world_camera, 1.0 / self.side, found)
        return found

    def add(self, voxels: Array, labels: Array) -> None:
        """Let one view vote: each voxel once, for what most of its pixels say.

        voxels: see `voxels_of`. labels: of the same shape, codes of `Label`, or `REJECTED`.
        """
        self._cast(self._tally(voxels, labels)[0])

    def add_and_note(self, voxels: Array, labels: Array) -> ViewVote:
        """Do as `add`, and return what the view told."""
        touched, n_runs, n_salient = self._tally(voxels, labels)
        told = ViewVote.of(self._voxels, self._votes, touched, n_runs, n_salient)
        self._cast(touched)
        return told

    def add_again(self, told: ViewVote) -> None:
        """Let a view vote as it did on other votes in the same state: these become the same."""
        self._make_room(told.n_runs, told.n_salient)
        self._n_views += 1
        touched = np.empty(len(told.codes), np.int64)
        self._n_voxels += _touch_again(
            self._voxels, self._votes, self._n_views, told.codes, told.far, touched
        )
        self._cast(touched)

    def _tally(self, voxels: Array, labels: Array) -> tuple[Array, int, int]:
        """Count the pixels of a view for its voxels; return these, and what `_count_runs` does."""
        seen, said = voxels.ravel(), labels.ravel()
        n_runs, n_salient = _count_runs(seen, said)
        self._make_room(n_runs, n_salient)
        self._n_views += 1
        touched = np.empty(n_runs, np.int64)
        n_touched, n_new = _tally_pixels(
            self._voxels, self._votes, self._n_views, seen, said, touched
        )
        self._n_voxels += n_new
        return touched[:n_touched], n_runs, n_salient

    def _cast(self, touched: Array) -> None:
        """Give the voxels that a view touched their votes."""
        n_new, self._n_salient = _cast_votes(
            self._voxels, self._votes, self._salient, self._n_salient, self._n_views, touched
        )
        self._n_voxels += n_new

    def _make_room(self, n_runs: int, n_salient: int) -> None:
        """Make the tables large enough for one view more, see `_count_runs`."""
        n_new = n_runs + 7 * n_salient
        if self._n_voxels + n_new > max(self._max_voxels, 2 * n_new):
            self._forget_unseen()
        while 2 * (self._n_voxels + n_new) > len(self._voxels):
            self._move(2 * len(self._voxels))
        missing = self._n_salient + 7 * n_salient - len(self._salient)
        if missing > 0:
            self._salient = np.append(self._salient, np.empty(2 * missing, np.int64))

    def balance(self, voxels: Array) -> Array:
        """(n, 3) int32: how many more views said salient than not, for each of (n,) voxels.

        First for the voxel itself, then with the views that saw something salient beside it, and
        last as these against the views that surely saw what is not, rejected clusters left out.
        """
        return np.asarray(_weigh_votes(self._voxels, self._votes, voxels))

    def forget_removed(
        self, depth: Depth, camera: Camera, T_world_camera: Pose, *, gap: float = 0.10
    ) -> Array:
        """Forget the salient voxels that a view sees through: what was there has gone.

        gap: metres by which the surface behind must be farther.
        Return the (n,) voxels, for `forget`.
        """
        T_camera_world = np.linalg.inv(T_world_camera)
        pinhole = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
        table, salient = (self._voxels, self._votes), self._salient[: self._n_salient]
        gone = np.empty(len(salient), np.int64)
        n_gone = _forget_removed(
            *table, salient, depth, pinhole, T_camera_world, self.side, gap, gone
        )
        self._n_salient -= n_gone
        return gone[:n_gone].copy()

    def forget(self, gone: Array) -> None:
        """Forget the (n,) salient voxels that `forget_removed` told of."""
        salient = self._salient[: self._n_salient]
        left = salient[~np.isin(salient, gone)]
        self._salient[: len(left)], self._n_salient = left, len(left)
        for voxel in gone:
            self._votes[find_slot(self._voxels, voxel), :LAST] = 0

    def _forget_unseen(self) -> None:
        """Forget the half of the voxels that was not seen for longest."""
        told = self._votes[self._voxels != FREE, TOLD]
        since = int(np.partition(told, len(told) // 2)[len(told) // 2])
        # Where all are of one view none is older.
        self._move(len(self._voxels), since=since if since > told.min() else since + 1)
        salient = self._salient[: self._n_salient]
        left = salient[_are_known(self._voxels, salient)]
        self._salient, self._n_salient = left.copy(), len(left)

    def _move(self, capacity: int, *, since: int = 0) -> None:
        """Put the voxels that were seen since a view into a table of another size."""
        old, votes = self._voxels, self._votes
        self._voxels = np.full(capacity, FREE)
        self._votes = np.zeros((capacity, N_COLUMNS), np.int32)
        self._n_voxels = _move_votes(old, votes, since, self._voxels, self._votes)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_voxels(
    depth: Array, x: Array, y: Array, T_world_camera: Array, per_metre: float, found: Array
) -> None:
    """Set what `voxels_of` returns; x, y: (w,) and (h,) normalised pixels."""
    a, b, c, d = T_world_camera[0]
    e, f, g, h = T_world_camera[1]
    i, j, k, m = T_world_camera[2]
    for v in range(len(y)):
        for u in range(len(x)):
            z = np.float64(depth[v, u])
            across, down = x[u] * z, y[v] * z
            row = np.int64(np.floor((a * across + b * down + c * z + d) * per_metre)) + ORIGIN
            column = np.int64(np.floor((e * across + f * down + g * z + h) * per_metre)) + ORIGIN
            layer = np.int64(np.floor((i * across + j * down + k * z + m) * per_metre)) + ORIGIN
            voxel = (((row << 21) | column) << 21) | layer
            found[v, u] = voxel if np.isfinite(z) else FREE


@njit(cache=True, nogil=True)
def find_slot(voxels: Array, voxel: int) -> int:
    """Return where a voxel is in the table, or the free slot that it belongs into."""
    last = len(voxels) - 1  # the length is a power of two
    # The multiplier spreads neighbours over the table (Fibonacci hashing).
    slot = ((voxel * 0x1E3779B97F4A7C15) >> 20) & last
    while voxels[slot] != FREE and voxels[slot] != voxel:
        slot = (slot + 1) & last
    return slot


@njit(cache=True, nogil=True, inline="always")
def find_middle(voxel: int, side: float, T_camera_world: Array) -> tuple[float, float, float]:
    """Return where the middle of a voxel is in the camera's frame: x, y and z in metres."""
    bits = (1 << 21) - 1
    x = (((voxel >> 42) & bits) - ORIGIN + 0.5) * side
    y = (((voxel >> 21) & bits) - ORIGIN + 0.5) * side
    z = ((voxel & bits) - ORIGIN + 0.5) * side
    right, down, ahead = T_camera_world[0], T_camera_world[1], T_camera_world[2]
    return (
        right[0] * x + right[1] * y + right[2] * z + right[3],
        down[0] * x + down[1] * y + down[2] * z + down[3],
        ahead[0] * x + ahead[1] * y + ahead[2] * z + ahead[3],
    )


@njit(cache=True, nogil=True, inline="always")
def _is_vote(label: int) -> bool:
    return label in (SALIENT, NOT_SALIENT, REJECTED)


@njit(cache=True, nogil=True)
def _count_runs(seen: Array, said: Array) -> tuple[int, int]:
    """Count the pixels that tell anything, and those that say salient, but one of equal ones.

    seen, said: (n,) voxels and labels of the pixels, row by row.
    """
    n_runs, n_salient = 0, 0
    for pixel in range(len(seen)):
        is_known = _is_vote(said[pixel])
        is_next = pixel == 0 or seen[pixel] != seen[pixel - 1] or said[pixel] != said[pixel - 1]
        if is_known and is_next:
            n_runs += 1
            n_salient += said[pixel] == SALIENT
    return n_runs, n_salient


@njit(cache=True, nogil=True)
def _tally_pixels(
    voxels: Array, votes: Array, view: int, seen: Array, said: Array, touched: Array
) -> tuple[int, int]:
    """Count for every voxel in view what its labelled pixels say.

    view: its number, from 1. seen, said: see `_count_runs`. touched: is filled with the slots of
    the voxels, each once, as they come. Return how many these are, and how many of them are new.
    """
    n_touched, n_new, slot = 0, 0, -1
    for pixel in range(len(seen)):
        label = said[pixel]
        if seen[pixel] == FREE or not _is_vote(label):
            continue
        # Pixels beside each other are mostly of one voxel.
        if slot < 0 or voxels[slot] != seen[pixel]:
            slot = find_slot(voxels, seen[pixel])
            n_new += voxels[slot] == FREE
            voxels[slot] = seen[pixel]
            if votes[slot, TOLD] != view:
                votes[slot, TOLD] = view
                touched[n_touched] = slot
                n_touched += 1
        votes[slot, AHEAD] += 1 if label == SALIENT else -1
        if label != REJECTED:
            votes[slot, AHEAD_OF_SETTLED] += 1 if label == SALIENT else -1
    return n_touched, n_new


@njit(cache=True, nogil=True, inline="always")
def _cell_of(voxel: int) -> tuple[int, int, int]:
    return voxel >> 42, (voxel >> 21) & _BITS, voxel & _BITS


@njit(cache=True, nogil=True)
def _encode_touched(voxels: Array, votes: Array, touched: Array, codes: Array, far: Array) -> int:
    """Set the codes and the far voxels of (n,) touched slots, see `ViewVote`; return how many."""
    n_far, row, column, layer = 0, 0, 0, 0
    for place in range(len(touched)):
        slot = touched[place]
        before = row, column, layer
        row, column, layer = _cell_of(voxels[slot])
        down, across, up = row - before[0] + 8, column - before[1] + 8, layer - before[2] + 8
        is_near = 0 < down < 16 and 0 < across < 16 and 0 < up < 16
        if place == 0 or not is_near:
            far[n_far] = voxels[slot]
            n_far += 1
            down, across, up = 0, 0, 0
        led = 3 * np.sign(votes[slot, AHEAD]) + np.sign(votes[slot, AHEAD_OF_SETTLED]) + 4
        codes[place] = np.uint16(down | across << 4 | up << 8 | led << 12)
    return n_far


@njit(cache=True, nogil=True)
def _touch_again(
    voxels: Array, votes: Array, view: int, codes: Array, far: Array, touched: Array
) -> int:
    """Do what `_tally_pixels` did, by the codes of a `ViewVote`; return how many are new."""
    n_new, n_far, voxel = 0, 0, np.int64(0)
    for place in range(len(codes)):
        code = np.int64(codes[place])
        if code & 0xFFF:
            row, column, layer = _cell_of(voxel)
            row += (code & 15) - 8
            column += ((code >> 4) & 15) - 8
            layer += ((code >> 8) & 15) - 8
            voxel = row << 42 | column << 21 | layer
        else:
            voxel = far[n_far]
            n_far += 1
        slot = find_slot(voxels, voxel)
        n_new += voxels[slot] == FREE
        voxels[slot] = voxel
        led = code >> 12
        votes[slot, AHEAD], votes[slot, AHEAD_OF_SETTLED] = led // 3 - 1, led % 3 - 1
        votes[slot, TOLD] = view
        touched[place] = slot
    return n_new


@njit(cache=True, nogil=True)
def _cast_votes(
    voxels: Array, votes: Array, salient: Array, n_salient: int, view: int, touched: Array
) -> tuple[int, int]:
    """Give every voxel that a view touched one vote, for what most of its labelled pixels say.

    salient: the first `n_salient` are filled. view, touched: see `_tally_pixels`. Return how many
    voxels are new, and `n_salient` now.
    """
    n_new = 0
    for slot in touched:
        ahead, votes[slot, AHEAD] = votes[slot, AHEAD], 0
        if ahead < 0:
            votes[slot, AGAINST] += 1
        if votes[slot, AHEAD_OF_SETTLED] < 0:
            votes[slot, SETTLED] += 1
        votes[slot, AHEAD_OF_SETTLED] = 0
        if ahead <= 0:
            continue
        votes[slot, HERE] += 1
        for step in (0, 1, -1, 1 << 21, -(1 << 21), 1 << 42, -(1 << 42)):
            beside = find_slot(voxels, voxels[slot] + step)
            n_new += voxels[beside] == FREE
            voxels[beside] = voxels[slot] + step
            votes[beside, TOLD] = view
            if votes[beside, LAST] != view:
                votes[beside, LAST] = view
                if votes[beside, BESIDE] == 0:
                    salient[n_salient] = voxels[beside]
                    n_salient += 1
                votes[beside, BESIDE] += 1
    return n_new, n_salient


@njit(cache=True, nogil=True)
def _weigh_votes(voxels: Array, votes: Array, seen: Array) -> Array:
    """(n, 3) int32, see `balance`."""
    balance, slot = np.zeros((len(seen), 3), np.int32), -1
    for pixel in range(len(seen)):
        if seen[pixel] != FREE:
            if slot < 0 or voxels[slot] != seen[pixel]:
                slot = find_slot(voxels, seen[pixel])
            balance[pixel, 0] = votes[slot, HERE] - votes[slot, AGAINST]
            balance[pixel, 1] = votes[slot, BESIDE] - votes[slot, AGAINST]
            balance[pixel, 2] = votes[slot, BESIDE] - votes[slot, SETTLED]
    return balance


@njit(cache=True, nogil=True)
def _forget_removed(
    voxels: Array,
    votes: Array,
    salient: Array,
    depth: Array,
    pinhole: Array,
    T_camera_world: Array,
    side: float,
    gap: float,
    gone: Array,
) -> int:
    """Forget what `forget_removed` says of the (n,) salient voxels; return how many.

    gone: (n,), these are written to its beginning.
    """
    height, width = depth.shape
    fx, fy, cx, cy = pinhole
    n_left, n_gone = 0, 0
    for place in range(len(salient)):
        voxel = salient[place]
        # It stays in the list unless it has gone.
        salient[n_left] = voxel
        n_left += 1
        across, down, distance = find_middle(voxel, side, T_camera_world)
        if distance < 0.1:
            continue
        u, v = fx * across / distance + cx, fy * down / distance + cy
        # At an outline a voxel's middle may miss its own surface: look all around it.
        reach = fx * side / distance
        is_gone = True
        for du in (-reach, 0.0, reach):
            for dv in (-reach, 0.0, reach):
                is_in_view = 0 <= u + du < width and 0 <= v + dv < height
                if not is_in_view or not depth[int(v + dv), int(u + du)] > distance + gap:
                    is_gone = False
        if is_gone:
            slot = find_slot(voxels, voxel)
            votes[slot, :LAST] = 0
            n_left -= 1
            gone[n_gone] = voxel
            n_gone += 1
    return n_gone


@njit(cache=True, nogil=True)
def _are_known(voxels: Array, asked: Array) -> Array:
    """(n,) bool: which of (n,) voxels are in the table."""
    found = np.empty(len(asked), np.bool_)
    for place in range(len(asked)):
        found[place] = voxels[find_slot(voxels, asked[place])] != FREE
    return found


@njit(cache=True, nogil=True)
def _move_votes(old: Array, old_votes: Array, since: int, voxels: Array, votes: Array) -> int:
    """Copy voxels that were seen since a view into another table; return how many these are."""
    n_moved = 0
    for place in range(len(old)):
        if old[place] != FREE and old_votes[place, TOLD] >= since:
            slot = find_slot(voxels, old[place])
            voxels[slot] = old[place]
            n_moved += 1
            for column in range(votes.shape[1]):
                votes[slot, column] = old_votes[place, column]
    return n_moved
