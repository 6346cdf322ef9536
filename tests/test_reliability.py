"""The expected calibration error, against a plain loop."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.evaluation import Reliability


def expected_error(told, is_salient, n_bins) -> float:
    total = 0.0
    for low in range(n_bins):
        here = (told * n_bins >= low) & ((told * n_bins < low + 1) | (low == n_bins - 1))
        if here.any():
            total += here.mean() * abs(told[here].mean() - is_salient[here].mean())
    return total


def test_it_is_the_mean_distance_of_15_bins() -> None:
    rng = np.random.default_rng(0)
    maps = rng.random((3, 20, 30)).astype(np.float32)
    maps[0, 0, :2] = 0, 1
    truths = rng.choice(np.array([0, 125, 255], np.uint8), maps.shape)
    reliability = Reliability()
    for told, truth in zip(maps, truths, strict=True):
        reliability.add(told, truth)
    known = truths != 125
    expected = expected_error(maps[known].astype(float), truths[known] == 255, 15)
    assert reliability.expected_error == pytest.approx(expected)
    table = reliability.table()
    assert len(table["bins"]) == 15
    assert sum(one["n_px"] for one in table["bins"]) == known.sum()


def test_what_is_told_right_has_no_error_and_nothing_known_none() -> None:
    reliability = Reliability()
    reliability.add(np.full((2, 2), 0.5, np.float32), np.full((2, 2), 125, np.uint8))
    assert reliability.expected_error is None
    assert reliability.curve.shape == (0, 2)
    reliability.add(np.full((2, 2), 0.5, np.float32), np.array([[0, 0], [255, 255]], np.uint8))
    assert reliability.expected_error == 0
    assert reliability.curve.tolist() == [[0.5, 0.5]]
    with pytest.raises(ValueError, match="truth"):
        reliability.add(np.zeros((2, 2), np.float32), np.zeros((2, 3), np.uint8))
