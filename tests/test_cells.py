"""Cells of a grid whose outlines follow the image, against a plain reference."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.learner.features import CellSegmenter
from scenes import photograph


def moved_plainly(image: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Send each pixel to the cell of nearest mean among its own and those beside it."""
    n_cells = cells.max() + 1
    means = np.zeros((n_cells, 3))
    for cell in np.unique(cells):
        pixels = image[cells == cell].astype(int)
        n = len(pixels)
        means[cell] = (8 * pixels.sum(axis=0) + n // 2) // n
    moved, (height, width) = cells.copy(), cells.shape
    for v in range(height):
        for u in range(width):
            places = [(v, u), (v, u - 1), (v, u + 1), (v - 1, u), (v + 1, u)]
            choices = [cells[y, x] for y, x in places if 0 <= y < height and 0 <= x < width]
            distances = [((8.0 * image[v, u] - means[cell]) ** 2).sum() for cell in choices]
            moved[v, u] = choices[int(np.argmin(distances))]
    return moved


def test_without_a_pass_they_are_a_grid() -> None:
    cells = CellSegmenter(n_superpixels=48, n_passes=0)(np.zeros((240, 320, 3), np.uint8))
    assert cells.dtype == np.int32
    expected = np.arange(48, dtype=np.int32).reshape(6, 8).repeat(40, axis=0).repeat(40, axis=1)
    np.testing.assert_array_equal(cells, expected)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.integers(24, 60), st.integers(24, 70))
def test_each_pass_equals_the_plain_one(seed: int, height: int, width: int) -> None:
    image = np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)
    image[: height // 2] //= 8
    cells = [CellSegmenter(n_superpixels=1500, n_passes=n)(image) for n in range(3)]
    for before, after in pairwise(cells):
        np.testing.assert_array_equal(after, moved_plainly(image, before))


def test_outlines_move_to_an_edge_within_reach_and_no_farther() -> None:
    """Cells of 8 pixels; the image turns from dark to light in column 18, or in column 20."""
    for column, found in ((18, 18), (20, 18)):
        image = np.zeros((240, 320, 3), np.uint8)
        image[:, column:] = 200
        cells = CellSegmenter(n_superpixels=1200, n_passes=2)(image)
        crosses = np.flatnonzero(np.diff(cells[100])) + 1
        assert found in crosses
        assert len(crosses) == 39


def test_even_image_keeps_the_grid() -> None:
    image = np.full((120, 320, 3), 77, np.uint8)
    grid, cells = (CellSegmenter(n_superpixels=1500, n_passes=n)(image) for n in (0, 2))
    np.testing.assert_array_equal(grid, cells)


@pytest.mark.parametrize("n_superpixels", [1, 600, 1500, 76800])
def test_any_number_of_superpixels_can_be_asked_for(n_superpixels: int) -> None:
    cells = CellSegmenter(n_superpixels=n_superpixels)(photograph())
    assert cells.shape == (240, 320)
    assert cells.max() + 1 == pytest.approx(n_superpixels, rel=0.1)


def test_threads_share_one() -> None:
    cut, image = CellSegmenter(n_superpixels=1500), photograph()
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(cut, [image] * 8))
    for cells in found:
        np.testing.assert_array_equal(cells, cut(image))
