"""Errors and rankings, against slow references and scikit-learn."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from curiosight.metrics import (
    Counts,
    Scores,
    count_pixels,
    count_rows,
    f1_error,
    f1_error_of_rows,
)

label_maps = arrays(np.uint8, (6, 8), elements=st.sampled_from([0, 75, 125, 255]))
saliency_maps = arrays(np.float32, (6, 8), elements=st.sampled_from([0, 0.3, 0.5, 0.6, 1]))


@given(label_maps, saliency_maps, st.sampled_from([0.0, 0.5, 0.55]))
def test_error_is_that_of_a_pixel_by_pixel_count(labels, saliency, threshold) -> None:
    tp = fp = fn = 0
    for label, score in zip(labels.ravel(), saliency.ravel(), strict=True):
        tp += label == 255 and score > threshold
        fp += label == 0 and score > threshold
        fn += label == 255 and score <= threshold
    error = f1_error(labels, saliency, threshold)
    if 255 in labels:
        assert error == pytest.approx(1 - 2 * tp / (2 * tp + fp + fn))
    else:
        assert error is None


@given(label_maps, arrays(np.int32, (6, 8), elements=st.integers(0, 4)), st.integers(0, 99))
def test_rows_give_exactly_the_error_of_their_pixels(labels, superpixels, seed) -> None:
    scores = np.random.default_rng(seed).choice(np.float32([0, 0.4, 0.5, 0.6, 1]), 5)
    n_salient = np.bincount(superpixels[labels == 255], minlength=5)
    n_not_salient = np.bincount(superpixels[labels == 0], minlength=5)
    saliency = scores[superpixels]
    assert count_rows(n_salient, n_not_salient, scores) == count_pixels(labels, saliency)
    assert f1_error_of_rows(n_salient, n_not_salient, scores) == f1_error(labels, saliency)


def test_score_at_the_threshold_is_not_salient() -> None:
    labels = np.array([[255, 0]], np.uint8)
    assert f1_error(labels, np.array([[0.5, 0.5]], np.float32)) == 1
    assert f1_error(labels, np.array([[0.6, 0.5]], np.float32)) == 0


@pytest.mark.parametrize("code", [0, 75, 125])
def test_error_is_undefined_without_a_salient_pixel(code: int) -> None:
    labels = np.full((4, 4), code, np.uint8)
    assert f1_error(labels, np.ones((4, 4), np.float32)) is None


def test_counts_know_their_error() -> None:
    assert Counts(tp=3, fp=1, fn=1, tn=90).f1_error == pytest.approx(0.25)
    assert Counts(tp=0, fp=5, fn=0, tn=0).f1_error is None


def test_error_of_maps_that_differ_in_size_is_refused() -> None:
    with pytest.raises(ValueError, match=r"saliency: expected \(2, 2\) like labels, got \(3, 3\)"):
        f1_error(np.zeros((2, 2), np.uint8), np.zeros((3, 3), np.float32))


def frames(kind: str, n_frames: int = 4) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Make (saliency, is_positive, mask) with many ties ("votes") or hardly any ("smooth")."""
    rng = np.random.default_rng(0)
    made = []
    for _ in range(n_frames):
        is_positive = rng.random((20, 30)) < 0.2
        saliency = rng.random((20, 30)) * 0.7 + 0.3 * is_positive
        if kind == "votes":
            saliency = np.round(saliency * 30) / 30
        made.append((saliency.astype(np.float32), is_positive, rng.random((20, 30)) < 0.8))
    return made


@pytest.mark.parametrize("kind", ["votes", "smooth"])
@pytest.mark.parametrize("band_size", [50, 1_000_000], ids=["in bands", "at once"])
def test_ranking_agrees_with_scikit_learn(
    kind: str, band_size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    reference = pytest.importorskip("sklearn.metrics")
    monkeypatch.setattr("curiosight.metrics._BAND_SIZE", band_size)
    scores = Scores()
    for saliency, is_positive, mask in frames(kind):
        scores.add(saliency, is_positive, mask)
    ranking = scores.ranking(threshold=0.4)
    truth = np.concatenate([is_positive[mask] for _, is_positive, mask in frames(kind)])
    pooled = np.concatenate([saliency[mask] for saliency, _, mask in frames(kind)])
    assert ranking.roc_auc == pytest.approx(reference.roc_auc_score(truth, pooled), abs=1e-12)
    expected = reference.average_precision_score(truth, pooled)
    assert ranking.average_precision == pytest.approx(expected, abs=1e-12)
    assert ranking.f1 == pytest.approx(reference.f1_score(truth, pooled > 0.4))
    precision, recall, _ = reference.precision_recall_curve(truth, pooled)
    best = (2 * precision * recall / np.maximum(precision + recall, 1e-12)).max()
    assert ranking.best_f1 == pytest.approx(best)
    reached = reference.f1_score(truth, pooled > ranking.best_threshold)
    assert reached == pytest.approx(ranking.best_f1)
    assert (ranking.n_positive, ranking.n_negative) == (truth.sum(), (~truth).sum())


@given(
    arrays(np.float32, 30, elements=st.sampled_from([0, 0.25, 0.5, 1])),
    arrays(np.bool_, 30).filter(lambda is_positive: 0 < is_positive.sum() < 30),
)
def test_auc_is_the_chance_that_a_positive_beats_a_negative(saliency, is_positive) -> None:
    scores = Scores()
    scores.add(saliency, is_positive)
    differences = saliency[is_positive][:, None] - saliency[~is_positive]
    expected = np.mean((differences > 0) + 0.5 * (differences == 0))
    assert scores.ranking().roc_auc == pytest.approx(expected)


def test_swapping_the_classes_and_the_order_keeps_the_auc() -> None:
    forward, backward = Scores(), Scores()
    for saliency, is_positive, mask in frames("votes"):
        forward.add(saliency, is_positive, mask)
        backward.add(1 - saliency, ~is_positive, mask)
    assert forward.ranking().roc_auc == pytest.approx(backward.ranking().roc_auc)


def test_roc_is_thinned_but_keeps_its_ends_and_area() -> None:
    scores = Scores()
    for saliency, is_positive, mask in frames("smooth"):
        scores.add(saliency, is_positive, mask)
    ranking = scores.ranking(n_roc_points=50)
    assert 25 < len(ranking.roc) < 60
    np.testing.assert_array_equal(ranking.roc[[0, -1]], [(0, 0), (1, 1)])
    assert (np.diff(ranking.roc, axis=0) >= 0).all()
    assert np.trapezoid(ranking.roc[:, 1], ranking.roc[:, 0]) == pytest.approx(
        ranking.roc_auc, abs=0.005
    )


def test_asking_twice_or_in_between_changes_nothing() -> None:
    once, often = Scores(), Scores()
    for saliency, is_positive, mask in frames("votes"):
        once.add(saliency, is_positive, mask)
        often.add(saliency, is_positive, mask)
        often.ranking()
    assert often.ranking().roc_auc == once.ranking().roc_auc
    assert often.ranking().average_precision == once.ranking().average_precision


@pytest.mark.parametrize("n_negative", [0, 5])
def test_nothing_is_defined_without_a_positive(n_negative: int) -> None:
    scores = Scores()
    scores.add(np.full(n_negative, 0.7, np.float32), np.zeros(n_negative, bool))
    ranking = scores.ranking()
    undefined = ("roc_auc", "average_precision", "best_f1", "best_threshold", "f1")
    assert [getattr(ranking, name) for name in undefined] == [None] * 5
    assert (ranking.roc.shape, ranking.n_negative) == ((0, 2), n_negative)


def test_without_a_negative_only_the_auc_is_undefined() -> None:
    scores = Scores()
    scores.add(np.float32([0.2, 0.9]), np.array([True, True]))
    ranking = scores.ranking()
    assert (ranking.roc_auc, len(ranking.roc)) == (None, 0)
    assert (ranking.average_precision, ranking.best_f1) == (1, 1)
    assert ranking.best_threshold < 0.2
    assert ranking.f1 == pytest.approx(2 / 3)


def test_bad_scores_are_refused() -> None:
    scores = Scores()
    saliency = np.float32([0.1, np.nan])
    with pytest.raises(ValueError, match="scores: expected finite"):
        scores.add(saliency, np.array([True, False]))
    with pytest.raises(ValueError, match=r"is_positive: expected \(2,\) bool, got \(2,\) uint8"):
        scores.add(saliency, np.array([255, 0], np.uint8))


def test_maps_of_few_values_need_little_memory() -> None:
    scores = Scores()
    rng = np.random.default_rng(0)
    tracemalloc.start()
    for _ in range(4):
        saliency = rng.integers(0, 31, (480, 640)).astype(np.float32) / 30
        scores.add(saliency, saliency > rng.random(saliency.shape, np.float32))
    del saliency
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 100_000
    assert scores.ranking().n_positive + scores.ranking().n_negative == 4 * 480 * 640
