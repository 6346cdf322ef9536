"""Itti-Koch: equal to the original toolbox; lone peaks; images with nothing in them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.evaluation.baselines.itti import itti, lone_peaks_raised
from golden_maps import IMAGES, assert_equals_golden, golden_input

Array = npt.NDArray[Any]


@pytest.mark.parametrize("image", IMAGES)
def test_equals_the_original(image: str) -> None:
    saliency = itti(golden_input(image))
    assert_equals_golden(saliency, "ittikoch_gbvs", image, pearson=0.999999, levels=1)


def with_peaks(*heights: float) -> Array:
    contrast = np.zeros((9, 30))
    contrast[4, 3 : 3 + 4 * len(heights) : 4] = heights
    return contrast


def test_one_peak_is_raised_above_one_of_several() -> None:
    np.testing.assert_allclose(lone_peaks_raised(with_peaks(1)), with_peaks(1) * 10 * 100)
    several = with_peaks(1, 0.5, 0.3)
    np.testing.assert_allclose(lone_peaks_raised(several), several * 10 * (10 - 6) ** 2)


def test_low_peaks_do_not_count() -> None:
    contrast = with_peaks(1, 0.09)
    np.testing.assert_allclose(lone_peaks_raised(contrast), contrast * 1000)
    np.testing.assert_allclose(lone_peaks_raised(with_peaks(0.09)), with_peaks(0.9))


def test_peaks_lie_inside_and_may_be_level() -> None:
    at_border = np.zeros((9, 30))
    at_border[0, 5] = 1
    np.testing.assert_allclose(lone_peaks_raised(at_border), at_border * 10)
    level = np.zeros((9, 30))
    level[4, 5:7] = 0.8
    np.testing.assert_allclose(lone_peaks_raised(level), level * 10 * (10 - 8) ** 2)


def test_the_odd_one_stands_out() -> None:
    rgb = np.full((240, 320, 3), (90, 120, 60), np.uint8)
    rgb[100:120, 200:220] = (200, 40, 40)
    v, u = np.unravel_index(itti(rgb).argmax(), (240, 320))
    assert 90 <= v < 130
    assert 190 <= u < 230


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (131, 200)])
@pytest.mark.parametrize("colour", [(0, 0, 0), (255, 255, 255), (17, 200, 93)])
def test_a_uniform_image_has_no_saliency(
    size: tuple[int, int], colour: tuple[int, int, int]
) -> None:
    saliency = itti(np.full((*size, 3), colour, np.uint8))
    np.testing.assert_array_equal(saliency, np.zeros(size, np.float32))


@pytest.mark.parametrize("size", [(1, 9), (3, 700), (10, 640), (11, 11)])
def test_thin_and_tiny_images_have_maps(size: tuple[int, int]) -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    before = rgb.copy()
    saliency = itti(rgb)
    assert (saliency.shape, saliency.dtype) == (size, np.float32)
    assert saliency.min() >= 0
    assert saliency.max() <= 1
    np.testing.assert_array_equal(rgb, before)


def test_a_grey_image_has_a_map() -> None:
    grey = np.random.default_rng(0).integers(0, 256, (150, 200, 1), np.uint8)
    assert itti(np.repeat(grey, 3, axis=2)).max() == 1


@pytest.mark.parametrize("rgb", [np.zeros((20, 20), np.uint8), np.zeros((20, 20, 3))])
def test_what_is_no_image_is_refused(rgb: Array) -> None:
    with pytest.raises(ValueError, match=r"rgb: expected \(H, W, 3\) uint8"):
        itti(rgb)
