"""What a view looks like as a whole: by it a camera without a pose knows where it is."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Rgb

Array = npt.NDArray[Any]
Look = npt.NDArray[np.uint8]

# Of lightness and of the two hues; what is beyond the ends, which is rare, counts to the last bin.
BINS = (8, 10, 10)
LOW, HIGH = 90, 165
RANGES = (0, 256, LOW, HIGH + 1, LOW, HIGH + 1)
LOOK_SIZE = BINS[0] * BINS[1] * BINS[2]
_SMALL = (160, 120)


def look_of(rgb: Rgb) -> Look:
    """Return (800,) uint8, how often each colour is in an (H, W, 3) image.

    The square root of a histogram in Lab, of length 255: the product of two is their
    Bhattacharyya coefficient.
    """
    lab = cv2.cvtColor(cv2.resize(rgb, _SMALL, interpolation=cv2.INTER_AREA), cv2.COLOR_RGB2LAB)
    counts = count_colours(lab, _BINS_OF_VALUE)
    look: Look = np.rint(255 * np.sqrt(counts / max(counts.sum(), 1))).astype(np.uint8)
    return look


def _bins_of_values() -> npt.NDArray[np.int32]:
    """Return (3, 256) what each channel's values add to the number of a colour's bin."""
    values, steps = np.arange(256), (BINS[1] * BINS[2], BINS[2], 1)
    hue = np.clip(values, LOW, HIGH)
    bins = np.empty((3, 256), np.int32)
    for channel, (n_bins, step) in enumerate(zip(BINS, steps, strict=True)):
        low, end = RANGES[2 * channel : 2 * channel + 2]
        # As OpenCV's `calcHist` rounds it.
        scale = n_bins / (end - low)
        bins[channel] = step * np.floor((hue if channel else values) * scale - low * scale)
    return bins


_BINS_OF_VALUE = _bins_of_values()


@njit(cache=True, nogil=True)
def count_colours(lab: Array, bins: Array) -> Array:
    """Return (800,) float32, how many pixels of an (h, w, 3) image fall into each bin."""
    counts = np.zeros(LOOK_SIZE, np.float32)
    for v in range(lab.shape[0]):
        for u in range(lab.shape[1]):
            counts[bins[0, lab[v, u, 0]] + bins[1, lab[v, u, 1]] + bins[2, lab[v, u, 2]]] += 1
    return counts


class Looks:
    """Looks that are kept in an order, as numbers that others are compared with at once."""

    def __init__(self, looks: npt.NDArray[np.uint8] | None = None) -> None:
        given = np.empty((0, LOOK_SIZE), np.uint8) if looks is None else looks
        # Of these the first n count; there is room for more.
        self._n = len(given)
        self._values = given.astype(np.float32)
        self._lengths = np.linalg.norm(self._values, axis=1)

    def __len__(self) -> int:
        return self._n

    def __getitem__(self, index: int) -> Look:
        look: Look = self._values[: self._n][index].astype(np.uint8)
        return look

    def array(self) -> npt.NDArray[np.uint8]:
        """Return (n, 800) of them."""
        return self._values[: self._n].astype(np.uint8)

    def likeness(self, look: Look) -> npt.NDArray[np.float32]:
        """Return how alike a look and all of them are: (n,) in [0, 1], 1 = the same colours."""
        one = look.astype(np.float32)
        lengths = self._lengths[: self._n] * np.linalg.norm(one)
        alike: npt.NDArray[np.float32] = self._values[: self._n] @ one / np.maximum(lengths, 1)
        return alike

    def append(self, look: Look) -> None:
        """Add one behind the others."""
        if self._n == len(self._values):
            n_more = max(16, self._n // 2)
            more = np.zeros((n_more, LOOK_SIZE), np.float32)
            self._values = np.concatenate([self._values, more])
            self._lengths = np.concatenate([self._lengths, np.zeros(n_more, np.float32)])
        self._n += 1
        self.replace(self._n - 1, look)

    def replace(self, index: int, look: Look) -> None:
        """Put another in the place of one."""
        self._values[index] = look
        self._lengths[index] = np.linalg.norm(self._values[index : index + 1], axis=1)[0]

    def remove(self, index: int) -> None:
        """Take one away; those behind it close up."""
        self._values[index : self._n - 1] = self._values[index + 1 : self._n]
        self._lengths[index : self._n - 1] = self._lengths[index + 1 : self._n]
        self._n -= 1
