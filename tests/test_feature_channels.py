"""What GBVS and Itti-Koch see: halvings, stripes and opponent colours, by plain rules."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.evaluation.baselines.dkl_colour import dkl_colour
from curiosight.evaluation.baselines.feature_channels import (
    attenuated_border,
    gabor_energy,
    halved,
    pyramid,
)

Array = npt.NDArray[Any]


def halved_row(row: Array) -> Array:
    """Weigh the first four samples, then six at a time, then the last four or five."""
    half = [np.dot([10, 10, 5, 1], row[:4]) / 26]
    start = 0
    while start < len(row) - 5:
        half.append(np.dot([1, 5, 10, 10, 5, 1], row[start : start + 6]) / 32)
        start += 2
    last = row[start:]
    half.append(np.dot([1, 5, 10, 10, 5][: len(last)], last) / (31 if len(last) == 5 else 26))
    return np.array(half, np.float32)


@pytest.mark.parametrize("size", [(11, 11), (12, 30), (31, 14), (243, 321)])
def test_a_half_is_smoothed_along_both_axes(size: tuple[int, int]) -> None:
    plane = np.random.default_rng(0).random(size).astype(np.float32)
    across = np.array([halved_row(row) for row in plane])
    expected = np.array([halved_row(column) for column in across.T]).T
    assert expected.shape == (size[0] // 2, size[1] // 2)
    half = halved(plane)
    assert half.dtype == np.float32
    np.testing.assert_allclose(half, expected, rtol=3e-7)


@pytest.mark.parametrize("size", [(10, 300), (300, 10), (1, 1)])
def test_a_plane_of_ten_pixels_is_not_halved(size: tuple[int, int]) -> None:
    plane = np.random.default_rng(0).random(size).astype(np.float32)
    np.testing.assert_array_equal(halved(plane), plane)


def test_intensity_is_the_strongest_colour_and_is_halved_apart() -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (48, 64, 3), np.uint8)
    whole, half, quarter = pyramid(rgb, 2)
    np.testing.assert_array_equal(whole.intensity, rgb.max(axis=2) / np.float32(255))
    np.testing.assert_array_equal(whole.green, rgb[..., 1] / np.float32(255))
    np.testing.assert_array_equal(half.intensity, halved(whole.intensity))
    np.testing.assert_array_equal(quarter.blue, halved(halved(whole.blue)))


def gabor(angle_deg: float, phase: float) -> Array:
    """Build the filter pixel by pixel."""
    angle = np.deg2rad(angle_deg)
    pixels = np.empty((27, 27))
    for y in range(-13, 14):
        for x in range(-13, 14):
            across = y * np.cos(angle) - x * np.sin(angle)
            along = y * np.sin(angle) + x * np.cos(angle)
            wave = np.cos(2 * across + phase)
            pixels[y + 13, x + 13] = wave * np.exp(-(across**2) / 8 - along**2 / 32)
    pixels -= pixels.mean()
    return pixels / np.sqrt((pixels**2).sum())


@pytest.mark.parametrize("size", [(60, 80), (30, 41), (13, 25), (1, 5)])
@pytest.mark.parametrize("angle_deg", [0, 45, 90, 135])
def test_stripes_are_found_by_two_filters(size: tuple[int, int], angle_deg: float) -> None:
    intensity = np.random.default_rng(0).random(size)
    padded = np.pad(intensity, 26, mode="edge")
    energy = np.zeros(size)
    for phase in (0, np.pi / 2):
        turned = np.ascontiguousarray(gabor(angle_deg, phase)[::-1, ::-1])
        energy += np.abs(cv2.filter2D(padded, cv2.CV_64F, turned)[26:-26, 26:-26])
    expected = attenuated_border(energy, 13)
    np.testing.assert_allclose(gabor_energy(intensity, angle_deg), expected, atol=1e-12)


@pytest.mark.parametrize("angle_deg", [0, 45, 90, 135])
def test_stripes_show_in_their_own_direction(angle_deg: float) -> None:
    v, u = np.mgrid[:80, :80]
    across = v * np.cos(np.deg2rad(angle_deg)) - u * np.sin(np.deg2rad(angle_deg))
    stripes = 0.5 + 0.5 * np.cos(2 * across)
    energies = {angle: gabor_energy(stripes, angle)[40, 40] for angle in (0, 45, 90, 135)}
    assert max(energies, key=lambda angle: energies[angle]) == angle_deg


def test_borders_fade_row_by_row() -> None:
    np.testing.assert_allclose(
        attenuated_border(np.ones((5, 12)), 4),
        np.outer([1 / 3, 2 / 3, 1, 2 / 3, 1 / 3], [1 / 3, 2 / 3, *[1] * 8, 2 / 3, 1 / 3]),
    )
    np.testing.assert_array_equal(attenuated_border(np.ones((1, 4)), 4), np.ones((1, 4)))


def test_opponent_colours_have_the_signs_of_their_names() -> None:
    def axes(red: int, green: int, blue: int) -> Array:
        return dkl_colour(*(np.full((1, 1), level / 255) for level in (red, green, blue)))[:, 0, 0]

    dark, light = axes(60, 60, 60), axes(230, 230, 230)
    assert dark[0] < 0 < light[0]
    assert axes(200, 60, 60)[1] > axes(60, 60, 60)[1] > axes(60, 200, 60)[1]
    assert axes(60, 60, 200)[2] > axes(60, 60, 60)[2] > axes(200, 200, 60)[2]


def test_half_of_a_monitors_light_is_the_grey_that_colours_are_told_from() -> None:
    greys = np.arange(256)[None] / 255
    luminance, red_green, blue_yellow = dkl_colour(greys, greys, greys)
    nearest = np.abs(luminance[0]).argmin()
    assert 150 < nearest < 200
    assert abs(red_green[0, nearest]) < 0.05
    assert abs(blue_yellow[0, nearest]) < 0.05
