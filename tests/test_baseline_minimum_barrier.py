"""MB and MB+ against the original's maps; scans and reconstruction against plain ones."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from curiosight.evaluation.baselines.maps import resized_to
from curiosight.evaluation.baselines.minimum_barrier import (
    inside_of_frame,
    mb,
    mbplus,
    scan_barriers,
)
from curiosight.evaluation.baselines.reconstruction import (
    open_and_close_by_reconstruction,
    reconstruct,
)
from curiosight.evaluation.baselines.whitening import whitening_of
from golden_maps import IMAGES, assert_equals_golden, golden_input

METHODS = [mb, mbplus]
small_sizes = st.tuples(st.integers(1, 9), st.integers(1, 9))
greys = arrays(np.uint8, small_sizes, elements=st.integers(0, 30))


@pytest.mark.parametrize("image", IMAGES)
def test_mb_equals_the_original(image: str) -> None:
    assert_equals_golden(mb(golden_input(image)), "mbd_mb", image, pearson=1 - 1e-9, levels=0)


@pytest.mark.parametrize("image", IMAGES)
def test_mbplus_equals_the_original(image: str) -> None:
    saliency = mbplus(golden_input(image))
    assert_equals_golden(saliency, "mbd_mbplus", image, pearson=0.99998, levels=2)


def plain_barriers(channel: np.ndarray) -> np.ndarray:
    """Scan as the paper's algorithm 1 says, with the ranges of whole paths."""
    height, width = channel.shape
    grey = channel.astype(int)
    barrier = np.zeros((height, width), int)
    barrier[1:-1, 1:-1] = 10**5
    low, high = grey.copy(), grey.copy()
    pixels = [(v, u) for v in range(1, height - 1) for u in range(1, width - 1)]
    for order, back in ((pixels, -1), (pixels[::-1], 1), (pixels, -1)):
        for v, u in order:
            for other in ((v, u + back), (v + back, u)):
                lowest, highest = min(low[other], grey[v, u]), max(high[other], grey[v, u])
                if highest - lowest < barrier[v, u]:
                    barrier[v, u] = highest - lowest
                    low[v, u], high[v, u] = lowest, highest
    return barrier


@settings(max_examples=60, deadline=None)
@given(greys)
def test_scans_equal_plain_scans(channel: np.ndarray) -> None:
    assert np.array_equal(scan_barriers(channel), plain_barriers(channel))


@settings(max_examples=60, deadline=None)
@given(greys, st.sampled_from([4, 8]), st.data())
def test_reconstruction_equals_repeated_dilation(
    mask: np.ndarray, n_neighbours: int, data: Any
) -> None:
    marker = data.draw(arrays(np.uint8, mask.shape, elements=st.integers(0, 30)))
    shape = cv2.MORPH_CROSS if n_neighbours == 4 else cv2.MORPH_RECT
    element = cv2.getStructuringElement(shape, (3, 3))
    plain = np.minimum(marker, mask)
    while not np.array_equal(grown := np.minimum(cv2.dilate(plain, element), mask), plain):
        plain = grown
    assert np.array_equal(reconstruct(marker, mask, n_neighbours=n_neighbours), plain)


def test_opening_and_closing_keeps_large_things_whole() -> None:
    grey = np.full((40, 60), 100, np.uint8)
    grey[10:30, 10:30] = 200
    grey[15:17, 15:17] = 50  # a dark speck in it
    grey[5:7, 50:52] = 255  # a bright one beside it
    smooth = open_and_close_by_reconstruction(grey, np.ones((5, 5), np.uint8), n_neighbours=4)
    expected = np.full((40, 60), 100, np.uint8)
    expected[10:30, 10:30] = 200
    assert np.array_equal(smooth, expected)


def test_a_drawn_frame_is_found() -> None:
    small = resized_to(golden_input("synth_frame"), 300)
    rows, columns = inside_of_frame(small)
    assert (rows.start, columns.start) == (11, 11)
    assert (small.shape[0] - rows.stop, small.shape[1] - columns.stop) == (11, 11)


def test_one_framed_side_is_cut_alone() -> None:
    rgb = np.full((90, 120, 3), 200, np.uint8)
    rgb[-6:] = 0
    assert inside_of_frame(rgb) == (slice(0, 90 - 6 - 2 - 1), slice(0, 120))


def test_no_frame_is_found_where_none_is() -> None:
    small = resized_to(golden_input("sk_coffee"), 300)
    assert inside_of_frame(small) == (slice(0, 200), slice(0, 300))


def test_white_colours_are_uncorrelated() -> None:
    rng = np.random.default_rng(0)
    colours = rng.normal(size=(4000, 3)) @ rng.normal(size=(3, 3)) * 1000
    covariance = np.cov((colours @ whitening_of(colours)).T)
    assert covariance == pytest.approx(np.eye(3), abs=1e-2)


@pytest.mark.parametrize("method", METHODS)
def test_a_disk_stands_out(method: Any) -> None:
    rgb = np.full((120, 160, 3), 90, np.uint8)
    cv2.circle(rgb, (90, 60), 20, (200, 40, 40), -1)
    saliency = method(rgb)
    assert saliency[50:70, 80:100].min() > 0.9
    assert saliency[5:20, 5:20].max() < 0.1
