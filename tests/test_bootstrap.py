"""Intervals of resampled frames: coverage, repeatability, figures of many kinds."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.evaluation.bootstrap import Interval, bootstrap_interval
from curiosight.evaluation.score_histograms import roc_auc, score_histogram


def seeded(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def frame_histograms(n_frames: int, rng: np.random.Generator, n_levels: int = 64) -> np.ndarray:
    """Return histograms of frames that differ in how well their objects stand out."""
    truth = np.zeros((20, 20), np.uint8)
    truth[5:12, 4:14] = 255
    histograms = []
    for lift in rng.uniform(0, 0.4, n_frames):
        saliency = 0.6 * rng.random(truth.shape) + lift * (truth == 255)
        histograms.append(score_histogram(saliency, truth, n_levels=n_levels))
    return np.stack(histograms)


def test_interval_covers_the_true_mean_as_often_as_it_says() -> None:
    rng = seeded(1)
    n_covered = 0
    for _ in range(400):
        low, high = bootstrap_interval(
            rng.exponential(size=60), float, rng, n_resamples=300, confidence=0.9
        )
        n_covered += low <= 1 <= high
    # Of 400, 360 +- 6 are expected; percentiles of a skewed mean cover slightly less.
    assert 335 <= n_covered <= 375


def test_interval_covers_the_pooled_auc_of_many_frames() -> None:
    rng = seeded(2)
    truth = roc_auc(frame_histograms(4000, rng).sum(axis=0))
    n_covered = 0
    for _ in range(100):
        interval = bootstrap_interval(frame_histograms(30, rng), roc_auc, rng, n_resamples=200)
        n_covered += interval.low <= truth <= interval.high
    assert 85 <= n_covered <= 100


def test_width_is_that_of_the_normal_approximation() -> None:
    values = seeded(3).normal(size=200)
    low, high = bootstrap_interval(values, float, seeded(), n_resamples=4000)
    standard_error = values.std() / np.sqrt(200)
    assert high - low == pytest.approx(2 * 1.96 * standard_error, rel=0.05)
    assert (low + high) / 2 == pytest.approx(values.mean(), abs=0.2 * standard_error)


def test_plain_resampling_of_pixels_gives_the_same_interval() -> None:
    histograms = frame_histograms(12, seeded(4))
    fast = bootstrap_interval(histograms, roc_auc, seeded(5), n_resamples=300)
    drawn = seeded(5).multinomial(12, np.full(12, 1 / 12), 300)
    plain = [roc_auc(np.repeat(histograms, times, axis=0).sum(axis=0)) for times in drawn]
    assert fast == pytest.approx(tuple(np.quantile(plain, [0.025, 0.975])), abs=1e-12)


def test_same_seed_same_bytes() -> None:
    histograms = frame_histograms(10, seeded(6))
    first = bootstrap_interval(histograms, roc_auc, seeded(7))
    assert (
        np.array(first).tobytes()
        == np.array(bootstrap_interval(histograms, roc_auc, seeded(7))).tobytes()
    )
    assert first != bootstrap_interval(histograms, roc_auc, seeded(8))


def test_batches_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    histograms = frame_histograms(10, seeded(6))
    whole = bootstrap_interval(histograms, roc_auc, seeded(7), n_resamples=50)
    monkeypatch.setattr("curiosight.evaluation.bootstrap._BATCH_SIZE", 1000)
    assert bootstrap_interval(histograms, roc_auc, seeded(7), n_resamples=50) == whole


def test_more_confidence_is_wider() -> None:
    values = seeded(9).random(40)
    intervals = [
        bootstrap_interval(values, float, seeded(), confidence=c) for c in (0.5, 0.9, 0.99)
    ]
    widths = [interval.high - interval.low for interval in intervals]
    assert widths[0] < widths[1] < widths[2]


def test_methods_are_compared_on_the_same_frames() -> None:
    difficulty = seeded(10).normal(size=50)
    pairs = np.stack([difficulty, difficulty + 0.1], axis=1)
    interval = bootstrap_interval(pairs, lambda mean: mean[1] - mean[0], seeded())
    assert interval == pytest.approx((0.1, 0.1))


def test_resamples_without_a_figure_are_left_out() -> None:
    # Resamples of the first two frames alone have nothing salient.
    histograms = np.array([[[1, 1], [0, 0]], [[1, 1], [0, 0]], [[1, 0], [0, 1]]])
    low, high = bootstrap_interval(histograms, roc_auc, seeded())
    assert 0.5 < low <= high <= 1
    assert bootstrap_interval(histograms[:2], roc_auc, seeded()) is None


@pytest.mark.parametrize("values", [[], [0.5]])
def test_fewer_than_two_frames_have_no_interval(values) -> None:
    assert bootstrap_interval(values, float, seeded()) is None


def test_equal_frames_leave_no_doubt() -> None:
    assert bootstrap_interval([0.25] * 8, float, seeded()) == Interval(0.25, 0.25)


@pytest.mark.parametrize(
    ("per_frame", "options", "message"),
    [
        ([0.1, np.nan], {}, "per_frame: expected"),
        (0.5, {}, "per_frame: expected"),
        ([0.1, 0.2], {"n_resamples": 0}, "n_resamples: expected 1 or more, got 0"),
        ([0.1, 0.2], {"confidence": 1.0}, "confidence: expected .* got 1.0"),
    ],
)
def test_bad_arguments_are_refused(per_frame, options, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        bootstrap_interval(np.array(per_frame), float, seeded(), **options)
