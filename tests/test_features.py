"""The 39 features and the 15 of contrast against slow, plain references."""

from __future__ import annotations

from typing import get_args

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.features import (
    N_CONTRAST,
    N_FEATURES,
    RowsPer,
    SeedsSegmenter,
    count_features,
    describe,
    describe_contrast,
    describe_pixels,
    describe_superpixels,
    shrink,
)
from curiosight.features.colour import superpixel_means
from scenes import see

Image = npt.NDArray[np.uint8]
SMALL = (240, 320)


def random_case(seed: int, *, height: int = 60, width: int = 130) -> tuple[Image, np.ndarray]:
    """Return noise, and blocks of random sizes as its superpixels."""
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (height, width, 3), np.uint8)
    rows = np.cumsum(rng.random(height) < 0.1)
    columns = np.cumsum(rng.random(width) < 0.1)
    blocks = rows[:, None] * (columns.max() + 1) + columns
    return rgb, np.unique(blocks, return_inverse=True)[1].reshape(blocks.shape).astype(np.int32)


def mean_map(rgb: Image, superpixels: np.ndarray) -> Image:
    """Replace each pixel by the mean colour of its superpixel, halves rounded up."""
    painted = np.empty_like(rgb)
    for superpixel in np.unique(superpixels):
        where = superpixels == superpixel
        painted[where] = np.floor(rgb[where].mean(axis=0) + 0.5)
    return painted


def features_by_shifting(rgb: Image, superpixels: np.ndarray) -> Image:
    """Return (h, w, 39): the mean map, padded by its border and shifted to each place."""
    painted = mean_map(rgb, superpixels)
    height, width = superpixels.shape
    padded = np.pad(painted, ((100, 100), (100, 100), (0, 0)), mode="edge")
    maps = [painted]
    for d in (25, 50, 100):
        for du, dv in ((-d, 0), (d, 0), (0, -d), (0, d)):
            maps.append(padded[100 + dv : 100 + dv + height, 100 + du : 100 + du + width])
    return np.concatenate(maps, axis=2)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_pixel_rows_equal_the_plain_features(seed: int) -> None:
    rgb, superpixels = random_case(seed)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    np.testing.assert_array_equal(rows[row_of_pixel], features_by_shifting(rgb, superpixels))


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_superpixel_rows_are_the_means_of_pixel_features(seed: int) -> None:
    rgb, superpixels = random_case(seed)
    rows, row_of_pixel = describe_superpixels(rgb, superpixels)
    features = features_by_shifting(rgb, superpixels)
    for superpixel, row in enumerate(rows):
        expected = np.floor(features[superpixels == superpixel].mean(axis=0) + 0.5)
        np.testing.assert_array_equal(row, expected)
    np.testing.assert_array_equal(row_of_pixel, superpixels)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_superpixel_means_equal_numpy(seed: int) -> None:
    rgb, superpixels = random_case(seed)
    n_superpixels = int(superpixels.max()) + 1
    means = superpixel_means(rgb, superpixels, n_superpixels + 1)
    np.testing.assert_array_equal(means[superpixels], mean_map(rgb, superpixels))
    assert (means[n_superpixels] == 0).all()


def test_features_come_in_the_documented_order() -> None:
    """Here, then left, right, up, down at 25, 50 and 100 pixels; red, green, blue of each."""
    height, width = SMALL
    superpixels = np.arange(height * width, dtype=np.int32).reshape(SMALL)
    rgb = np.zeros((height, width, 3), np.uint8)
    v, u = 120, 160
    places = [(v, u)]
    for d in (25, 50, 100):
        places += [(v, u - d), (v, u + d), (v - d, u), (v + d, u)]
    for number, (row, column) in enumerate(places, start=1):
        rgb[row, column] = (number, number + 50, number + 100)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    expected = [number + offset for number in range(1, 14) for offset in (0, 50, 100)]
    assert N_FEATURES == 39
    assert rows[row_of_pixel[v, u]].tolist() == expected


def test_border_repeats() -> None:
    superpixels = np.arange(SMALL[0] * SMALL[1], dtype=np.int32).reshape(SMALL)
    rgb = np.random.default_rng(0).integers(0, 256, (*SMALL, 3), np.uint8)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    corner = rows[row_of_pixel[0, 0]].reshape(13, 3)
    for left_or_up in (1, 3, 5, 7, 9, 11):
        np.testing.assert_array_equal(corner[left_or_up], rgb[0, 0])
    np.testing.assert_array_equal(corner[2], rgb[0, 25])
    np.testing.assert_array_equal(corner[12], rgb[100, 0])


@pytest.mark.parametrize("describe", [describe_pixels, describe_superpixels])
def test_image_of_one_colour_has_one_value(describe) -> None:  # type: ignore[no-untyped-def]
    rgb = np.full((*SMALL, 3), (10, 20, 30), np.uint8)
    rows, row_of_pixel = describe(rgb, SeedsSegmenter()(rgb))
    np.testing.assert_array_equal(rows, np.tile([10, 20, 30], (len(rows), 13)))
    assert row_of_pixel.shape == SMALL


def test_mirrored_image_swaps_left_and_right() -> None:
    rgb, superpixels = random_case(1)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    flipped_rows, flipped_row = describe_pixels(
        np.ascontiguousarray(rgb[:, ::-1]), np.ascontiguousarray(superpixels[:, ::-1])
    )
    swapped = [0, *(k + 4 * scale for scale in range(3) for k in (2, 1, 3, 4))]
    mirrored = flipped_rows[flipped_row[:, ::-1]].reshape(*superpixels.shape, 13, 3)
    plain = rows[row_of_pixel].reshape(*superpixels.shape, 13, 3)
    np.testing.assert_array_equal(mirrored[:, :, swapped], plain)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6))
def test_numbering_of_superpixels_does_not_matter(seed: int) -> None:
    rgb, superpixels = random_case(seed)
    order = np.random.default_rng(seed).permutation(superpixels.max() + 1).astype(np.int32)
    rows, row_of_pixel = describe(rgb, superpixels, rows_per="superpixel", contrast=True)
    other_rows, other_row_of_pixel = describe(
        rgb, order[superpixels], rows_per="superpixel", contrast=True
    )
    np.testing.assert_array_equal(other_rows[other_row_of_pixel], rows[row_of_pixel])


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
    image, superpixels = random_case(seed, height=height)
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
    plain, row_of_pixel = describe(image, superpixels, rows_per=rows_per, contrast=False)
    rows, same_row_of_pixel = describe(image, superpixels, rows_per=rows_per, contrast=True)
    np.testing.assert_array_equal(row_of_pixel, same_row_of_pixel)
    assert plain.shape[1] == count_features(contrast=False) == 39
    assert rows.shape[1] == count_features(contrast=True) == 54
    assert rows.dtype == np.uint8
    np.testing.assert_array_equal(rows[:, :39], plain)
    of_superpixels = describe_contrast(image, superpixels)
    np.testing.assert_array_equal(rows[row_of_pixel][..., 39:], of_superpixels[superpixels])


def test_a_superpixel_without_pixels_is_no_harm() -> None:
    image, superpixels = random_case(3)
    superpixels += 1
    rows, _ = describe(image, superpixels, rows_per="superpixel", contrast=True)
    assert len(rows) == superpixels.max() + 1
    shifted, _ = describe(image, superpixels - 1, rows_per="superpixel", contrast=True)
    np.testing.assert_array_equal(rows[1:], shifted)


def photograph() -> Image:
    """Return a room with the noise of a sensor, at the working size."""
    rgb = shrink(see()[0].rgb).astype(np.int64)
    noise = np.random.default_rng(0).normal(0, 4, rgb.shape)
    return np.clip(rgb + noise, 0, 255).astype(np.uint8)


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


def test_pixel_rows_are_shared_but_exact_on_a_photograph() -> None:
    rgb = photograph()
    superpixels = SeedsSegmenter()(rgb)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    assert len(rows) < 0.8 * superpixels.size
    np.testing.assert_array_equal(rows[row_of_pixel], features_by_shifting(rgb, superpixels))


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
