"""The sets `surroundings`, `texture` and `height` against slow, plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from hypothesis import example, given, settings
from hypothesis import strategies as st

from curiosight.learner.features import Picture, describe, make_sets
from curiosight.learner.features.colour import PLACES
from curiosight.learner.features.superpixel_sums import sum_superpixels
from curiosight.learner.features.surroundings import (
    describe_height,
    describe_surroundings,
)
from curiosight.learner.features.texture import describe_texture
from pictures import noise_in_blocks
from test_contrast import contrast_of

Image = npt.NDArray[np.uint8]
RINGS = (7, 18)
AROUND = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def box(image: np.ndarray, u: int, v: int, reach: int) -> np.ndarray:
    """Return the pixels of a box around the pixel of the image that is nearest to (u, v)."""
    height, width = image.shape[:2]
    u, v = min(max(u, 0), width - 1), min(max(v, 0), height - 1)
    return image[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]


def gradients(image: np.ndarray) -> list[np.ndarray]:
    """Return what the first channel changes by across, down, falling and rising: (h, w) each."""
    height, width = image.shape[:2]
    padded = np.pad(image[..., 0].astype(int), 1, mode="edge")

    def at(du: int, dv: int) -> np.ndarray:
        return padded[1 + dv : 1 + dv + height, 1 + du : 1 + du + width]

    pairs = (((1, 0), (-1, 0)), ((0, 1), (0, -1)), ((1, 1), (-1, -1)), ((-1, 1), (1, -1)))
    return [np.abs(at(*one) - at(*other)) for one, other in pairs]


def numbers_of(image: Image, inside: np.ndarray) -> np.ndarray:
    """Return the 58 numbers of the superpixel that covers `inside`, before they are rounded."""
    mean, deviation = image[inside].mean(axis=0), image[inside].std(axis=0)
    v, u = np.floor(np.argwhere(inside).mean(axis=0) + 0.5).astype(int)
    numbers = [*mean, *2 * deviation]
    for du, dv in PLACES[1:]:
        numbers += [*box(image, u + du, v + dv, 4).mean(axis=(0, 1))]
    numbers += [*contrast_of(image, inside.astype(int), 1)[:12]]
    for ring in RINGS:
        boxes = [box(image, u + ring * x, v + ring * y, ring // 2)[..., 0] for x, y in AROUND]
        # Exactly 2 darker is a tie, told by the rounding of one product: the kernel's.
        darker = [one.sum() * (1 / one.size) < mean[0] - 2 for one in boxes]
        turns = sum(one != other for one, other in zip(darker, np.roll(darker, 1), strict=True))
        numbers += [31 * sum(darker), 31 * turns]
    return np.array(numbers)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6), st.integers(24, 90))
@example(20898, 56)  # a box is darker by exactly 2
def test_rows_equal_the_plain_ones(seed: int, height: int) -> None:
    image, superpixels = noise_in_blocks(seed, height=height)
    image[height // 3 :] //= 5
    rows = describe_surroundings(image, superpixels)
    assert rows.shape == (superpixels.max() + 1, 58)
    for superpixel in range(0, len(rows), 5):
        expected = np.clip(numbers_of(image, superpixels == superpixel), 0, 255)
        assert np.abs(rows[superpixel] - expected).max() < 0.502


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6), st.integers(24, 60))
def test_texture_equals_the_plain_one(seed: int, height: int) -> None:
    image, superpixels = noise_in_blocks(seed, height=height)
    image[height // 3 :] //= 5
    rows = describe_texture(image, superpixels)
    for superpixel in range(0, len(rows), 5):
        v, u = np.floor(np.argwhere(superpixels == superpixel).mean(axis=0) + 0.5).astype(int)
        across, down, falling, rising = (box(one, u, v, 4).mean() for one in gradients(image))
        expected = [
            2 * box(image, u, v, 4)[..., 0].std(),
            16 * np.sqrt(across + down),
            128 + 127 * (across - down) / (across + down + 1),
            128 + 127 * (falling - rising) / (falling + rising + 1),
        ]
        assert np.abs(rows[superpixel] - np.clip(expected, 0, 255)).max() < 0.502


def test_columns_have_names_in_the_order_of_the_rows() -> None:
    """A light square on dark: what its names say is what its row says."""
    (surroundings,) = make_sets("surroundings", "lab")
    image = np.zeros((240, 320, 3), np.uint8)
    image[116:125, 156:165] = (180, 90, 30)
    superpixels = np.zeros((240, 320), np.int32)
    superpixels[116:125, 156:165] = 1
    row = dict(zip(surroundings.columns, surroundings(image, superpixels)[1].tolist(), strict=True))
    assert [row[f"{channel} here"] for channel in "Lab"] == [180, 90, 30]
    assert row["a at -25 +0"] == row["b at +0 +100"] == row["L deviation"] == 0
    assert row["a contrast 4"] < row["a contrast 32"] <= 128 + 90
    assert (row["darker at 18"], row["turns at 18"]) == (8 * 31, 0)


def test_direction_of_stripes_is_told_whatever_their_place() -> None:
    (texture,) = make_sets("texture", "rgb")
    column = texture.columns.index("gradient across")
    stripes = np.zeros((60, 80, 3), np.uint8)
    stripes[:, ::4] = stripes[:, 1::4] = 200
    superpixels = np.repeat(np.arange(8, dtype=np.int32), 10)[None, :].repeat(60, axis=0)
    assert (texture(stripes, superpixels)[:, column] > 250).all()
    turned = np.ascontiguousarray(stripes[:, :60].transpose(1, 0, 2))
    assert (texture(turned, superpixels[:, :60].copy())[:, column] < 5).all()


def test_large_sums_do_no_harm() -> None:
    """White all over: 300 x 2000 pixels of 255² are more than 32 bits hold."""
    image = np.full((2000, 300, 3), 255, np.uint8)
    superpixels = np.zeros((2000, 300), np.int32)
    superpixels[1900:1910, 290:] = 1
    row = describe_surroundings(image, superpixels)[1]
    assert row[:6].tolist() == [255, 255, 255, 0, 0, 0]
    assert describe_texture(image, superpixels)[1].tolist() == [0, 0, 128, 128]
    assert (row[6:42] == 255).all()
    assert (row[42:54] == 128).all()
    assert row[54:].tolist() == [0, 0, 0, 0]


def test_height_is_the_mean_line() -> None:
    superpixels = np.zeros((101, 40), np.int32)
    superpixels[:2], superpixels[99:] = 1, 3
    image = np.zeros((101, 40, 3), np.uint8)
    rows = describe_height(image, superpixels)
    assert rows.shape == (4, 1)
    assert rows[:, 0].tolist() == [128, 1, 0, 254]


def test_sums_are_shared_and_change_nothing() -> None:
    image, superpixels = noise_in_blocks(3, height=60)
    sets = make_sets("surroundings+texture+height+contrast", "rgb")
    rows, _ = describe(Picture(image), superpixels, sets, rows_per="superpixel")
    alone = [one(image, superpixels) for one in sets]
    np.testing.assert_array_equal(rows, np.hstack(alone))
    sums = sum_superpixels(image, superpixels, superpixels.max() + 1)
    v, u = np.nonzero(superpixels == 2)
    inside = image[v, u].astype(np.int64)
    expected = [len(u), u.sum(), v.sum(), *inside.sum(axis=0), *(inside**2).sum(axis=0)]
    assert sums[2].tolist() == [int(value) for value in expected]
