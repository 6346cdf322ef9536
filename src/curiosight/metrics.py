"""Score saliency against labels: the error of eq. (1), and rankings over every threshold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Label

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Floats32 = npt.NDArray[np.float32]

_BAND_SIZE = 1_000_000  # scores; bounds the memory of a ranking


@dataclass(frozen=True, slots=True)
class Counts:
    """Labelled pixels by what they are and what they were predicted to be."""

    tp: int
    fp: int
    fn: int
    tn: int

    @property
    def f1_error(self) -> float | None:
        """1 - F1 (eq. 1); None where no pixel is labelled salient: F1 would say nothing."""
        if self.tp + self.fn == 0:
            return None
        return 1 - 2 * self.tp / (2 * self.tp + self.fp + self.fn)


def count_pixels(
    labels: npt.NDArray[np.uint8], saliency: npt.NDArray[np.floating], threshold: float = 0.5
) -> Counts:
    """Count a map's hits and misses on the pixels labelled salient or not salient.

    labels: 255 salient, 0 not salient, anything else ignored; same shape as `saliency`.
    threshold: salient is what scores above it.
    """
    if labels.shape != saliency.shape:
        raise ValueError(f"saliency: expected {labels.shape} like labels, got {saliency.shape}")
    predicted = saliency > threshold
    n_salient, tp = _count(labels == Label.SALIENT, predicted)
    n_not_salient, fp = _count(labels == Label.NOT_SALIENT, predicted)
    return Counts(tp=tp, fp=fp, fn=n_salient - tp, tn=n_not_salient - fp)


def count_rows(
    n_salient: npt.NDArray[np.integer],
    n_not_salient: npt.NDArray[np.integer],
    scores: npt.NDArray[np.floating],
    threshold: float = 0.5,
) -> Counts:
    """Count as `count_pixels`, where row i stands for pixels that all score `scores[i]`.

    n_salient, n_not_salient: (n,) labelled pixels of each row.
    """
    predicted = scores > threshold
    tp, fp = int(n_salient[predicted].sum()), int(n_not_salient[predicted].sum())
    return Counts(tp=tp, fp=fp, fn=int(n_salient.sum()) - tp, tn=int(n_not_salient.sum()) - fp)


def f1_error(
    labels: npt.NDArray[np.uint8], saliency: npt.NDArray[np.floating], threshold: float = 0.5
) -> float | None:
    """Return 1 - F1 of a map (eq. 1); None where no pixel is labelled salient."""
    return count_pixels(labels, saliency, threshold).f1_error


def f1_error_of_rows(
    n_salient: npt.NDArray[np.integer],
    n_not_salient: npt.NDArray[np.integer],
    scores: npt.NDArray[np.floating],
    threshold: float = 0.5,
) -> float | None:
    """Return 1 - F1 (eq. 1) from rows as in `count_rows`: the same number, sooner."""
    return count_rows(n_salient, n_not_salient, scores, threshold).f1_error


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """How well scores order positives above negatives, over every threshold.

    roc_auc: None without a positive or without a negative.
    average_precision: None without a positive, like the F1s.
    best_f1, best_threshold: the highest F1, and a threshold: what scores above it is positive.
    f1: at the threshold that was asked for.
    roc: (n, 2) false and true positive rates from (0, 0) to (1, 1); empty without roc_auc.
    n_positive, n_negative: pixels.
    """

    roc_auc: float | None
    average_precision: float | None
    best_f1: float | None
    best_threshold: float | None
    f1: float | None
    roc: Floats
    n_positive: float
    n_negative: float


class Scores:
    """Collect the scores of positive and negative pixels, frame by frame.

    Equal scores of a frame are kept once, with their number: a saliency map has few different
    values, so a long recording fits in little memory. Scores are kept as float32, and so are
    numbers (exact up to 16 million).
    """

    def __init__(self) -> None:
        self._positive = _Pool()
        self._negative = _Pool()

    def add(
        self, saliency: npt.NDArray[np.floating], is_positive: Bools, mask: Bools | None = None
    ) -> None:
        """Add the pixels of one map; mask: those that count, None = all."""
        is_used = np.ones(saliency.shape, np.bool_) if mask is None else mask
        for name, array in (("is_positive", is_positive), ("mask", is_used)):
            if array.shape != saliency.shape or array.dtype != np.bool_:
                found = f"{array.shape} {array.dtype}"
                raise ValueError(f"{name}: expected {saliency.shape} bool, got {found}")
        for pool, chosen in ((self._positive, is_positive), (self._negative, ~is_positive)):
            pool.add(*np.unique(saliency[chosen & is_used], return_counts=True))

    def ranking(self, *, threshold: float = 0.5, n_roc_points: int = 200) -> Ranking:
        """Return the metrics of all scores so far, pooled over frames (sec. III-A).

        Everything is exact, ties included; only the ROC points are thinned, to about
        `n_roc_points`.
        """
        sweep = _Sweep(self._positive.total(), self._negative.total(), threshold, n_roc_points)
        for high, low in pairwise(self._falling_edges()):
            pools = [pool.within(low, high) for pool in (self._positive, self._negative)]
            values = np.union1d(pools[0][0], pools[1][0])
            weights = np.zeros((2, len(values)))
            for row, (scores, pooled) in zip(weights, pools, strict=True):
                row[np.searchsorted(values, scores)] = pooled
            if len(values):
                sweep.lower(values[::-1], weights[0, ::-1], weights[1, ::-1])
        return sweep.ranking()

    def _falling_edges(self) -> list[float]:
        """Cut the scores into bands, highest first, small enough to be sorted one by one."""
        pieces = self._positive.scores + self._negative.scores
        n_bands = 1 + sum(map(len, pieces)) // _BAND_SIZE
        if n_bands == 1:
            return [np.inf, -np.inf]
        sample = np.concatenate([piece[:: 10 * n_bands] for piece in pieces])
        cuts = np.unique(np.quantile(sample, np.arange(1, n_bands) / n_bands))
        return [np.inf, *cuts[::-1].tolist(), -np.inf]


class _Sweep:
    """Lower a threshold over all scores and sum up what each value adds."""

    def __init__(
        self, n_positive: float, n_negative: float, threshold: float, n_roc_points: int
    ) -> None:
        self._n_positive = n_positive
        self._n_negative = n_negative
        self._threshold = threshold
        self._n_roc_points = n_roc_points
        self._tp = self._fp = 0.0
        self._pairs_won = 0.0
        self._precision_sum = 0.0
        self._f1 = self._best_f1 = 0.0
        self._best_threshold = 0.0
        self._roc = [np.zeros((1, 2))]

    def lower(self, values: Floats32, positive: Floats, negative: Floats) -> None:
        """Pass over the next values, falling, with the weights of the two classes there."""
        tp, fp = self._tp + np.cumsum(positive), self._fp + np.cumsum(negative)
        self._tp, self._fp = tp[-1], fp[-1]
        self._precision_sum += float(positive @ (tp / (tp + fp)))
        # Each negative loses against the positives above it, and half against its equals.
        self._pairs_won += float(negative @ (tp - positive / 2))
        f1 = 2 * tp / (tp + fp + self._n_positive)
        if n_above := np.count_nonzero(values > self._threshold):
            self._f1 = float(f1[n_above - 1])
        best = np.argmax(f1)
        if f1[best] > self._best_f1:
            self._best_f1 = float(f1[best])
            self._best_threshold = float(np.nextafter(values[best], np.float32(-np.inf)))
        if self._n_positive and self._n_negative:
            self._roc.append(self._thin_roc(fp / self._n_negative, tp / self._n_positive))

    def ranking(self) -> Ranking:
        """Return the metrics, once every value was passed."""
        n_positive, n_negative = self._n_positive, self._n_negative
        has_positive, has_both = n_positive > 0, n_positive > 0 and n_negative > 0
        return Ranking(
            roc_auc=self._pairs_won / (n_positive * n_negative) if has_both else None,
            average_precision=self._precision_sum / n_positive if has_positive else None,
            best_f1=self._best_f1 if has_positive else None,
            best_threshold=self._best_threshold if has_positive else None,
            f1=self._f1 if has_positive else None,
            roc=np.concatenate(self._roc) if has_both else np.empty((0, 2)),
            n_positive=n_positive,
            n_negative=n_negative,
        )

    def _thin_roc(self, false_positive_rate: Floats, true_positive_rate: Floats) -> Floats:
        """Return the last point in each of `n_roc_points` steps along the curve."""
        points = np.stack([false_positive_rate, true_positive_rate], axis=1)
        step = np.floor(points.sum(axis=1) / 2 * self._n_roc_points)
        is_last = np.diff(step, append=np.inf) > 0
        thinned: Floats = points[is_last]
        return thinned


class _Pool:
    """Scores with weights: one piece for each addition, its scores rising."""

    def __init__(self) -> None:
        self.scores: list[Floats32] = []
        self._weights: list[Floats32] = []

    def add(self, scores: npt.NDArray[np.floating], weights: npt.NDArray[Any]) -> None:
        if not np.isfinite(scores).all():
            raise ValueError("scores: expected finite numbers, got NaN or infinity")
        order = np.argsort(scores)
        self.scores.append(scores[order].astype(np.float32))
        self._weights.append(weights[order].astype(np.float32))

    def total(self) -> float:
        return float(sum(weights.sum(dtype=np.float64) for weights in self._weights))

    def within(self, low: float, high: float) -> tuple[Floats32, Floats]:
        """Return the distinct scores in [low, high), rising, and the total weight of each."""
        ends = np.array([low, high], np.float32)
        bands = [slice(*np.searchsorted(scores, ends).tolist()) for scores in self.scores]
        scores = _join(self.scores, bands)
        order = np.argsort(scores)
        scores = scores[order]
        weights = _join(self._weights, bands)[order]
        starts = np.flatnonzero(np.diff(scores, prepend=np.float32(-np.inf)))
        return scores[starts], np.add.reduceat(weights, starts, dtype=np.float64)


def _join(pieces: Sequence[Floats32], bands: Sequence[slice]) -> Floats32:
    """Concatenate one band of each piece."""
    return np.concatenate(
        [np.empty(0, np.float32), *(piece[band] for piece, band in zip(pieces, bands, strict=True))]
    )


def _count(is_labelled: Bools, predicted: Bools) -> tuple[int, int]:
    """Return how many pixels have the label, and how many of them are predicted salient."""
    return int(np.count_nonzero(is_labelled)), int(np.count_nonzero(is_labelled & predicted))
