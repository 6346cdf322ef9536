"""Scores of a frame as two short histograms, so that resampled frames are pooled by adding."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Label

Floats = npt.NDArray[np.float64]
Histogram = npt.NDArray[Any]  # (2, n_levels) pixels not salient and salient, or means of them


def score_histogram(
    saliency: npt.NDArray[np.floating], truth: npt.NDArray[np.uint8], *, n_levels: int = 4096
) -> npt.NDArray[np.int64]:
    """(2, n_levels): how many known pixels have each score, not salient and salient.

    saliency: (H, W) in [0, 1]; truth: (H, W): 255 salient, 0 not, else ignored.
    n_levels: what scores are rounded to; with 4096, figures move by about 1e-4.
    """
    if saliency.shape != truth.shape:
        raise ValueError(f"saliency: expected {truth.shape} like the truth, got {saliency.shape}")
    if n_levels < 2:
        raise ValueError(f"n_levels: expected 2 or more, got {n_levels}")
    if not ((saliency >= 0) & (saliency <= 1)).all():
        raise ValueError("saliency: expected numbers from 0 to 1")
    levels = np.rint(saliency * (n_levels - 1)).astype(np.int64)
    counts = [
        np.bincount(levels[truth == label], minlength=n_levels)
        for label in (Label.NOT_SALIENT, Label.SALIENT)
    ]
    return np.stack(counts)


def roc_auc(histogram: Histogram) -> float | None:
    """Return the area under the ROC curve; None where nothing, or everything, is salient."""
    not_salient, salient = np.asarray(histogram, np.float64)
    n_pairs = not_salient.sum() * salient.sum()
    if n_pairs == 0:
        return None
    n_above = np.cumsum(salient[::-1])[::-1] - salient
    return float(not_salient @ (n_above + salient / 2) / n_pairs)


def average_precision(histogram: Histogram) -> float | None:
    """Return the mean precision over the salient pixels; None where nothing is salient."""
    if not histogram[1].any():
        return None
    recall, precision = precision_recall(histogram).T
    return float(np.diff(recall, prepend=0.0) @ precision)


def precision_recall(histogram: Histogram) -> Floats:
    """(n, 2): recall and precision at each level that has pixels, the highest first.

    Empty where nothing is salient.
    """
    not_salient, salient = np.asarray(histogram, np.float64)[:, ::-1]
    if not salient.any():
        return np.empty((0, 2))
    is_used = not_salient + salient > 0
    hits, alarms = np.cumsum(salient[is_used]), np.cumsum(not_salient[is_used])
    return np.stack([hits / hits[-1], hits / (hits + alarms)], axis=1)
