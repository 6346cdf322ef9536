"""Frequency-tuned saliency against the original's maps, and CIELab against its definition."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from curiosight.evaluation.baselines.frequency_tuned import cielab, frequency_tuned
from golden_maps import IMAGES, assert_equals_golden, golden_input


@pytest.mark.parametrize("image", IMAGES)
def test_equals_the_original(image: str) -> None:
    saliency = frequency_tuned(golden_input(image))
    assert_equals_golden(saliency, "ft_achanta", image, pearson=0.99999, levels=1)


@pytest.mark.parametrize(
    ("rgb", "lab"),
    [
        ((255, 255, 255), (100, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
        ((255, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 128, 0), (46.23, -51.70, 49.90)),
        ((3, 2, 1), (0.59, 0.12, 0.47)),
    ],
)
def test_cielab_of_known_colours(rgb: tuple[int, ...], lab: tuple[float, ...]) -> None:
    image = np.full((2, 2, 3), rgb, np.uint8)
    assert cielab(image)[0, 0] == pytest.approx(lab, abs=0.02)


def test_what_has_a_rare_colour_stands_out() -> None:
    rgb = np.full((60, 80, 3), (60, 90, 160), np.uint8)
    cv2.rectangle(rgb, (30, 20), (50, 40), (220, 60, 20), -1)
    saliency = frequency_tuned(rgb)
    assert saliency[22:38, 32:48] == pytest.approx(1)
    assert saliency[:18].max() < 0.1
