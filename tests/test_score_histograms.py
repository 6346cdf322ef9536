"""Histograms of scores, against the exact ranking and scikit-learn."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.metrics import average_precision_score, precision_recall_curve, roc_auc_score

from curiosight.evaluation.score_histograms import (
    average_precision,
    precision_recall,
    roc_auc,
    score_histogram,
)
from curiosight.metrics import Scores

SIZE = (30, 40)


@pytest.fixture
def truth() -> np.ndarray:
    labels = np.random.default_rng(0).choice([255, 0, 0, 125], SIZE)
    return labels.astype(np.uint8)


@pytest.fixture
def saliency(truth) -> np.ndarray:
    """Scores that 256 levels hold exactly, with ties."""
    noise = np.random.default_rng(1).integers(0, 200, SIZE)
    return ((noise + 40 * (truth == 255)) / 255).astype(np.float32)


def test_figures_are_scikit_learns(truth, saliency) -> None:
    histogram = score_histogram(saliency, truth, n_levels=256)
    known = truth != 125
    is_salient, scores = truth[known] == 255, saliency[known]
    assert roc_auc(histogram) == pytest.approx(roc_auc_score(is_salient, scores))
    assert average_precision(histogram) == pytest.approx(
        average_precision_score(is_salient, scores)
    )
    precision, recall, _ = precision_recall_curve(is_salient, scores)
    expected = np.stack([recall, precision], axis=1)[-2::-1]
    np.testing.assert_allclose(precision_recall(histogram), expected)


def test_default_levels_come_near_the_exact_ranking(truth) -> None:
    noise = np.random.default_rng(2).random(SIZE)
    saliency = (0.8 * noise + 0.2 * (truth == 255)).astype(np.float32)
    scores = Scores()
    scores.add(saliency, truth == 255, truth != 125)
    exact, histogram = scores.ranking(), score_histogram(saliency, truth)
    assert roc_auc(histogram) == pytest.approx(exact.roc_auc, abs=2e-4)
    assert average_precision(histogram) == pytest.approx(exact.average_precision, abs=1e-3)


def test_sums_of_histograms_are_those_of_pooled_pixels(truth, saliency) -> None:
    halves = [score_histogram(saliency[rows], truth[rows]) for rows in (slice(11), slice(11, None))]
    np.testing.assert_array_equal(sum(halves), score_histogram(saliency, truth))


def test_ends_of_the_range_are_counted() -> None:
    truth = np.array([[0, 255, 125]], np.uint8)
    histogram = score_histogram(np.array([[0.0, 1.0, 0.5]]), truth, n_levels=4)
    np.testing.assert_array_equal(histogram, [[1, 0, 0, 0], [0, 0, 0, 1]])
    assert roc_auc(histogram) == 1
    assert average_precision(histogram) == 1
    assert roc_auc(histogram[:, ::-1]) == 0


def test_constant_map_tells_nothing(truth) -> None:
    histogram = score_histogram(np.full(SIZE, 0.3), truth)
    share = (truth == 255).sum() / (truth != 125).sum()
    assert roc_auc(histogram) == 0.5
    assert average_precision(histogram) == pytest.approx(share)
    np.testing.assert_allclose(precision_recall(histogram), [[1, share]])


def test_empty_full_and_ignored_truth(saliency) -> None:
    for label, expected in ((0, None), (125, None), (255, 1.0)):
        histogram = score_histogram(saliency, np.full(SIZE, label, np.uint8))
        assert roc_auc(histogram) is None
        assert average_precision(histogram) == (expected and pytest.approx(expected))
        assert (len(precision_recall(histogram)) == 0) == (expected is None)


def test_bad_arguments_are_refused(truth, saliency) -> None:
    with pytest.raises(ValueError, match=r"saliency: expected \(30, 40\) .* got \(40, 30\)"):
        score_histogram(saliency.T, truth)
    with pytest.raises(ValueError, match="n_levels: expected 2 or more, got 1"):
        score_histogram(saliency, truth, n_levels=1)
    for bad in (np.nan, -0.1, 1.1):
        with pytest.raises(ValueError, match="saliency: expected numbers from 0 to 1"):
            score_histogram(np.where(truth == 0, bad, saliency), truth)
