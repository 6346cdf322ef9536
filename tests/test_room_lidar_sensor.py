"""A phone's depth of a drawn room."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Camera
from curiosight.rooms import lidar_sensor
from curiosight.rooms.lidar_sensor import LidarReading, lidar_depth, lidar_size
from curiosight.rooms.sensing import Readings

Array = npt.NDArray[Any]
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
SIZE = (CAMERA.height, CAMERA.width)


def seen(depth: Array, *, infrared: float = 1.0, seed: int = 0) -> LidarReading:
    """Return what the phone reads of a frontal scene of one material."""
    cosine, share = np.ones(SIZE, np.float32), np.full(SIZE, infrared, np.float32)
    return lidar_depth(depth.astype(np.float32), cosine, share, CAMERA, np.random.default_rng(seed))


def wall(metres: float) -> Array:
    return np.full(SIZE, metres)


def step(near: float, far: float) -> Array:
    """Return the depth of a board before a wall, from column 320 on."""
    return np.where(np.arange(SIZE[1]) < 320, far, near) * np.ones((SIZE[0], 1))


@pytest.mark.parametrize(("metres", "sigma"), [(1.0, 0.005), (2.0, 0.008), (4.0, 0.014)])
def test_error_is_a_centimetre_that_whole_regions_share(metres: float, sigma: float) -> None:
    errors = np.array([seen(wall(metres), seed=seed).depth - metres for seed in range(4)])
    assert np.std(errors) == pytest.approx(sigma, rel=0.1)
    assert abs(np.mean(errors)) < 0.2 * sigma
    shared = np.mean(errors[..., :-4] * errors[..., 4:]) / np.var(errors)
    assert shared > 0.85
    # From pixel to pixel it is smooth: as in a recording, some millimetres at most.
    assert np.std(np.diff(errors, axis=-1)) < 0.0015 * metres


def test_beyond_the_range_it_guesses() -> None:
    near, far = (seen(wall(metres)) for metres in (4.0, 7.0))
    assert near.confidence.min() >= 1
    assert np.mean(near.confidence == 2) > 0.9
    assert not far.confidence.any()
    assert np.isfinite(far.depth).all()
    assert np.std(far.depth) > 10 * np.std(near.depth)


def test_image_is_small_and_whole() -> None:
    reading = seen(step(1.0, 2.0))
    assert reading.depth.shape == reading.confidence.shape == (192, 256)
    assert reading.depth.dtype == np.float32
    assert reading.confidence.dtype == np.uint8
    assert np.isfinite(reading.depth).all()
    assert lidar_size(Camera(1920, 1440, 1590, 1590, 960, 720)) == (256, 192)
    assert lidar_size(Camera(1280, 720, 900, 900, 640, 360)) == (256, 144)
    assert lidar_size(Camera(160, 120, 130, 130, 80, 60)) == (160, 120)


def test_outlines_are_smoothed_over_a_pixel_or_two() -> None:
    profile = np.median(seen(step(1.0, 2.0)).depth, axis=0)
    share = profile - 1
    n_between = np.count_nonzero((share > 0.1) & (share < 0.9))
    assert 1 <= n_between <= 3
    assert profile[120] == pytest.approx(2.0, abs=0.02)
    assert profile[135] == pytest.approx(1.0, abs=0.02)
    assert (np.diff(profile[122:134]) < 0.01).all()  # no overshoot


def test_outlines_are_unsure() -> None:
    sure = seen(step(1.0, 2.0)).confidence
    at_outline = sure[:, 127:129]
    assert 0.2 < np.mean(at_outline == 0) < 0.8
    assert np.mean(at_outline == 2) < 0.05
    assert np.mean(sure[:, :120] == 2) > 0.99


def test_numbers_are_those_of_half_floats_in_millimetres() -> None:
    depth = np.tile(np.linspace(0.5, 4.9, SIZE[1]), (SIZE[0], 1))
    millimetres = 1000 * seen(depth).depth.astype(float)
    np.testing.assert_allclose(millimetres, np.rint(millimetres), atol=1e-3)
    found = np.unique(np.rint(millimetres[millimetres > 4100]).astype(int))
    # As in a phone's recording: 4102, 4105, 4109, 4113, …, by 1/256 m.
    possible = {int(np.floor(value + 0.5)) for value in np.arange(1024, 1400) / 256 * 1000}
    assert set(found.tolist()) <= possible
    assert len(found) > 50


def test_dark_and_clear_things_are_unsure() -> None:
    assert np.mean(seen(wall(2.0), infrared=0.8).confidence == 2) > 0.99
    assert not seen(wall(2.0), infrared=0.0).confidence.any()
    assert not seen(wall(0.1)).confidence.any()


def test_nothing_gives_nothing() -> None:
    depth = wall(2.0)
    depth[:, :100] = np.nan
    reading = seen(depth)
    assert np.isnan(reading.depth[:, :38]).all()
    assert not reading.confidence[:, :38].any()
    np.testing.assert_allclose(reading.depth[:, 44:], 2.0, atol=0.06)


def test_confidence_is_that_of_plain_numpy() -> None:
    rng = np.random.default_rng(0)
    blocks = rng.uniform(0.1, 6, (8, 12)).astype(np.float32)
    depth = np.repeat(np.repeat(blocks, 10, axis=0), 10, axis=1)
    depth[rng.random(depth.shape) < 0.01] = np.nan
    light, noise = rng.uniform(0, 0.2, depth.shape), rng.standard_normal(depth.shape)
    slope = np.zeros(depth.shape)
    for shift, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
        change = np.abs(np.roll(depth, shift, axis) - depth) / depth
        change = np.where(np.isnan(change), 1.0, change)
        edge = [slice(None)] * 2
        edge[axis] = 0 if shift > 0 else -1
        change[tuple(edge)] = 0
        slope = np.maximum(slope, change)
    doubt = slope**2 / (slope**2 + 0.03**2) + (depth / 5) ** 8
    doubt += 0.003 * depth**2 / light + 0.15 * noise
    expected = np.where(doubt < 0.5, 2, np.where(doubt < 1, 1, 0))
    expected[~(depth >= 0.2)] = 0
    sure = lidar_sensor.confidence(depth, light, noise)
    assert (sure == expected).mean() > 0.999  # float32 may round a doubt either way
    assert all((expected == value).mean() > 0.05 for value in range(3))


def test_colour_gets_the_nearest_reading_and_none_that_is_not_sure() -> None:
    depth = np.arange(1, 7, dtype=np.float32).reshape(2, 3)
    readings = Readings(depth, np.array([[0, 1, 2], [2, 2, 1]], np.uint8))
    camera = Camera(6, 4, 5, 5, 2.5, 1.5)
    rows = [[np.nan, 2, 3], [4, 5, 6]]
    expected = np.repeat(np.repeat(rows, 2, axis=0), 2, axis=1)
    np.testing.assert_array_equal(readings.registered(camera), expected)
    np.testing.assert_array_equal(Readings(depth).registered(Camera(3, 2, 5, 5, 1, 1)), depth)


def test_depth_is_the_same_for_the_same_seed() -> None:
    first, second, third = (seen(step(1.0, 3.0), seed=seed) for seed in (5, 5, 6))
    assert first.depth.tobytes() == second.depth.tobytes() != third.depth.tobytes()
    assert first.confidence.tobytes() == second.confidence.tobytes()


def test_depth_sensor_leaves_its_arguments_and_checks_them() -> None:
    depth = step(1.0, 2.0).astype(np.float32)
    ones = np.ones_like(depth)
    lidar_depth(depth, ones, ones, CAMERA, np.random.default_rng(0))
    np.testing.assert_array_equal(depth, step(1.0, 2.0))
    with pytest.raises(ValueError, match=r"infrared: expected \(480, 640\)"):
        lidar_depth(depth, ones, ones[:10], CAMERA, np.random.default_rng(0))
