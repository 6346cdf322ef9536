"""The spectral residual against the original's maps."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.evaluation.baselines import METHODS, opencv
from curiosight.evaluation.baselines.spectral_residual import spectral_residual
from golden_maps import IMAGES, assert_equals_golden, golden_input


@pytest.mark.parametrize("image", IMAGES)
def test_equals_the_original(image: str) -> None:
    saliency = spectral_residual(golden_input(image), is_small=True)
    program = "spectral_residual_hou"
    assert_equals_golden(saliency, program, image, pearson=1 - 1e-6, levels=1)


def test_the_map_is_brought_to_the_size_of_the_image() -> None:
    rgb = golden_input("sk_chelsea")
    small, large = (spectral_residual(rgb, is_small=small) for small in (True, False))
    assert small.shape == (43, 64)
    assert large.shape == rgb.shape[:2]
    # The middle of a small pixel keeps its value.
    scale = np.array(rgb.shape[:2]) / small.shape
    v, u = (np.array([[10, 20], [30, 50]]) + 0.5).T * scale[:, None] - 0.5
    expected = small[[10, 30], [20, 50]]
    assert large[v.round().astype(int), u.round().astype(int)] == pytest.approx(expected, abs=0.05)


def test_the_method_of_the_command_is_the_authors_own() -> None:
    assert METHODS["spectral-residual"] is spectral_residual
    rgb = golden_input("sk_rocket")
    ours, theirs = spectral_residual(rgb), opencv.spectral_residual(rgb)
    assert ours.shape == theirs.shape
    assert not np.allclose(ours, theirs, atol=0.1)


def test_what_breaks_a_texture_stands_out() -> None:
    rng = np.random.default_rng(0)
    rgb = np.repeat(rng.normal(120, 4, (96, 128, 1)), 3, axis=2).astype(np.uint8)
    rgb[40:56, 70:80] = 240
    saliency = spectral_residual(rgb)
    v, u = np.unravel_index(saliency.argmax(), saliency.shape)
    assert 36 <= v < 60
    assert 66 <= u < 84
    assert saliency[:, :40].mean() < 0.2
