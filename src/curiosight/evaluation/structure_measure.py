"""The S-measure (Fan et al., "Structure-measure: a new way to evaluate foreground maps", 2017)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.evaluation.object_truth import EPSILON

Floats = npt.NDArray[np.float64]


def structure_measure(counts: Floats, values: Floats, *, object_share: float = 0.5) -> float:
    """Return the S-measure, from the numbers of pixels in place of the pixels.

    counts: (4, 2, n) known pixels by quadrant around the centroid of what is salient, by not
        salient or salient, by value; not all zero.
    values: (n,) in [0, 1], rising.
    object_share: of the object-aware part; the rest is the region-aware part (eq. 10).
    """
    not_salient, salient = counts.sum(axis=0)
    n_salient, n_known = salient.sum(), counts.sum()
    if n_salient == 0:
        return 1 - _mean(not_salient, values)
    if n_salient == n_known:
        return _mean(salient, values)
    salient_share = float(n_salient / n_known)
    of_objects = salient_share * _uniformity(salient, values)
    of_objects += (1 - salient_share) * _uniformity(not_salient[::-1], (1 - values)[::-1])
    of_regions = sum(
        float(quadrant.sum() / n_known) * _similarity(quadrant, values) for quadrant in counts
    )
    return max(0.0, object_share * of_objects + (1 - object_share) * of_regions)


def _uniformity(counts: Floats, values: Floats) -> float:
    """Return how high and even the values of one class are (eq. 4 and 5 of the paper)."""
    n_pixels = counts.sum()
    mean = _mean(counts, values)
    deviation = 0.0
    if n_pixels > 1:
        deviation = float(np.sqrt(counts @ (values - mean) ** 2 / (n_pixels - 1)))
    return 2 * mean / (mean**2 + 1 + deviation)


def _similarity(counts: Floats, values: Floats) -> float:
    """Return the structural similarity of a map and its truth in one quadrant (eq. 1 and 2).

    counts: (2, n) not salient, salient. Without a pixel 0: it weighs nothing.
    """
    both = counts.sum(axis=0)
    n_pixels = both.sum()
    if n_pixels == 0:
        return 0.0
    mean, salient_share = _mean(both, values), float(counts[1].sum() / n_pixels)
    n_free = max(n_pixels - 1, 1)
    variance = float(both @ (values - mean) ** 2 / n_free)
    truth_variance = float(n_pixels * salient_share * (1 - salient_share) / n_free)
    covariance = float(counts[1] @ (values - mean) - salient_share * (both @ (values - mean)))
    likeness = 4 * mean * salient_share * covariance / n_free
    scale = (mean**2 + salient_share**2) * (variance + truth_variance)
    if likeness != 0:
        return float(likeness / (scale + EPSILON))
    return 1.0 if scale == 0 else 0.0


def _mean(counts: Floats, values: Floats) -> float:
    """Return the mean of counted values, exact where all are equal.

    Otherwise rounding would decide whether an even region has a variance.
    """
    lowest = values[np.argmax(counts > 0)]
    return float(lowest + counts @ (values - lowest) / counts.sum())
