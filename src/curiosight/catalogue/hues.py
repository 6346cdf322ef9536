"""The hues of a thing, from its top to its bottom, whatever light it stands in.

A hue is two logarithms of ratios, red and blue to green, of linear intensities: how bright the
light is falls out, and its colour only moves them (Berwick and Lee, ICCV 1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Hues = npt.NDArray[np.float32]

# Bins of the two ratios, in each of so many bands from a thing's top to its bottom.
N_BANDS, N_BINS = 3, 18
N_HUES = N_BANDS * N_BINS * N_BINS
# Added to intensities in [0, 1], as what is nearly black has no hue but noise; and what the
# logarithms are multiplied by before they are squeezed into [-1, 1] by the hyperbolic tangent.
DARK, NARROWED = 0.002, 0.7
# A camera that looks steeper than this, as the sine, sees no top and bottom.
MIN_LEVEL = 0.3


def _linear_intensities() -> npt.NDArray[np.float32]:
    """Return the linear intensity in [0, 1] of each of 256 values (IEC 61966-2-1, sRGB)."""
    value = np.arange(256) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


INTENSITIES = _linear_intensities()


def count_hues(rgb: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_], up: Array | None) -> Hues:
    """Return (972,) how many pixels of a mask have each hue, band by band from the top.

    A pixel counts for the four bins around it, by how near it is to each.
    rgb: (H, W, 3). mask: (H, W). up: (3,) unit vector in the camera's frame; None = against the
    image's rows.
    """
    red, green, blue = np.log(INTENSITIES[rgb[mask]] + DARK).T
    ratios = np.tanh(NARROWED * np.stack([red - green, blue - green]))
    places = np.clip((ratios + 1) / 2 * N_BINS - 0.5, 0, N_BINS - 1)
    lower = np.minimum(places.astype(np.int64), N_BINS - 2)
    nearer_upper = places - lower
    counts = np.zeros(N_HUES)
    bands, n_bands = _bands_of(mask, up)
    for steps in np.ndindex(2, 2):
        bins = (bands * N_BINS + lower[0] + steps[0]) * N_BINS + lower[1] + steps[1]
        shares = np.prod(
            [abs(1 - step - near) for step, near in zip(steps, nearer_upper, strict=True)], axis=0
        )
        counts += np.bincount(bins, shares, minlength=N_HUES)
    if n_bands == 1:
        counts = np.tile(counts[: N_HUES // N_BANDS] / N_BANDS, N_BANDS)
    return counts.astype(np.float32)


def _bands_of(mask: npt.NDArray[np.bool_], up: Array | None) -> tuple[Array, int]:
    """Return (n,) the band of each pixel of a mask, 0 = at the top, and how many bands there are.

    There is one where the camera looks so steep that no side of the image is up.
    """
    v, u = np.nonzero(mask)
    across, down = (0.0, 1.0) if up is None else (-float(up[0]), -float(up[1]))
    if np.hypot(across, down) < MIN_LEVEL:
        return np.zeros(len(v), np.int64), 1
    below = u * across + v * down
    ends = np.quantile(below, np.arange(1, N_BANDS) / N_BANDS)
    return np.searchsorted(ends, below), N_BANDS


def mean_hues(counts: Sequence[Hues]) -> npt.NDArray[np.float64]:
    """Return (972,) the share of each hue in views of a thing, each of which counts the same."""
    shares = [one / max(float(one.sum()), 1.0) for one in counts]
    mean: npt.NDArray[np.float64] = np.mean(shares, axis=0, dtype=np.float64)
    return mean


def hue_distances(before: Sequence[Array], after: Sequence[Array]) -> npt.NDArray[np.float64]:
    """Return (n, m) Hellinger's distances of shares of hues: 0 = the same, 1 = none shared."""
    roots = [np.sqrt(np.stack(some)) for some in (before, after)]
    distances: npt.NDArray[np.float64] = np.sqrt(np.maximum(0.0, 1.0 - roots[0] @ roots[1].T))
    return distances
