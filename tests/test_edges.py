"""The guided filter of blocks, against the plain one."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.learner.edges import EdgeFilter, sum_windows

TOLERANCE = 64.0


def windows(values: np.ndarray, radius: int) -> np.ndarray:
    """Return the sums over the windows of (h, w, k), which the border cuts."""
    height, width = values.shape[:2]
    sums = np.empty_like(values)
    for v in range(height):
        for u in range(width):
            part = values[max(v - radius, 0) : v + radius + 1, max(u - radius, 0) : u + radius + 1]
            sums[v, u] = part.sum(axis=(0, 1))
    return sums


def guided_plainly(saliency: np.ndarray, rgb: np.ndarray, stride: int) -> np.ndarray:
    """Find a linear function a window of blocks by linear algebra, average, and interpolate."""
    height, width = saliency.shape
    colours = np.concatenate([rgb.astype(float), np.ones((height, width, 1))], axis=2)
    products = (
        colours[..., None] * np.concatenate([colours, saliency[..., None]], axis=2)[:, :, None]
    )
    n_down, n_across = -(-height // stride), -(-width // stride)
    blocks = np.zeros((n_down, n_across, 20))
    for v in range(height):
        for u in range(width):
            blocks[v // stride, u // stride] += products[v, u].ravel()
    radius = max(1, round(8 / stride))
    functions = np.empty((n_down, n_across, 4))
    for v, line in enumerate(windows(blocks, radius)):
        for u, sums in enumerate(line):
            matrix = sums.reshape(4, 5) / sums.reshape(4, 5)[3, 3]
            covariance = matrix[:3, :3] - np.outer(matrix[3, :3], matrix[3, :3])
            wanted = matrix[:3, 4] - matrix[:3, 3] * matrix[3, 4]
            factors = np.linalg.solve(covariance + TOLERANCE * np.eye(3), wanted)
            functions[v, u] = [*factors, matrix[3, 4] - factors @ matrix[3, :3]]
    functions = windows(functions, radius) / windows(np.ones((n_down, n_across, 1)), radius)
    y = np.clip((np.arange(height) + 0.5) / stride - 0.5, 0, n_down - 1)
    x = np.clip((np.arange(width) + 0.5) / stride - 0.5, 0, n_across - 1)
    lines = np.stack([_interpolated(functions[:, :, k].T, y).T for k in range(4)], axis=2)
    full = np.stack([_interpolated(lines[:, :, k], x) for k in range(4)], axis=2)
    return np.clip((full * colours).sum(axis=2), 0, 1)


def _interpolated(lines: np.ndarray, places: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(places, np.arange(len(line)), line) for line in lines])


def scene(seed: int, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a rough map, and an image with an edge and noise."""
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 40, (height, width, 3)).astype(np.uint8)
    rgb[height // 3 :, width // 2 :] += np.uint8(150)
    blocks = rng.random((height // 5 + 1, width // 5 + 1)).astype(np.float32)
    return blocks.repeat(5, axis=0).repeat(5, axis=1)[:height, :width].copy(), rgb


@pytest.mark.parametrize(("stride", "size"), [(2, (40, 52)), (3, (41, 50)), (4, (37, 45))])
def test_blocks_equal_the_plain_filter(stride: int, size: tuple[int, int]) -> None:
    saliency, rgb = scene(stride, *size)
    found = EdgeFilter(rgb, stride)(saliency)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, guided_plainly(saliency, rgb, stride), atol=2e-4)


def test_coarse_and_fine_are_nearly_alike() -> None:
    saliency, rgb = scene(0, 120, 160)
    difference = np.abs(EdgeFilter(rgb, 2)(saliency) - EdgeFilter(rgb)(saliency))
    assert difference.mean() < 0.01
    assert difference.max() < 0.08


@pytest.mark.parametrize("stride", [1, 2, 4])
def test_a_rough_outline_moves_to_the_edge(stride: int) -> None:
    rgb = np.zeros((60, 80, 3), np.uint8)
    rgb[:, 40:] = (200, 120, 40)
    saliency = np.zeros((60, 80), np.float32)
    saliency[:, 36:] = 1
    sharp = EdgeFilter(rgb, stride)(saliency)
    steps = np.diff(sharp, axis=1)
    assert (np.argmax(steps, axis=1) == 39).all()
    assert steps[:, 39].min() > 0.3
    assert np.delete(steps, 39, axis=1).max() < 0.1


def test_windows_are_summed_right_wider_than_the_image_too() -> None:
    values = np.random.default_rng(0).random((9, 13, 3)).astype(np.float32)
    for radius in (1, 2, 8, 20):
        np.testing.assert_allclose(sum_windows(values, radius), windows(values, radius), rtol=1e-5)
