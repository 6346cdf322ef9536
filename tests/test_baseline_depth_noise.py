"""Depth labels as a map: certain where the teacher is, noise elsewhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from curiosight.evaluation.baselines.depth_noise import depth_noise
from curiosight.evaluation.score_histograms import roc_auc, score_histogram
from curiosight.frame import Label

SIZE = (240, 320)


def test_only_what_is_known_is_certain() -> None:
    labels = np.array([[255, 0, 125], [75, 255, 0]], np.uint8)
    saliency = depth_noise(labels, np.random.default_rng(0))
    assert saliency.dtype == np.float32
    assert saliency[labels == Label.SALIENT].tolist() == [1, 1]
    assert saliency[labels == Label.NOT_SALIENT].tolist() == [0, 0]
    noise = saliency[0, 2], saliency[1, 0]
    assert all(0 < value < 1 for value in noise)
    assert noise[0] != noise[1]


@pytest.mark.parametrize("label", [Label.UNKNOWN, Label.UNAVAILABLE])
def test_noise_is_uniform_and_tells_nothing(label: Label) -> None:
    saliency = depth_noise(np.full(SIZE, label, np.uint8), np.random.default_rng(1))
    shares = np.histogram(saliency, bins=10, range=(0, 1))[0] / saliency.size
    assert shares == pytest.approx(0.1, abs=0.01)
    truth = np.zeros(SIZE, np.uint8)
    truth[:, :100] = 255
    assert roc_auc(score_histogram(saliency, truth)) == pytest.approx(0.5, abs=0.01)


def test_a_perfect_half_and_noise_have_the_area_of_both() -> None:
    truth = np.zeros(SIZE, np.uint8)
    truth[::2] = 255
    labels = truth.copy()
    labels[:, ::2] = Label.UNKNOWN
    saliency = depth_noise(labels, np.random.default_rng(2))
    # Of the pairs of a salient and another pixel, only noise against noise goes wrong, half of it.
    assert roc_auc(score_histogram(saliency, truth)) == pytest.approx(1 - 1 / 8, abs=0.01)


def test_the_same_generator_makes_the_same_map() -> None:
    labels = np.full(SIZE, Label.UNKNOWN, np.uint8)
    first = depth_noise(labels, np.random.default_rng(3))
    assert np.array_equal(depth_noise(labels, np.random.default_rng(3)), first)
    rng = np.random.default_rng(3)
    labels[:10] = Label.SALIENT
    assert np.array_equal(depth_noise(labels, rng)[10:], first[10:])
    assert not np.array_equal(depth_noise(labels, rng)[10:], first[10:])


def test_labels_stay_as_they_are() -> None:
    labels = np.full((2, 2), Label.UNKNOWN, np.uint8)
    depth_noise(labels, np.random.default_rng(0))
    assert (labels == Label.UNKNOWN).all()


@pytest.mark.parametrize("size", [(1, 1), (0, 3)])
def test_images_may_be_tiny(size: tuple[int, int]) -> None:
    labels = np.full(size, Label.SALIENT, np.uint8)
    assert np.array_equal(depth_noise(labels, np.random.default_rng(0)), np.ones(size))


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (np.zeros((2, 2), np.int64), r"labels: expected \(H, W\) uint8, got \(2, 2\) int64"),
        (np.zeros((2, 2, 3), np.uint8), r"labels: expected \(H, W\) uint8, got \(2, 2, 3\)"),
        (np.full((2, 2), 1, np.uint8), "labels: expected only 0, 75, 125, 255, got 1"),
    ],
)
def test_what_is_no_label_image_is_refused(labels: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        depth_noise(labels, np.random.default_rng(0))
