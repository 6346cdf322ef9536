"""What a view looks like as a whole: by it a camera without a pose knows where it is."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb

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
    lab[..., 1:] = np.clip(lab[..., 1:], LOW, HIGH)
    counts = cv2.calcHist([lab], [0, 1, 2], None, BINS, RANGES).ravel()
    look: Look = np.rint(255 * np.sqrt(counts / max(counts.sum(), 1))).astype(np.uint8)
    return look


def likeness(look: Look, others: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    """Return how alike a look and (n, 800) others are: (n,) in [0, 1], 1 = the same colours."""
    one, many = look.astype(np.float32), others.astype(np.float32)
    lengths = np.linalg.norm(many, axis=1) * np.linalg.norm(one)
    alike: npt.NDArray[np.float32] = many @ one / np.maximum(lengths, 1)
    return alike
