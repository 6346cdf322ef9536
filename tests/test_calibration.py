"""Where salient begins, and how probable it is, against plain references."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.evaluation import Reliability
from curiosight.learner.calibration import MIN_FRAMES, N_BINS, Calibration


def frame_of(rng, n=4000, *, sharpness=6.0):
    """Return scores of pixels and whether they are salient: the likelier, the higher."""
    scores = rng.random(n).astype(np.float32) ** 2
    is_salient = rng.random(n) < 1 / (1 + np.exp(-sharpness * (scores - 0.7)))
    return scores, is_salient


def calibrated(rng, n_frames=20, **kind) -> Calibration:
    calibration = Calibration()
    for _ in range(n_frames):
        scores, is_salient = frame_of(rng, **kind)
        calibration.add(scores, is_salient, ~is_salient, forgets=False)
    return calibration


def rising(part, whole):
    """Isotonic regression as its min-max formula has it."""
    found = []
    for k in range(len(part)):
        starts = [
            min(part[i:j].sum() / whole[i:j].sum() for j in range(k + 1, len(part) + 1))
            for i in range(k + 1)
        ]
        found.append(max(starts))
    return np.array(found)


def f1_above(threshold, scores, is_salient) -> float:
    predicted = scores > threshold
    return 2 * (predicted & is_salient).sum() / (predicted.sum() + is_salient.sum())


def test_half_of_a_scaled_score_is_the_decision_with_the_best_f1() -> None:
    rng = np.random.default_rng(0)
    calibration = calibrated(rng)
    scores, is_salient = frame_of(rng, 50_000)
    best = max(f1_above(level, scores, is_salient) for level in np.linspace(0, 1, 200))
    at_half = f1_above(0.5, calibration.scaled(scores), is_salient)
    assert f1_above(0.5, scores, is_salient) < best - 0.01  # unscaled it is another
    assert at_half > best - 0.01


def test_scaling_keeps_the_order_and_the_ends() -> None:
    calibration = calibrated(np.random.default_rng(1))
    scaled = calibration.scaled(np.linspace(0, 1, 1001, dtype=np.float32))
    assert (np.diff(scaled) > 0).all()
    assert (scaled[0], scaled[-1]) == (0, 1)


def test_probabilities_hold_on_pixels_that_were_not_learned_from() -> None:
    rng = np.random.default_rng(2)
    calibration = calibrated(rng)
    scores, is_salient = frame_of(rng, 100_000)
    told = Reliability()
    told.add(calibration.probability(scores), np.where(is_salient, 255, 0).astype(np.uint8))
    unscaled = Reliability()
    unscaled.add(scores, np.where(is_salient, 255, 0).astype(np.uint8))
    assert told.expected_error < 0.02 < unscaled.expected_error


def test_probabilities_are_those_of_isotonic_regression_and_rise_everywhere() -> None:
    rng = np.random.default_rng(3)
    calibration = calibrated(rng, 60, sharpness=2.0)
    other, salient = calibration.counts
    centres = (np.arange(N_BINS) + 0.5) / N_BINS
    # Next to nothing in each bin, so that an empty one has a share.
    reference = rising(salient + 1e-6, salient + other + 2e-6)
    told = calibration.probability(centres.astype(np.float32))
    assert np.abs(told - reference).max() < 0.1
    assert np.average(np.abs(told - reference), weights=other + salient) < 0.01
    fine = calibration.probability(np.linspace(0, 1, 500, dtype=np.float32))
    assert (np.diff(fine) > 0).all()
    assert fine.min() >= 0
    assert fine.max() <= 1


def test_too_few_frames_and_frames_of_one_class_change_nothing() -> None:
    rng = np.random.default_rng(4)
    calibration = calibrated(rng, MIN_FRAMES - 1)
    nothing = np.zeros(4000, np.bool_)
    for _ in range(5):
        calibration.add(frame_of(rng)[0], nothing, ~nothing)
    scores = np.linspace(0, 1, 100, dtype=np.float32)
    assert calibration.threshold == 0.5
    assert np.array_equal(calibration.scaled(scores), scores)
    assert np.array_equal(calibration.probability(scores), scores)


def test_earlier_frames_count_less_where_it_forgets() -> None:
    rng = np.random.default_rng(5)
    calibration = calibrated(rng, 20)
    before = calibration.threshold
    for _ in range(400):
        scores = rng.random(500).astype(np.float32)
        is_salient = scores > 0.3
        calibration.add(scores, is_salient, ~is_salient)
    assert before > 0.45
    assert calibration.threshold == pytest.approx(0.3, abs=0.03)


def test_it_is_kept_and_restored() -> None:
    calibration, other = calibrated(np.random.default_rng(6)), Calibration()
    other.restore(calibration.state_arrays())
    scores = np.linspace(0, 1, 100, dtype=np.float32)
    assert np.array_equal(other.probability(scores), calibration.probability(scores))
    with pytest.raises(ValueError, match="calibration"):
        other.restore({"calibration": np.zeros((2, 3)), "calibration_frames": np.array(1.0)})
