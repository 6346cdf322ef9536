"""A Kinect's depth of a drawn room."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Camera
from curiosight.rooms import depth_sensor
from curiosight.rooms.depth_sensor import INVERSE_STEP, kinect_depth

Array = npt.NDArray[Any]
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
FOCAL_BASELINE = 525.0 * 0.075


def seen(depth: Array, *, cosine: float = 1.0, infrared: float = 1.0, seed: int = 0) -> Array:
    """Return what the sensor reads of a scene of one material, everywhere equally slanted."""
    size = depth.shape
    cosines, infrareds = np.full(size, cosine, np.float32), np.full(size, infrared, np.float32)
    rng = np.random.default_rng(seed)
    return kinect_depth(depth.astype(np.float32), cosines, infrareds, CAMERA, rng)


def wall(metres: float) -> Array:
    """Return the depth of a nearly frontal wall: all steps of disparity are met."""
    slant = np.linspace(1, 1.02, CAMERA.width) * np.linspace(1, 1.02, CAMERA.height)[:, None]
    return metres * slant


def step(near: float = 1.0, far: float = 2.0, left: int = 200, right: int = 400) -> Array:
    """Return the depth of a board that stands before a wall, between two columns."""
    depth = np.full((CAMERA.height, CAMERA.width), far)
    depth[:, left:right] = near
    return depth


@pytest.mark.parametrize("metres", [0.6, 1.0, 1.5, 2.0, 3.0, 4.0])
def test_noise_is_that_of_a_kinect(metres: float) -> None:
    depth = wall(metres)
    sigma = 0.0012 + 0.0019 * (depth.mean() - 0.4) ** 2
    errors = np.array([seen(depth, seed=seed) - depth for seed in range(4)])
    assert np.nanstd(errors) == pytest.approx(sigma, rel=0.1)
    assert abs(np.nanmean(errors)) < 0.1 * sigma


def test_noise_is_as_correlated_as_a_recordings() -> None:
    errors = 1 / seen(wall(2.0)) - 1 / wall(2.0)
    correlation = [np.mean(errors[:, :-k] * errors[:, k:]) / np.var(errors) for k in (1, 2, 4, 16)]
    # Of flat pieces of the 7-Scenes kitchen: 0.66, 0.53, 0.31, about 0.
    np.testing.assert_allclose(correlation, [0.66, 0.53, 0.31, 0.0], atol=0.15)


def test_disparity_is_quantised() -> None:
    reading = seen(wall(3.0))
    steps = 1 / (reading[np.isfinite(reading)].astype(float) * INVERSE_STEP)
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-3)
    np.testing.assert_allclose(INVERSE_STEP, 0.00287, atol=1e-5)
    assert len(np.unique(np.rint(steps))) > 5


@pytest.mark.parametrize(("near", "far"), [(0.8, 3.0), (1.0, 2.0), (1.5, 3.5)])
def test_shadow_is_at_the_left_of_near_things(near: float, far: float) -> None:
    is_hole = np.isnan(seen(step(near, far)))
    width = FOCAL_BASELINE * (1 / near - 1 / far)
    assert is_hole[:, 100:300].sum(axis=1).mean() == pytest.approx(width, abs=1.5)
    last = np.where(is_hole, np.arange(640), 0).max(axis=1)
    assert np.median(last) == pytest.approx(199, abs=2)
    assert is_hole[:, 390:].mean() < 0.001


def test_light_falls_behind_thin_things() -> None:
    """A pole's shadow is as wide as the pole, and lies apart from it."""
    inverse = (1 / step(1.0, 3.0, 300, 306)).astype(np.float32)
    (hidden,) = np.nonzero(depth_sensor.cast_shadows(inverse, FOCAL_BASELINE)[0])
    disparity = FOCAL_BASELINE * (1 - 1 / 3)
    assert abs(hidden.min() - (300 - disparity)) <= 1
    assert abs(hidden.max() - (305 - disparity)) <= 1


def test_slanted_surfaces_have_no_shadow() -> None:
    floor = 1.0 / np.linspace(0.25, 1.5, CAMERA.height)[:, None] * np.ones(CAMERA.width)
    side_wall = 1.0 / np.linspace(0.3, 1.5, CAMERA.width) * np.ones((CAMERA.height, 1))
    for depth in (floor, side_wall, side_wall[:, ::-1]):
        inverse = (1 / depth).astype(np.float32)
        assert not depth_sensor.cast_shadows(inverse, FOCAL_BASELINE).any()


def test_shadows_are_those_of_a_plain_search() -> None:
    rng = np.random.default_rng(3)
    depth = np.repeat(rng.uniform(0.8, 4.0, (20, 16)), 12, axis=1)
    depth[rng.random(depth.shape) < 0.05] = np.nan
    disparity = FOCAL_BASELINE / depth
    column = np.floor(np.arange(depth.shape[1]) - disparity)
    expected = np.zeros(depth.shape, bool)
    for v, u in zip(*np.nonzero(np.isfinite(depth)), strict=True):
        hiding = [
            disparity[v, np.isin(column[v], (place - 1, place))].max()
            for place in (column[v, u], column[v, u] + 1)
        ]
        expected[v, u] = min(hiding) > disparity[v, u] + depth_sensor.MIN_SHADOW_PX
    inverse = (1 / depth).astype(np.float32)
    is_hidden = depth_sensor.cast_shadows(inverse, FOCAL_BASELINE)
    assert (is_hidden == expected).mean() > 0.999  # a column may round either way


def test_outlines_are_ragged_and_planes_are_not_torn() -> None:
    reading = seen(step(1.0, 1.3))
    edge = (np.abs(reading - 1.0) < 0.1)[:, 380:420].sum(axis=1) + 380
    assert np.median(edge) == pytest.approx(400, abs=1)
    assert 0.5 < np.std(edge) < 2
    assert np.abs(edge - 400).max() <= 4
    floor = (1.0 / np.linspace(0.4, 1.6, 480)[:, None] * np.ones(640)).astype(np.float32)
    shift = np.full((480, 640), 9.0, np.float32)
    source = depth_sensor.fray_outlines(1 / floor, shift, shift)
    np.testing.assert_array_equal(source, np.arange(source.size).reshape(source.shape))


def test_range_is_limited() -> None:
    reading = seen(np.tile(np.linspace(0.3, 6.0, 480)[:, None], 640))
    assert np.isfinite(reading[30:340]).mean() > 0.95
    assert np.nanmin(reading) >= 0.5
    assert np.nanmax(reading) <= 4.5
    assert np.isnan(reading[:10]).all()
    assert np.isnan(reading[380:]).all()
    assert np.isnan(seen(np.full((480, 640), np.nan))).all()


def test_holes_grow_as_rays_graze() -> None:
    shares = [np.isnan(seen(wall(1.5), cosine=c)).mean() for c in (0.6, 0.3, 0.2, 0.15, 0.1, 0.02)]
    np.testing.assert_allclose(shares, [0, 0, 0.06, 0.25, 0.56, 1], atol=0.05)


def test_dark_and_clear_things_give_no_reading() -> None:
    def share(metres: float, infrared: float) -> float:
        return float(np.isnan(seen(wall(metres), infrared=infrared)).mean())

    assert share(1.0, 0.02) == 1
    assert share(1.0, 0.1) < 0.05 < 0.5 < share(3.5, 0.1)
    assert share(4.0, 0.8) < 0.01


def test_holes_are_blobs() -> None:
    is_hole = np.isnan(seen(wall(1.5), cosine=0.15))
    n_holes = cv2.connectedComponents(is_hole.astype(np.uint8))[0] - 1
    assert is_hole.sum() / n_holes > 100


def test_reading_is_that_of_plain_numpy() -> None:
    rng = np.random.default_rng(0)
    n = 2000
    depth, cosine, infrared = rng.uniform(0.4, 5, n), rng.random(n), rng.random(n)
    noise, holes = rng.standard_normal((2, n))
    source = rng.integers(0, n, n).astype(np.int32)
    reading = depth_sensor.read(1 / depth, cosine, infrared, source, noise, holes)

    z, c, share = depth[source], cosine[source], infrared[source]
    light = np.maximum(share - 0.05, 0) * c / z**2
    with np.errstate(divide="ignore"):
        grazing = (np.maximum(0.25 - c, 0) / 0.2) ** 2
        lost = np.clip(np.maximum(grazing, 1 / (1 + (light / 0.007) ** 4)), 0, 1)
        is_lost = np.log(lost / (1 - lost)) / 1.702 > holes
    sigma = np.sqrt((0.0012 + 0.0019 * (z - 0.4) ** 2) ** 2 - (INVERSE_STEP * z**2) ** 2 / 12)
    expected = 1 / (INVERSE_STEP * np.rint((1 / z + noise * sigma / z**2) / INVERSE_STEP))
    expected[is_lost & (lost > 0.001) | (expected < 0.5) | (expected > 4.5)] = np.nan
    np.testing.assert_allclose(reading, expected, rtol=1e-6)
    assert 0.2 < np.isnan(expected).mean() < 0.8


def test_depth_is_the_same_for_the_same_seed() -> None:
    first, second, third = (seen(step(), seed=seed) for seed in (5, 5, 6))
    assert first.dtype == np.float32
    assert first.tobytes() == second.tobytes() != third.tobytes()


def test_depth_sensor_leaves_its_arguments_and_checks_them() -> None:
    depth = step().astype(np.float32)
    ones = np.ones_like(depth)
    kinect_depth(depth, ones, ones, CAMERA, np.random.default_rng(0))
    np.testing.assert_array_equal(depth, step())
    with pytest.raises(ValueError, match=r"cosine: expected \(480, 640\)"):
        kinect_depth(depth, ones[:10], ones, CAMERA, np.random.default_rng(0))
