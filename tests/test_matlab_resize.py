"""Resizing like MATLAB: beside Pillow, which has the same kernel, and at the border by hand."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from curiosight.evaluation.baselines.matlab_resize import bicubic


@pytest.mark.parametrize("size", [(30, 40), (24, 32), (60, 80), (97, 131), (240, 320)])
def test_the_inside_is_as_pillow_makes_it(size: tuple[int, int]) -> None:
    image = np.random.default_rng(0).random((60, 80)).astype(np.float32)
    expected = np.asarray(
        Image.fromarray(image).resize(size[::-1], Image.Resampling.BICUBIC), np.float64
    )
    margin = 6 * size[0] // 60 + 6
    inside = (slice(margin, -margin), slice(margin, -margin))
    np.testing.assert_allclose(bicubic(image, size)[inside], expected[inside], atol=1e-6)


def test_beyond_its_edge_the_image_is_mirrored() -> None:
    image = np.random.default_rng(1).random((9, 11))
    mirrored = np.pad(image, ((9, 9), (11, 11)), mode="symmetric")
    for factor in (2, 3):
        enlarged = bicubic(mirrored, (27 * factor, 33 * factor))
        middle = enlarged[9 * factor : 18 * factor, 11 * factor : 22 * factor]
        np.testing.assert_allclose(bicubic(image, (9 * factor, 11 * factor)), middle, atol=1e-12)


def test_the_size_it_has_leaves_an_image_as_it_is() -> None:
    image = np.random.default_rng(2).random((7, 5))
    np.testing.assert_array_equal(bicubic(image, (7, 5)), image)


@pytest.mark.parametrize("size", [(1, 1), (3, 200), (40, 2)])
def test_a_constant_stays_one_from_and_to_any_size(size: tuple[int, int]) -> None:
    for shape in ((1, 1), (2, 50), (33, 20)):
        resized = bicubic(np.full(shape, 0.3), size)
        assert resized.shape == size
        np.testing.assert_allclose(resized, 0.3, rtol=1e-12)
