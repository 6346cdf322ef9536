"""The kernels of `Scenery`: a hash table of voxels with what was seen of each.

Columns of a voxel's values: views that saw it, up to `MAX_VIEWS`; views that saw something salient
in it, less what was seen through since; the means of its three colours, see `Glance`, NaN = none
was told yet; and the variance of the first of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.teacher.memory.votes import FREE as FREE
from curiosight.teacher.memory.votes import ORIGIN, find_middle, find_slot

Array = npt.NDArray[Any]

N_COLUMNS = 6
VIEWS, THINGS, BRIGHTNESS, RED, BLUE, VARIANCE = range(N_COLUMNS)
# The older a mean is the less a view moves it, down to one part of so many.
MAX_VIEWS = 64.0
# A thing of ever so many views is forgotten after four that see through it.
MAX_THINGS = 16.0
# From so many views on a voxel is known.
MIN_VIEWS = 3
# A brightness differs by this much from view to view at the least; and before it is known, squared.
LEAST_SPREAD, FIRST_VARIANCE = 0.05, 0.02
# Of how many views a thing has to be to be missed.
MIN_THINGS = 2.0
# From a voxel to those beside it, see `ORIGIN`.
NEIGHBOURS = (1, -1, 1 << 21, -(1 << 21), 1 << 42, -(1 << 42))


@njit(cache=True, nogil=True)
def find_voxels(
    depth: Array, pinhole: Array, pose: Array, per_metre: float, max_range: float
) -> Array:
    """Return (h, w) int64, the voxel that each pixel of a depth image shows; FREE = none."""
    fx, fy, cx, cy = pinhole
    found = np.full(depth.shape, FREE)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z = np.float64(depth[v, u])
            if not 0 < z <= max_range:
                continue
            x, y = (u - cx) / fx * z, (v - cy) / fy * z
            voxel = np.int64(0)
            for row in range(3):
                along = pose[row, 0] * x + pose[row, 1] * y + pose[row, 2] * z + pose[row, 3]
                voxel = (voxel << 21) | (np.int64(np.floor(along * per_metre)) + ORIGIN)
            found[v, u] = voxel
    return found


@njit(cache=True, nogil=True)
def find_slots(voxels: Array, seen: Array) -> Array:
    """Return (h, w) int32, where each pixel's voxel is in the table; -1 = it is not known."""
    slots, slot, before = np.full(seen.shape, np.int32(-1)), -1, FREE
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            if seen[v, u] == FREE:
                continue
            # Pixels beside each other are often of one voxel.
            if seen[v, u] != before:
                slot, before = find_slot(voxels, seen[v, u]), seen[v, u]
            if voxels[slot] != FREE:
                slots[v, u] = slot
    return slots


@njit(cache=True, nogil=True)
def compare_colours(
    values: Array, seen: Array, slots: Array, colours: Array, is_salient: Array, block: int
) -> tuple[Array, Array, int, int]:
    """Compare what a view shows with the colours that it had.

    Return for each block of pixels the (3,) weighted sums of differences, the sum of weights and
    the number of pixels; and how many pixels are of voxels, and of known ones. Things do not
    count: they may have been moved.
    """
    size = slots.shape[0] // block, slots.shape[1] // block
    sums, counts = np.zeros((*size, 4)), np.zeros(size, np.int64)
    n_seen, n_known = 0, 0
    for v in range(slots.shape[0]):
        for u in range(slots.shape[1]):
            n_seen += seen[v, u] != FREE
            slot = slots[v, u]
            if slot < 0 or values[slot, VIEWS] < MIN_VIEWS:
                continue
            n_known += 1
            is_told = not np.isnan(colours[v, u, 0]) and not np.isnan(values[slot, BRIGHTNESS])
            if not is_told or is_salient[v, u] or values[slot, THINGS] > 0:
                continue
            weight = 1 / (values[slot, VARIANCE] + LEAST_SPREAD**2)
            of_block = sums[v // block, u // block]
            for colour in range(3):
                difference = colours[v, u, colour] - values[slot, BRIGHTNESS + colour]
                of_block[colour] += weight * min(max(difference, -1.0), 1.0)
            of_block[3] += weight
            counts[v // block, u // block] += 1
    return sums, counts, n_seen, n_known


@njit(cache=True, nogil=True)
def sum_up(sums: Array, counts: Array, least: float) -> tuple[float, float, float, int]:
    """Return `Signs.light` and `tint`, by how much the view is brighter, and of how many blocks.

    sums, counts: of `compare_colours`. least: pixels of a block that tells.
    """
    means, n = np.empty((3, counts.size)), 0
    for row in range(counts.shape[0]):
        for column in range(counts.shape[1]):
            if counts[row, column] >= least:
                for colour in range(3):
                    means[colour, n] = sums[row, column, colour] / sums[row, column, 3]
                n += 1
    if n == 0:
        return 0.0, 0.0, 0.0, 0
    brighter = np.median(means[0, :n])
    light = np.abs(means[0, :n] - brighter).mean()
    return light, np.hypot(np.median(means[1, :n]), np.median(means[2, :n])), brighter, n


@njit(cache=True, nogil=True)
def count_new(
    voxels: Array, values: Array, seen: Array, slots: Array, is_salient: Array
) -> tuple[int, int]:
    """Count the pixels of things, and of these those where nothing ever stood, nor beside it."""
    n_things, n_new = 0, 0
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            if seen[v, u] == FREE or not is_salient[v, u]:
                continue
            n_things += 1
            if slots[v, u] >= 0 and values[slots[v, u], THINGS] > 0:
                continue
            is_new = True
            for step in NEIGHBOURS:
                beside = find_slot(voxels, seen[v, u] + step)
                if voxels[beside] != FREE and values[beside, THINGS] > 0:
                    is_new = False
            n_new += is_new
    return n_things, n_new


@njit(cache=True, nogil=True)
def look_for_things(
    voxels: Array,
    values: Array,
    things: Array,
    depth: Array,
    pinhole: Array,
    T_camera_world: Array,
    side: float,
    max_range: float,
) -> tuple[int, int, int]:
    """Count the voxels of things that a view sees through, and those that are there.

    What is seen through counts half from now on, and is forgotten in the end: return also how
    many of the (n,) `things` are left, the first ones.
    """
    height, width = depth.shape
    fx, fy, cx, cy = pinhole
    n_gone, n_there, n_left = 0, 0, 0
    for place in range(len(things)):
        voxel = things[place]
        slot = find_slot(voxels, voxel)
        if voxels[slot] == FREE or values[slot, THINGS] == 0:
            continue
        things[n_left] = voxel
        n_left += 1
        across, down, distance = find_middle(voxel, side, T_camera_world)
        if distance < 0.3 or distance > max_range or values[slot, THINGS] < MIN_THINGS:
            continue
        u, v = fx * across / distance + cx, fy * down / distance + cy
        if not (0 <= u < width - 1 and 0 <= v < height - 1):
            continue
        middle = depth[int(v + 0.5), int(u + 0.5)]
        # At an outline a voxel's middle may miss its own surface: look all around it.
        reach = fx * side / distance
        is_gone, is_there = bool(middle > distance + side), False
        for du in (-reach, 0.0, reach):
            for dv in (-reach, 0.0, reach):
                column, line = int(u + du + 0.5), int(v + dv + 0.5)
                if 0 <= u + du < width - 1 and 0 <= v + dv < height - 1:
                    found = depth[line, column]
                    is_gone &= not found <= distance + side
                    is_there |= abs(found - distance) <= side
        n_there += is_there and not is_gone
        if is_gone:
            n_gone += 1
            values[slot, THINGS] = values[slot, THINGS] // 2
            n_left -= values[slot, THINGS] == 0
    return n_gone, n_there, n_left


@njit(cache=True, nogil=True)
def take_in(
    voxels: Array,
    values: Array,
    last: Array,
    things: Array,
    n_things: int,
    view: int,
    seen: Array,
    slots: Array,
    colours: Array,
    is_salient: Array,
    brighter: float,
) -> tuple[int, int]:
    """Learn from a view what its voxels look like; its number is above that of any before.

    brighter: than it would be if its camera were exposed as before.

    Return how many voxels are new, and how many of `things` are filled now.
    """
    n_new = 0
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            if seen[v, u] == FREE:
                continue
            slot = slots[v, u]
            if slot < 0:
                slot = find_slot(voxels, seen[v, u])
            if voxels[slot] == FREE:
                voxels[slot] = seen[v, u]
                values[slot] = 0
                values[slot, VARIANCE] = FIRST_VARIANCE
                values[slot, BRIGHTNESS] = np.nan
                last[slot] = 0
                n_new += 1
            if last[slot] != view:
                last[slot] = view
                values[slot, VIEWS] = min(MAX_VIEWS, values[slot, VIEWS] + 1)
                if is_salient[v, u]:
                    if values[slot, THINGS] == 0:
                        things[n_things] = seen[v, u]
                        n_things += 1
                    values[slot, THINGS] = min(MAX_THINGS, values[slot, THINGS] + 1)
            if not np.isnan(colours[v, u, 0]):
                _take_in_colours(values[slot], colours[v, u], brighter)
    return n_new, n_things


@njit(cache=True, nogil=True)
def _take_in_colours(voxel: Array, colours: Array, brighter: float) -> None:
    if np.isnan(voxel[BRIGHTNESS]):
        voxel[BRIGHTNESS : BRIGHTNESS + 3] = colours
        voxel[BRIGHTNESS] -= brighter
        return
    share = 1 / max(2.0, voxel[VIEWS])
    for colour in range(3):
        is_brightness = colour == 0
        difference = colours[colour] - voxel[BRIGHTNESS + colour] - (brighter * is_brightness)
        difference = min(max(difference, -1.0), 1.0)
        voxel[BRIGHTNESS + colour] += share * difference
        if is_brightness:
            voxel[VARIANCE] += share * (difference**2 - voxel[VARIANCE])


@njit(cache=True, nogil=True)
def move_voxels(
    old: Array,
    old_values: Array,
    old_last: Array,
    since: int,
    new: Array,
    values: Array,
    last: Array,
) -> int:
    """Copy voxels that were seen since a view into another table; return how many these are."""
    n_moved = 0
    for place in range(len(old)):
        if old[place] != FREE and old_last[place] >= since:
            slot = find_slot(new, old[place])
            new[slot], last[slot] = old[place], old_last[place]
            values[slot] = old_values[place]
            n_moved += 1
    return n_moved
