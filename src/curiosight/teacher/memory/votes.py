"""What many views say of the surfaces of a place: votes on the voxels of the world.

The voxels are kept in a hash table with open addressing, so that the place may be of any size.
A view that is off by some centimetres puts a surface into the next voxel: so what is salient
counts in the voxels around it too, once a view.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Camera, Depth, Label, Pose

Array = npt.NDArray[Any]

FREE = np.int64(-1)
# A voxel's place is three whole numbers of 21 bits, from this one on.
_ORIGIN = 1 << 20
SALIENT, NOT_SALIENT = np.uint8(Label.SALIENT), np.uint8(Label.NOT_SALIENT)


class VoxelVotes:
    """For each voxel of the world, in how many views its surface was salient, and was not.

    side: of a voxel, metres; more than poses drift.
    """

    def __init__(self, *, side: float = 0.05, capacity: int = 1 << 16) -> None:
        self.side = side
        self._n_views = 0
        self._voxels = np.full(capacity, FREE)
        # The last view that saw something salient here or beside, from 1.
        self._marked = np.zeros(capacity, np.int32)
        # Views that saw here what is salient, what is not, and what is salient here or beside.
        self._votes = np.zeros((capacity, 3), np.int32)

    def __len__(self) -> int:
        """Return how many voxels have been voted on."""
        return int(np.count_nonzero(self._voxels != FREE))

    def voxels_of(
        self, depth: Depth, camera: Camera, T_world_camera: Pose, *, stride: int = 1
    ) -> Array:
        """(h, w) int64: the voxel of the surface at every `stride`-th pixel.

        FREE where there is no reading. Places are up to 50 km from the origin.
        """
        coarse = depth[::stride, ::stride]
        return np.asarray(_voxels_of(coarse, _pinhole(camera), stride, T_world_camera, self.side))

    def add(self, voxels: Array, labels: Array) -> None:
        """Let one view vote: each voxel once, for what most of its pixels say.

        voxels: see `voxels_of`. labels: of the same shape, codes of `Label`.
        """
        seen, said = voxels.ravel(), labels.ravel()
        begins = np.append(True, (seen[1:] != seen[:-1]) | (said[1:] != said[:-1]))
        n_most = np.count_nonzero(begins) + 7 * np.count_nonzero(begins & (said == SALIENT))
        while 2 * (len(self) + n_most) > len(self._voxels):
            self._grow()
        slots, ahead = np.full(len(seen), -1), np.zeros(len(self._voxels), np.int32)
        self._n_views += 1
        table = (self._voxels, self._votes, self._marked)
        count_votes(*table, self._n_views, seen, said, slots, ahead)

    def balance(self, voxels: Array) -> Array:
        """(n, 2) int32: how many more views said salient than not, for each of (n,) voxels.

        First for the voxel itself, then with the views that saw something salient beside it.
        """
        return np.asarray(weigh_votes(self._voxels, self._votes, voxels))

    def forget_removed(
        self, depth: Depth, camera: Camera, T_world_camera: Pose, *, gap: float = 0.10
    ) -> None:
        """Forget the salient voxels that a view sees through: what was there has gone.

        gap: metres by which the surface behind must be farther.
        """
        T_camera_world = np.linalg.inv(T_world_camera)
        pinhole = _pinhole(camera)
        _forget_removed(self._voxels, self._votes, depth, pinhole, T_camera_world, self.side, gap)

    def _grow(self) -> None:
        old, votes = self._voxels, self._votes
        self._voxels = np.full(4 * len(old), FREE)
        # No view is half counted when the table grows.
        self._marked = np.zeros(4 * len(old), np.int32)
        self._votes = np.zeros((4 * len(old), 3), np.int32)
        taken = np.flatnonzero(old != FREE)
        move_votes(old[taken], votes[taken], self._voxels, self._votes)


def _pinhole(camera: Camera) -> Array:
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy])


@njit(cache=True, nogil=True)
def _voxels_of(
    depth: Array, pinhole: Array, stride: int, T_world_camera: Array, side: float
) -> Array:
    height, width = depth.shape
    fx, fy, cx, cy = pinhole
    found = np.full((height, width), FREE)
    per_metre = 1.0 / side
    for v in range(height):
        for u in range(width):
            z = depth[v, u]
            if not np.isfinite(z):
                continue
            x = (stride * u - cx) / fx * z
            y = (stride * v - cy) / fy * z
            voxel = np.int64(0)
            for axis in range(3):
                row = T_world_camera[axis]
                place = row[0] * x + row[1] * y + row[2] * z + row[3]
                voxel = (voxel << 21) | (np.int64(np.floor(place * per_metre)) + _ORIGIN)
            found[v, u] = voxel
    return found


@njit(cache=True, nogil=True)
def find_slot(voxels: Array, voxel: int) -> int:
    """Return where a voxel is in the table, or the free slot that it belongs into."""
    last = len(voxels) - 1  # the length is a power of two
    # The multiplier spreads neighbours over the table (Fibonacci hashing).
    slot = ((voxel * 0x1E3779B97F4A7C15) >> 20) & last
    while voxels[slot] != FREE and voxels[slot] != voxel:
        slot = (slot + 1) & last
    return slot


@njit(cache=True, nogil=True)
def count_votes(
    voxels: Array,
    votes: Array,
    marked: Array,
    view: int,
    seen: Array,
    labels: Array,
    slots: Array,
    ahead: Array,
) -> None:
    """Give every voxel in view one vote, for what most of its labelled pixels say.

    view: its number, which `marked` does not hold yet. slots: (n,) all -1 and
    ahead: (capacity,) all 0, to work with.
    """
    for pixel in range(len(seen)):
        label = labels[pixel]
        if seen[pixel] == FREE or (label != SALIENT and label != NOT_SALIENT):
            continue
        slot = find_slot(voxels, seen[pixel])
        voxels[slot] = seen[pixel]
        slots[pixel] = slot
        ahead[slot] += 1 if label == SALIENT else -1
    for slot in slots:
        if slot >= 0 and ahead[slot] != 0:
            votes[slot, 0 if ahead[slot] > 0 else 1] += 1
            if ahead[slot] > 0:
                _mark_beside(voxels, votes, marked, view, voxels[slot])
            ahead[slot] = 0


@njit(cache=True, nogil=True)
def _mark_beside(voxels: Array, votes: Array, marked: Array, view: int, voxel: int) -> None:
    """Let a view vote for a voxel and its six neighbours, where it has not yet."""
    for step in (0, 1, -1, 1 << 21, -(1 << 21), 1 << 42, -(1 << 42)):
        slot = find_slot(voxels, voxel + step)
        voxels[slot] = voxel + step
        if marked[slot] != view:
            marked[slot] = view
            votes[slot, 2] += 1


@njit(cache=True, nogil=True)
def weigh_votes(voxels: Array, votes: Array, seen: Array) -> Array:
    """(n, 2) int32: salient here, and salient here or beside, less not salient here."""
    balance = np.zeros((len(seen), 2), np.int32)
    for pixel in range(len(seen)):
        if seen[pixel] != FREE:
            slot = find_slot(voxels, seen[pixel])
            balance[pixel, 0] = votes[slot, 0] - votes[slot, 1]
            balance[pixel, 1] = votes[slot, 2] - votes[slot, 1]
    return balance


@njit(cache=True, nogil=True)
def _forget_removed(
    voxels: Array,
    votes: Array,
    depth: Array,
    pinhole: Array,
    T_camera_world: Array,
    side: float,
    gap: float,
) -> None:
    height, width = depth.shape
    fx, fy, cx, cy = pinhole
    bits = (1 << 21) - 1
    for slot in range(len(voxels)):
        if votes[slot, 2] == 0:
            continue
        voxel = voxels[slot]
        x = (((voxel >> 42) & bits) - _ORIGIN + 0.5) * side
        y = (((voxel >> 21) & bits) - _ORIGIN + 0.5) * side
        z = ((voxel & bits) - _ORIGIN + 0.5) * side
        row = T_camera_world[2]
        distance = row[0] * x + row[1] * y + row[2] * z + row[3]
        if distance < 0.1:
            continue
        row = T_camera_world[0]
        u = fx * (row[0] * x + row[1] * y + row[2] * z + row[3]) / distance + cx
        row = T_camera_world[1]
        v = fy * (row[0] * x + row[1] * y + row[2] * z + row[3]) / distance + cy
        # At an outline a voxel's middle may miss its own surface: look all around it.
        reach = fx * side / distance
        is_gone = True
        for du in (-reach, 0.0, reach):
            for dv in (-reach, 0.0, reach):
                is_in_view = 0 <= u + du < width and 0 <= v + dv < height
                if not is_in_view or not depth[int(v + dv), int(u + du)] > distance + gap:
                    is_gone = False
        if is_gone:
            votes[slot] = 0


@njit(cache=True, nogil=True)
def move_votes(old: Array, old_votes: Array, voxels: Array, votes: Array) -> None:
    """Copy voxels with their votes into a larger table."""
    for place in range(len(old)):
        slot = find_slot(voxels, old[place])
        voxels[slot] = old[place]
        votes[slot] = old_votes[place]
