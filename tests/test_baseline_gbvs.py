"""GBVS: equal to the original toolbox, and its walks to those over a matrix of all pairs."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.evaluation.baselines.gbvs import (
    LONGEST_WALK,
    closeness_table,
    gbvs,
    gbvs_fast,
    visits,
)
from golden_maps import IMAGES, assert_equals_golden, golden_input

Array = npt.NDArray[Any]


# The gun curves that stand in for the toolbox's table cost up to 5 grey levels.
@pytest.mark.parametrize("image", IMAGES)
def test_equals_the_original(image: str) -> None:
    assert_equals_golden(gbvs(golden_input(image)), "gbvs", image, pearson=0.9999, levels=4)


@pytest.mark.parametrize("image", IMAGES)
def test_fast_mode_equals_the_original(image: str) -> None:
    saliency = gbvs_fast(golden_input(image))
    assert_equals_golden(saliency, "gbvs_fast", image, pearson=0.9998, levels=5)


def transitions(contrast: Array) -> tuple[Array, Array]:
    """Return the weights of all steps, and their shares by where they start (in columns)."""
    height, width = contrast.shape
    v, u = (index.ravel() for index in np.indices(contrast.shape))
    squared_distances = np.subtract.outer(v, v) ** 2 + np.subtract.outer(u, u) ** 2
    sigma = 0.15 * (height + width) / 2
    values = contrast.ravel()
    weights = np.exp(-squared_distances / (2 * sigma**2))
    weights *= np.abs(np.subtract.outer(values, values))
    return weights, weights / weights.sum(axis=0)


def walked(contrast: Array, tolerance: float) -> Array:
    """Multiply with the matrix until the probabilities stay."""
    matrix = transitions(contrast)[1]
    before = np.full(contrast.size, 1 / contrast.size)
    after = matrix @ before
    while np.linalg.norm(after - before) > tolerance:
        before, after = after, matrix @ after
    return after.reshape(contrast.shape)


@pytest.mark.parametrize("size", [(24, 32), (23, 9), (9, 23), (1, 12), (12, 1), (2, 1)])
@pytest.mark.parametrize("tolerance", [1e-1, 1e-4, 3e-3])
def test_a_walk_is_as_over_the_matrix_of_all_pairs(size: tuple[int, int], tolerance: float) -> None:
    contrast = np.random.default_rng(0).random(size)
    visited = visits(contrast, closeness_table(*size), tolerance)
    np.testing.assert_allclose(visited, walked(contrast, tolerance), rtol=1e-10)
    assert visited.sum() == pytest.approx(1)


def test_a_long_walk_comes_to_where_another_step_changes_nothing() -> None:
    contrast = np.random.default_rng(0).random((12, 16))
    visited = visits(contrast, closeness_table(12, 16), 1e-15).ravel()
    np.testing.assert_allclose(transitions(contrast)[1] @ visited, visited, rtol=1e-10)


def test_a_walk_that_never_settles_is_taken_on_average() -> None:
    """Between two uniform areas every second step is back in the first."""
    contrast = np.zeros((12, 16))
    contrast[:, :5] = 1
    visited = visits(contrast, closeness_table(12, 16), 1e-4)
    matrix = transitions(contrast)[1]
    state = np.full(contrast.size, 1 / contrast.size)
    for _ in range(LONGEST_WALK):
        state, before = matrix @ state, state
    assert np.linalg.norm(state - before) > 1e-2
    np.testing.assert_allclose(visited.ravel(), (state + before) / 2, rtol=1e-6)


def test_what_differs_is_visited_most() -> None:
    contrast = np.full((24, 32), 0.5) + np.random.default_rng(0).random((24, 32)) / 100
    contrast[10, 20] = 1
    visited = visits(contrast, closeness_table(24, 32), 1e-4)
    assert np.unravel_index(visited.argmax(), visited.shape) == (10, 20)


@pytest.mark.parametrize("method", [gbvs, gbvs_fast])
def test_the_odd_one_stands_out(method: Any) -> None:
    rgb = np.full((240, 320, 3), (90, 120, 60), np.uint8)
    rgb += np.random.default_rng(0).integers(0, 8, rgb.shape, np.uint8)
    rgb[80:120, 200:240] = (200, 40, 40)
    saliency = method(rgb)
    v, u = np.unravel_index(saliency.argmax(), saliency.shape)
    assert 70 <= v < 130
    assert 190 <= u < 250
    assert saliency[80:120, 200:240].mean() > 3 * saliency.mean()


@pytest.mark.parametrize("method", [gbvs, gbvs_fast])
@pytest.mark.parametrize("colour", [(0, 0, 0), (255, 255, 255), (17, 200, 93)])
def test_a_uniform_image_has_no_saliency(method: Any, colour: tuple[int, int, int]) -> None:
    saliency = method(np.full((131, 200, 3), colour, np.uint8))
    np.testing.assert_array_equal(saliency, np.zeros((131, 200), np.float32))


@pytest.mark.parametrize("size", [(128, 128), (129, 1500), (640, 131)])
def test_small_and_long_images_have_maps(size: tuple[int, int]) -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    before = rgb.copy()
    saliency = gbvs(rgb)
    assert (saliency.shape, saliency.dtype) == (size, np.float32)
    assert (saliency.min(), saliency.max()) == (0, 1)
    np.testing.assert_array_equal(rgb, before)


def test_a_grey_image_has_a_map() -> None:
    grey = np.random.default_rng(0).integers(0, 256, (150, 200, 1), np.uint8)
    assert gbvs(np.repeat(grey, 3, axis=2)).max() == 1


def test_only_colour_tells_apart_what_is_equally_intense() -> None:
    rgb = np.full((256, 256, 3), 200, np.uint8)
    rgb[60:120, 100:140, 1:] = 60
    intensity = gbvs(rgb, channels=("intensity",))
    np.testing.assert_array_equal(intensity, np.zeros((256, 256), np.float32))
    colour = gbvs(rgb, channels=("colour",), levels=(3,))
    assert colour[60:120, 100:140].mean() > 0.5


def test_stripes_stand_out_in_the_direction_that_is_looked_for() -> None:
    rgb = np.full((256, 256, 3), 128, np.uint8)
    period = np.where(np.arange(66) % 6 < 3, 0, 255)
    rgb[90:156, 30:96] = period[:, None, None]
    rgb[90:156, 160:226] = period[:, None]
    for angle, level, upright in ((0, True, False), (90, False, True)):
        saliency = gbvs(rgb, channels=("orientation",), levels=(1,), angles_deg=(angle,))
        left, right = saliency[100:146, 40:86].mean(), saliency[100:146, 170:216].mean()
        assert (left > 2 * right, right > 2 * left) == (level, upright)


@pytest.mark.parametrize("size", [(127, 640), (640, 127), (1, 1)])
def test_an_image_that_is_too_small_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="rgb: expected sides of at least 128 pixels"):
        gbvs(np.zeros((*size, 3), np.uint8))


@pytest.mark.parametrize("rgb", [np.zeros((200, 200), np.uint8), np.zeros((200, 200, 3))])
def test_what_is_no_image_is_refused(rgb: Array) -> None:
    with pytest.raises(ValueError, match=r"rgb: expected \(H, W, 3\) uint8"):
        gbvs(rgb)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"channels": "DIO"}, "channels: expected some of"),
        ({"channels": ()}, "channels: expected some of"),
        ({"levels": ()}, "levels: expected"),
        ({"levels": (-1,)}, "levels: expected"),
    ],
)
def test_options_are_checked(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        gbvs(np.zeros((128, 128, 3), np.uint8), **options)
