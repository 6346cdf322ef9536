"""The 15 features of contrast against slow, plain references."""

from __future__ import annotations

from typing import get_args

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.learner.features import (
    N_CONTRAST,
    Picture,
    RowsPer,
    SeedsSegmenter,
    count_features,
    describe,
    describe_contrast,
    make_sets,
)
from pictures import noise_in_blocks
from scenes import photograph

Image = npt.NDArray[np.uint8]
SMALL = (240, 320)


def blurred(image: np.ndarray, taps: np.ndarray) -> np.ndarray:
    """Convolve (h, w, 3) by the same taps down and across; its border is mirrored."""
    reach = len(taps) // 2
    for axis in (0, 1):
        padding = [(0, 0)] * 3
        padding[axis] = (reach, reach)
        padded = np.pad(image, padding, mode="reflect")
        size = image.shape[axis]
        image = sum(tap * np.take(padded, range(k, k + size), axis) for k, tap in enumerate(taps))  # type: ignore[assignment]
    return image


def between_pixels(image: np.ndarray, v: float, u: float) -> np.ndarray:
    """Interpolate linearly between the four pixels around (v, u); the border repeats."""
    height, width = image.shape[:2]
    total = np.zeros(3)
    for row in (int(v), int(v) + 1):
        for column in (int(u), int(u) + 1):
            weight = (1 - abs(v - row)) * (1 - abs(u - column))
            total += weight * image[min(row, height - 1), min(column, width - 1)]
    return total


def contrast_of(image: Image, superpixels: np.ndarray, superpixel: int) -> np.ndarray:
    """Return the 15 numbers of one superpixel, before they are rounded."""
    inside = superpixels == superpixel
    v, u = np.argwhere(inside).mean(axis=0)
    mean = image[inside].mean(axis=0)
    gauss = np.exp(-(np.arange(-4, 5) ** 2) / 2)
    smaller, numbers = image.astype(float), []
    for level in range(1, 6):
        smaller = blurred(smaller, np.array([1, 4, 6, 4, 1]) / 16)[::2, ::2]
        if level >= 2:
            around = blurred(smaller, gauss / gauss.sum())
            numbers.append(mean - between_pixels(around, v / 2**level, u / 2**level) + 128)
    return np.concatenate([*numbers, 2 * image[inside].std(axis=0)])


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.integers(24, 90))
def test_contrast_equals_the_plain_one(seed: int, height: int) -> None:
    image, superpixels = noise_in_blocks(seed, height=height)
    image[superpixels == 0] //= 4
    rows = describe_contrast(image, superpixels)
    assert rows.shape == (superpixels.max() + 1, N_CONTRAST)
    for superpixel in range(0, len(rows), 7):
        expected = np.clip(contrast_of(image, superpixels, superpixel), 0, 255)
        assert np.abs(rows[superpixel] - expected).max() < 0.502


def test_contrast_tells_a_thing_from_its_ground_whatever_its_brightness() -> None:
    """A thing 40 lighter than its ground, 16 pixels wide: least so where it is its own ground."""
    image = np.full((*SMALL, 3), 100, np.uint8)
    image[112:128, 152:168] = (140, 100, 60)
    superpixels = np.zeros(SMALL, np.int32)
    superpixels[112:128, 152:168] = 1
    rows = describe_contrast(image, superpixels)
    differences = rows[1, :12].reshape(4, 3).astype(int) - 128
    assert (np.diff(differences[:, 0]) > 0).all()
    assert differences[3].tolist() == [pytest.approx(39, abs=2), 0, pytest.approx(-39, abs=2)]
    assert rows[1, 12:].tolist() == [0, 0, 0]
    np.testing.assert_array_equal(describe_contrast(image + 50, superpixels), rows)


def test_contrast_beyond_eight_bits_is_cut() -> None:
    image = np.zeros((*SMALL, 3), np.uint8)
    image[100:108, 100:108] = 255
    image[::2, ::2] = 255
    superpixels = np.zeros(SMALL, np.int32)
    superpixels[100:108, 100:108] = 1
    rows = describe_contrast(image, superpixels)
    assert (rows[1, :12] == 255).any()
    assert rows[0, 12:].tolist() == [pytest.approx(2 * 255 * np.sqrt(3) / 4, abs=1)] * 3


@pytest.mark.parametrize("rows_per", get_args(RowsPer))
def test_rows_carry_the_contrast_of_the_superpixel_they_lie_in(rows_per: RowsPer) -> None:
    image = photograph()
    superpixels = SeedsSegmenter()(image)
    colours, both = make_sets("colours", "rgb"), make_sets("colours+contrast", "rgb")
    plain, row_of_pixel = describe(Picture(image), superpixels, colours, rows_per=rows_per)
    rows, same_row_of_pixel = describe(Picture(image), superpixels, both, rows_per=rows_per)
    np.testing.assert_array_equal(row_of_pixel, same_row_of_pixel)
    assert plain.shape[1] == count_features("colours", "rgb") == 39
    assert rows.shape[1] == count_features("colours", "rgb", contrast=True) == 54
    assert rows.dtype == np.uint8
    np.testing.assert_array_equal(rows[:, :39], plain)
    of_superpixels = describe_contrast(image, superpixels)
    np.testing.assert_array_equal(rows[row_of_pixel][..., 39:], of_superpixels[superpixels])


def test_a_superpixel_without_pixels_is_no_harm() -> None:
    image, superpixels = noise_in_blocks(3)
    superpixels += 1
    sets = make_sets("colours+contrast+surroundings+texture+height+itti", "lab")
    rows, _ = describe(Picture(image), superpixels, sets, rows_per="superpixel")
    assert len(rows) == superpixels.max() + 1
    shifted, _ = describe(Picture(image), superpixels - 1, sets, rows_per="superpixel")
    np.testing.assert_array_equal(rows[1:], shifted)
