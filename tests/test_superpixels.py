"""Superpixels, and the size that images are worked on at."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.learner.features import (
    SeedsSegmenter,
    shrink,
)
from scenes import photograph

SMALL = (240, 320)


def test_seeds_makes_520_superpixels_without_a_gap() -> None:
    superpixels = SeedsSegmenter()(photograph())
    assert superpixels.shape == SMALL
    assert superpixels.dtype == np.int32
    np.testing.assert_array_equal(np.unique(superpixels), np.arange(520))


def test_seeds_gives_the_same_answer_again_and_after_another_size() -> None:
    rgb, segmenter = photograph(), SeedsSegmenter()
    first = segmenter(rgb).copy()
    np.testing.assert_array_equal(segmenter(rgb), first)
    segmenter(np.ascontiguousarray(rgb[:200]))
    np.testing.assert_array_equal(segmenter(rgb), first)


@pytest.mark.parametrize(
    ("size", "small"),
    [((480, 640), (240, 320)), ((240, 320), (240, 320)), ((1080, 1920), (180, 320))],
)
def test_shrink_brings_images_to_the_working_width(
    size: tuple[int, int], small: tuple[int, int]
) -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    assert shrink(rgb).shape == (*small, 3)


def test_half_size_is_the_mean_of_four_pixels() -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (480, 640, 3), np.uint8)
    blocks = rgb.reshape(240, 2, 320, 2, 3).mean(axis=(1, 3))
    assert np.abs(shrink(rgb) - blocks).max() <= 0.5


@pytest.mark.parametrize("size", [(20, 640), (40, 2000), (6000, 300)])
def test_images_too_flat_or_too_tall_are_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="rgb: expected an image about as high as wide"):
        shrink(np.zeros((*size, 3), np.uint8))
