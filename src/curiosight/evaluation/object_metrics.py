"""The measures of salient-object detection, equal to those of the usual evaluation programs.

Maps are scored as 8-bit images are: rounded to 256 levels. Ignored pixels are left out of every
measure: what a map says there changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.evaluation.object_truth import EPSILON, N_LEVELS, ObjectTruth
from curiosight.evaluation.structure_measure import structure_measure
from curiosight.evaluation.weighted_f import weighted_f

Floats = npt.NDArray[np.float64]
Levels = npt.NDArray[np.uint8]

BETA_SQUARED = 0.3  # Achanta et al. 2009: precision counts more than recall


@dataclass(frozen=True, slots=True, eq=False)
class ObjectScore:
    """How well one map shows the objects of its truth; None where a figure has no meaning.

    mae: mean absolute error. It and `s_measure` want a known pixel, the E-measure two, the
        others a salient one.
    f_curve, e_curve: (256,) the F-measure (beta² = 0.3) and the E-measure where a pixel of
        that level or more is salient.
    f_adaptive, e_adaptive: where a pixel of twice the mean or more is.
    """

    mae: float | None
    s_measure: float | None
    weighted_f: float | None
    f_curve: Floats | None
    f_adaptive: float | None
    e_curve: Floats | None
    e_adaptive: float | None


def score_objects(
    saliency: npt.NDArray[np.floating], truth: ObjectTruth, *, is_stretched: bool = True
) -> ObjectScore:
    """Compare an (H, W) map in [0, 1] with its truth.

    is_stretched: first stretch the map to reach from 0 to 1 on the known pixels, as evaluation
        programs do; a constant map stays as it is.
    """
    _check_map(saliency, truth)
    if truth.n_known == 0:
        return ObjectScore(None, None, None, None, None, None, None)
    levels = np.rint(saliency * (N_LEVELS - 1)).astype(np.uint8)
    counts = truth.count_levels(levels)
    level_values = _level_values(counts, is_stretched)
    values = level_values[levels]
    not_salient, salient = counts.sum(axis=0)
    hits, alarms = _counts_above(salient, level_values), _counts_above(not_salient, level_values)
    # From the pixels, not their numbers: rounding decides whether a level equals the threshold.
    known_values = values if truth.n_known == values.size else values[truth.is_known]
    is_above = level_values >= min(2 * known_values.mean(), 1)
    adaptive = np.array([salient[is_above].sum()]), np.array([not_salient[is_above].sum()])
    has_salient, has_two = truth.n_salient > 0, truth.n_known > 1
    return ObjectScore(
        mae=float((not_salient @ level_values + salient @ (1 - level_values)) / truth.n_known),
        s_measure=structure_measure(counts, level_values),
        weighted_f=weighted_f(values, truth),
        f_curve=_f_measure(hits, alarms, truth) if has_salient else None,
        f_adaptive=float(_f_measure(*adaptive, truth)[0]) if has_salient else None,
        e_curve=_e_measure(hits, alarms, truth) if has_two else None,
        e_adaptive=float(_e_measure(*adaptive, truth)[0]) if has_two else None,
    )


def _check_map(saliency: npt.NDArray[np.floating], truth: ObjectTruth) -> None:
    size = truth.is_known.shape
    if saliency.shape != size or not np.issubdtype(saliency.dtype, np.floating):
        found = f"{saliency.shape} {saliency.dtype}"
        raise ValueError(f"saliency: expected {size} floats like the truth, got {found}")
    low, high = saliency.min(), saliency.max()
    if not (low >= 0 and high <= 1):
        raise ValueError(f"saliency: expected numbers from 0 to 1, got {low} to {high}")


def _level_values(counts: Floats, is_stretched: bool) -> Floats:
    """(256,): the value in [0, 1] that each level stands for."""
    values = np.arange(N_LEVELS) / (N_LEVELS - 1)
    used = values[counts.sum(axis=(0, 1)) > 0]
    low, high = used[0], used[-1]
    if is_stretched and low < high:
        # Levels that only ignored pixels have may lie outside.
        values = np.clip((values - low) / (high - low), 0, 1)
    return values


def _counts_above(counts: Floats, level_values: Floats) -> Floats:
    """(256,): how many pixels have a stretched level or more."""
    # Cut off, not rounded, as the programs do it.
    stretched = (level_values * (N_LEVELS - 1)).astype(np.uint8)
    n_at = np.bincount(stretched, weights=counts, minlength=N_LEVELS)
    above: Floats = np.cumsum(n_at[::-1], dtype=np.float64)[::-1]
    return above


def _f_measure(hits: Floats, alarms: Floats, truth: ObjectTruth) -> Floats:
    """Return the F-measure of (n,) numbers of pixels rightly and wrongly taken for salient."""
    f: Floats = (1 + BETA_SQUARED) * hits / (BETA_SQUARED * truth.n_salient + hits + alarms)
    return f


def _e_measure(hits: Floats, alarms: Floats, truth: ObjectTruth) -> Floats:
    """Return the E-measure (Fan et al., "Enhanced-alignment measure", 2018) of (n,) numbers.

    As in the authors' program, the sum is divided by one pixel less than there are.
    """
    n_known, n_salient = truth.n_known, truth.n_salient
    n_above = hits + alarms
    misses, rejections = n_salient - hits, n_known - n_salient - alarms
    if n_salient == 0:
        aligned = n_known - n_above
    elif n_salient == n_known:
        aligned = n_above
    else:
        above, below = 1 - n_above / n_known, -n_above / n_known
        salient, other = 1 - n_salient / n_known, -n_salient / n_known
        aligned = (
            hits * _alignment(above, salient)
            + alarms * _alignment(above, other)
            + misses * _alignment(below, salient)
            + rejections * _alignment(below, other)
        )
    e: Floats = aligned / (n_known - 1)
    return e


def _alignment(predicted: Floats, true: float) -> Floats:
    """Return how much two deviations from their means agree: 0 opposed, 1 equal."""
    alignment: Floats = 2 * predicted * true / (predicted**2 + true**2 + EPSILON)
    return (alignment + 1) ** 2 / 4
