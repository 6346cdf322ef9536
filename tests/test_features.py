"""The 39 colours around a superpixel against slow, plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.learner.features import (
    N_FEATURES,
    Picture,
    SeedsSegmenter,
    describe,
    describe_pixels,
    describe_superpixels,
    make_sets,
)
from curiosight.learner.features.colour import superpixel_means
from pictures import noise_in_blocks
from scenes import photograph

Image = npt.NDArray[np.uint8]
SMALL = (240, 320)


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
    rgb, superpixels = noise_in_blocks(seed)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    np.testing.assert_array_equal(rows[row_of_pixel], features_by_shifting(rgb, superpixels))


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_superpixel_rows_are_the_means_of_pixel_features(seed: int) -> None:
    rgb, superpixels = noise_in_blocks(seed)
    rows, row_of_pixel = describe_superpixels(rgb, superpixels)
    features = features_by_shifting(rgb, superpixels)
    for superpixel, row in enumerate(rows):
        expected = np.floor(features[superpixels == superpixel].mean(axis=0) + 0.5)
        np.testing.assert_array_equal(row, expected)
    np.testing.assert_array_equal(row_of_pixel, superpixels)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_superpixel_means_equal_numpy(seed: int) -> None:
    rgb, superpixels = noise_in_blocks(seed)
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
    rgb, superpixels = noise_in_blocks(1)
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
    rgb, superpixels = noise_in_blocks(seed)
    order = np.random.default_rng(seed).permutation(superpixels.max() + 1).astype(np.int32)
    sets = make_sets("colours+contrast+surroundings+texture+height", "rgb")
    rows, row_of_pixel = describe(Picture(rgb), superpixels, sets, rows_per="superpixel")
    other_rows, other_row_of_pixel = describe(
        Picture(rgb), order[superpixels], sets, rows_per="superpixel"
    )
    np.testing.assert_array_equal(other_rows[other_row_of_pixel], rows[row_of_pixel])


def test_pixel_rows_are_shared_but_exact_on_a_photograph() -> None:
    rgb = photograph()
    superpixels = SeedsSegmenter()(rgb)
    rows, row_of_pixel = describe_pixels(rgb, superpixels)
    assert len(rows) < 0.8 * superpixels.size
    np.testing.assert_array_equal(rows[row_of_pixel], features_by_shifting(rgb, superpixels))
