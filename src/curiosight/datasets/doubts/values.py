"""What the stored numbers themselves tell: their unit, the sensor's steps, rotated bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.datasets.depth_bits import ROTATION, are_rotated
from curiosight.frame import Depth

Stored = npt.NDArray[np.int64]
Metres = npt.NDArray[np.floating]

USUAL_SCALES = (0.001, 0.0005, 0.00025, 0.0002, 0.0001)
LARGEST = 65535
# Share of pixels that must be whole multiples of a unit for it to be the file's.
MIN_WHOLE = 0.995
# Steps are measured where they are at least this many units wide, from this many steps, of which
# this share must agree within a quarter. Both of its ends must occur often and what lies between
# hardly ever: rare values have gaps without any sensor's doing.
MIN_UNITS, MIN_STEPS, MIN_AGREEING = 3, 15, 0.55
MIN_PIXELS_AT_ENDS, MIN_PIXELS = 40, 4
# Steps of disparity grow with the square of distance: the slope of their logarithms, over so much
# of the logarithm of distance.
MIN_SLOPE, MIN_LOG_RANGE = 1.2, 0.15


@dataclass(frozen=True, slots=True)
class StoredDepth:
    """Depth as whole numbers, one array a frame, 0 = no reading, and metres per unit."""

    images: tuple[Stored, ...]
    scale: float

    @property
    def quantum(self) -> float:
        """Return the metres between neighbouring values that the files can hold."""
        return self.scale * _common_divisor(self.images)


def stored_depth(depths: Sequence[Depth], scale: float | None) -> StoredDepth | None:
    """Return the numbers that the files hold; None where depth is no multiple of any unit.

    scale: metres per unit that depth was read with, if known; otherwise the usual are tried.
    """
    scales = USUAL_SCALES if scale is None or not scale > 0 else (scale, *USUAL_SCALES)
    for unit in scales:
        images = [np.nan_to_num(depth.astype(np.float64) / unit) for depth in depths]
        whole = [np.rint(image) for image in images]
        # Metres are float32: a stored 65535 comes back within 0.004.
        off = [np.abs(a - b)[b > 0] > 0.01 for a, b in zip(images, whole, strict=True)]
        n_pixels = sum(map(len, off))
        if max(image.max() for image in whole) > LARGEST or not n_pixels:
            continue
        if sum(map(np.count_nonzero, off)) <= (1 - MIN_WHOLE) * n_pixels:
            return StoredDepth(tuple(image.astype(np.int64) for image in whole), float(unit))
    return None


def disparity_step(stored: StoredDepth) -> float | None:
    """Return the step in 1/z between neighbouring readings, 1/m; None where none shows.

    Structured light and stereo measure disparity, so steps in depth are this times z². A
    Kinect's is 0.0029; depth read s times too far shows it s times too small.
    """
    divisor = _common_divisor(stored.images)
    counts = np.bincount(np.concatenate([image.ravel() for image in stored.images]) // divisor)
    counts[0] = 0
    values = np.flatnonzero(counts >= MIN_PIXELS)
    steps = np.diff(values)
    is_often = counts[values] >= MIN_PIXELS_AT_ENDS
    is_wide = (steps >= MIN_UNITS) & is_often[:-1] & is_often[1:]
    if np.count_nonzero(is_wide) < MIN_STEPS:
        return None
    metres = values * divisor * stored.scale
    if not _grow_with_square(metres[:-1][is_wide], np.diff(metres)[is_wide]):
        return None
    in_disparity = (1 / metres[:-1] - 1 / metres[1:])[is_wide]
    step = float(np.median(in_disparity))
    agreeing = np.abs(in_disparity / step - 1) < 0.25
    return step if agreeing.mean() >= MIN_AGREEING else None


def has_rotated_bits(stored: StoredDepth) -> bool:
    """Tell whether bits were rotated by three before depth was stored.

    Beyond 8191 units depth wraps around then. Nearer it is just eight times the number, which
    says so only in a unit that is usual: in eighths of one it is right.
    """
    if not are_rotated(stored.images):
        return False
    is_unit_usual = any(abs(stored.scale / unit - 1) < 0.01 for unit in USUAL_SCALES)
    return is_unit_usual or _common_divisor(stored.images) % (1 << ROTATION) != 0


def _grow_with_square(metres: Metres, steps: Metres) -> bool:
    """Tell whether (n,) steps grow with distance as those of disparity do.

    Others do not: floats of 16 bits, as phones have them, have the same steps from 4 m to 8 m.
    """
    distances = np.log(metres)
    if np.ptp(distances) < MIN_LOG_RANGE:
        return False
    slope = np.polyfit(distances, np.log(steps), 1)[0]
    return bool(slope > MIN_SLOPE)


def _common_divisor(images: Sequence[Stored]) -> int:
    """Return the largest number that divides all but a few stray values."""
    counts = np.bincount(np.concatenate([image.ravel() for image in images]))
    counts[0] = 0
    values = np.flatnonzero(counts)
    divisor = int(np.gcd.reduce(values)) if len(values) else 1
    for larger in (50, 40, 25, 20, 16, 10, 8, 5, 4, 2):
        if larger > divisor and counts[::larger].sum() >= MIN_WHOLE * counts.sum():
            return larger
    return max(divisor, 1)
