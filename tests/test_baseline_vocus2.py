"""VOCUS2: equal to the original program, and to the rules written out at length."""

from __future__ import annotations

from collections.abc import Callable
from math import floor, log2, sqrt
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.evaluation.baselines.vocus2 import (
    vocus2,
    vocus2_coffee,
    vocus2_kitchen,
    vocus2_msra,
)
from golden_maps import IMAGES, assert_equals_golden, golden_input

Array = npt.NDArray[Any]
METHODS = (vocus2_coffee, vocus2_kitchen, vocus2_msra)
# What is blurred farthest takes seconds: of its images these.
SOME = ("sk_coffee", "synth_frame", "tsdf_000000", "vocus2_msra")
COMPARED = [(m, image) for m in METHODS for image in (SOME if m is vocus2_msra else IMAGES)]


@pytest.mark.parametrize(("method", "image"), COMPARED)
def test_equals_the_original(method: Callable[[Array], Array], image: str) -> None:
    saliency = method(golden_input(image))
    assert_equals_golden(saliency, method.__name__, image, pearson=0.999999, levels=1)


def blurred(plane: Array, sigma: float) -> Array:
    return cv2.GaussianBlur(plane, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)


def centre_pyramid(plane: Array, sigma: float) -> list[Array]:
    """Return two scales per octave, each blurred on from the one before it."""
    scales = []
    first = blurred(plane, sigma)
    for _ in range(min(floor(log2(min(plane.shape))), 4) + 1):
        twice = [first]
        total = sigma
        for wanted in (sqrt(2) * sigma, 2 * sigma):
            twice.append(blurred(twice[-1], sqrt(wanted**2 - total**2)))
            total = wanted
        scales += twice[:2]
        height, width = first.shape
        if min(height, width) > 1:
            size = (width // 2, height // 2)
            first = cv2.resize(twice[2][: size[1] * 2, : size[0] * 2], size, interpolation=0)
    return scales


def fused(maps: list[Array]) -> Array:
    size = maps[0].shape[::-1]
    return np.mean([cv2.resize(m, size, interpolation=cv2.INTER_CUBIC) for m in maps], axis=0)


def at_length(rgb: Array, centre_sigma: float, surround_sigma: float) -> Array:
    """Follow the original: a mean for on, for off, for each plane, and over the planes."""
    red, green, blue = (rgb[..., c].astype(np.float32) for c in range(3))
    planes = [(red + green + blue) / 765, (red - green) / 255, (blue - (red + green) / 2) / 255]
    conspicuities = []
    for plane in planes:
        on, off = [], []
        for index, centre in enumerate(centre_pyramid(plane, centre_sigma)):
            sigma = sqrt(surround_sigma**2 - centre_sigma**2) * 2 ** (index % 2 / 2)
            difference = centre - blurred(centre, sigma)
            on.append(np.maximum(difference, 0))
            off.append(np.maximum(-difference, 0))
        conspicuities.append((fused(on) + fused(off)) / 2)
    saliency = np.mean(conspicuities, axis=0)
    return (saliency - saliency.min()) / np.ptp(saliency)


@pytest.mark.parametrize("size", [(97, 131), (64, 64), (20, 33), (5, 90), (2, 2)])
@pytest.mark.parametrize("sigmas", [(2, 6), (1, 2), (1.5, 9)])
def test_one_mean_of_absolute_differences_is_the_originals_many(
    size: tuple[int, int], sigmas: tuple[float, float]
) -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    np.testing.assert_allclose(vocus2(rgb, *sigmas), at_length(rgb, *sigmas), atol=2e-5)


@pytest.mark.parametrize("colour", [(255, 0, 0), (128, 128, 160), (129, 128, 128)])
def test_the_odd_one_stands_out_however_faint(colour: tuple[int, int, int]) -> None:
    rgb = np.full((120, 160, 3), 128, np.uint8)
    rgb[40:48, 100:108] = colour
    for method in METHODS:
        v, u = np.unravel_index(method(rgb).argmax(), (120, 160))
        assert 40 <= v < 48
        assert 100 <= u < 108


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (128, 1000), (129, 131)])
@pytest.mark.parametrize("colour", [(0, 0, 0), (255, 255, 255), (17, 200, 93)])
def test_a_uniform_image_has_no_saliency(
    size: tuple[int, int], colour: tuple[int, int, int]
) -> None:
    for method in METHODS:
        saliency = method(np.full((*size, 3), colour, np.uint8))
        np.testing.assert_array_equal(saliency, np.zeros(size, np.float32))


@pytest.mark.parametrize("size", [(1, 9), (9, 1), (2, 3), (16, 640)])
def test_thin_and_tiny_images_have_maps(size: tuple[int, int]) -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    before = rgb.copy()
    saliency = vocus2_coffee(rgb)
    assert (saliency.shape, saliency.dtype) == (size, np.float32)
    assert (saliency.min(), saliency.max()) == (0, 1)
    np.testing.assert_array_equal(rgb, before)


@pytest.mark.parametrize(
    "rgb", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8)]
)
def test_what_is_no_image_is_refused(rgb: Array) -> None:
    with pytest.raises(ValueError, match=r"rgb: expected \(H, W, 3\) uint8"):
        vocus2_coffee(rgb)


@pytest.mark.parametrize("sigmas", [(0, 2), (-1, 2), (3, 3), (3, 2)])
def test_the_surround_is_wider_than_the_centre(sigmas: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="surround_sigma: expected"):
        vocus2(np.zeros((4, 4, 3), np.uint8), *sigmas)
