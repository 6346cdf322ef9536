"""The readings that a depth image had before each of them was repeated.

A phone's depth has 256x192 readings; brought to the size of its colour image each of them fills a
block of pixels. Fitted to such steps a plane has no slope, so depth is looked at in its own size.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth

Array = npt.NDArray[Any]
# So many rows, and columns, are looked at: where two readings beside each other are equal in one
# of them, they differ in another.
N_LINES = 40
# By so many changes the size is found, which all must then agree with.
N_FITTED = 64
# Fewer places where readings change tell nothing, such as the outlines of a few flat things.
MIN_CHANGES = 32
# Depth that was enlarged by less is taken as it is.
MIN_FACTOR = 1.2
# Of the borders between repeated readings so many may show no change.
MAX_EQUAL = 0.33
# Of the changes so many must lie on such borders, by rounding not all; and where more of all places
# could be one, that tells nothing.
MIN_FITTING, MAX_BORDERS = 0.97, 0.85
# Both sides are enlarged alike; sizes are rounded.
MAX_DISTORTION = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Repeats:
    """Which reading each pixel shows.

    rows, columns: (H,) and (W,) from 0, row and column of the reading in an image of its own size.
    """

    rows: Array
    columns: Array

    @property
    def shape(self) -> tuple[int, int]:
        """Return the rows and columns of the image of its own size."""
        return int(self.rows[-1]) + 1, int(self.columns[-1]) + 1

    @property
    def full_shape(self) -> tuple[int, int]:
        """Return the rows and columns of the image that repeats it."""
        return len(self.rows), len(self.columns)

    def pick(self, image: Array) -> Array:
        """Return of an (H, W) image the pixel in the middle of each reading's block."""
        rows, columns = (_middles(index) for index in (self.rows, self.columns))
        return image.take(rows, axis=0).take(columns, axis=1)

    def repeat(self, image: Array) -> Array:
        """Return an image of its own size with each pixel repeated as the reading is."""
        # Indexing takes five times as long.
        return image.take(self.columns, axis=1).take(self.rows, axis=0)


def find_repeats(depth: Depth) -> Repeats:
    """Return which reading each pixel of (H, W) depth shows: its own, unless they are repeated.

    Repeated readings change at the borders of even blocks only, in all rows and columns alike.
    Steps of a sensor's numbers on a smooth surface are not as even, nor the same in all rows.
    """
    height, width = depth.shape
    columns = _readings_of_columns(depth)
    rows = None if columns is None else _readings_of_columns(depth.T)
    if columns is not None and rows is not None:
        found = Repeats(rows, columns)
        distortion = found.shape[0] * width / (found.shape[1] * height)
        if abs(distortion - 1) < MAX_DISTORTION:
            return found
    return Repeats(np.arange(height), np.arange(width))


def _readings_of_columns(depth: Array) -> Array | None:
    """Return the (W,) reading that each column shows; None where none is repeated."""
    height, width = depth.shape
    if min(height, width) < N_LINES:
        return None
    lines = depth[(np.arange(N_LINES) * height + height // 2) // N_LINES]
    # Bits, since no reading is not equal to itself.
    bits = np.ascontiguousarray(lines, np.float32).view(np.int32)
    is_change = np.zeros(width + 1, np.bool_)
    is_change[1:-1] = (bits[:, 1:] != bits[:, :-1]).any(axis=0)
    changes = np.flatnonzero(is_change)
    n_least = len(changes) + 1
    if len(changes) < MIN_CHANGES or n_least * MIN_FACTOR > width:
        return None
    n_most = min(int(n_least / (1 - MAX_EQUAL)), int(width / MIN_FACTOR))
    sizes = np.arange(n_least, n_most + 1)[:, None]
    places, some = np.arange(width), changes[:: 1 + len(changes) // N_FITTED]
    # A pixel shows what is at its middle, or at its corner. Of two readings that this lies just
    # between programs take either, some now this and now that.
    for shift, below in product((1, 0), ((0,), (1,), (0, 1))):
        fitting = _are_borders(some, sizes, width, shift, below).mean(axis=1)
        size = int(sizes[np.argmax(fitting), 0])
        are_borders = _are_borders(places, size, width, shift, below)
        if are_borders[changes].mean() >= MIN_FITTING and are_borders.mean() < MAX_BORDERS:
            first, last = (_shown(places, size, width, shift, one) for one in (below[0], below[-1]))
            return np.where(~is_change[:-1] & is_change[1:], last, first)
    return None


def _are_borders(
    places: Array, sizes: Any, width: int, shift: int, below: tuple[int, ...]
) -> Array:
    """Tell at which columns another reading begins than is before, rounded in one of some ways."""
    found = [
        _shown(places, sizes, width, shift, one) != _shown(places - 1, sizes, width, shift, one)
        for one in below
    ]
    return np.asarray(np.any(found, axis=0))


def _shown(places: Array, sizes: Any, width: int, shift: int, below: int) -> Array:
    """Return which of so many readings the columns show.

    shift: half pixels from a pixel's corner to where it is read. below: 1 where of two readings
    the first is shown.
    """
    found: Array = np.maximum((2 * places + shift) * sizes - below, 0) // (2 * width)
    return found


def _middles(index: Array) -> Array:
    """Return where in a (n,) ascending index from 0 the middle of each number is."""
    numbers = np.arange(index[-1] + 1)
    first, last = (np.searchsorted(index, numbers, side) for side in ("left", "right"))
    return np.asarray((first + last - 1) // 2)
