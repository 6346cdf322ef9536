"""The sensors of a drawn room: a Kinect's depth, a cheap camera's colour."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.datasets.decoding import read_rgb
from curiosight.frame import Camera
from curiosight.worlds.rooms import colour_sensor, depth_sensor
from curiosight.worlds.rooms.colour_sensor import RESPONSE, Look, develop, draw_look, expose
from curiosight.worlds.rooms.depth_sensor import INVERSE_STEP, kinect_depth

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


def grey(light: float | Array, look: Look, seed: int = 0) -> Array:
    """Return the picture of a grey scene of (H, W) light."""
    light = np.broadcast_to(light, (120, 160)).astype(np.float32)
    return develop(np.repeat(light[..., None], 3, axis=2), look, np.random.default_rng(seed))


PLAIN = Look(vignetting=0.0, noise=0.0)


@pytest.mark.parametrize("brightness", [1e-3, 1.0, 1e3])
def test_exposure_is_automatic(brightness: float) -> None:
    light = brightness * np.random.default_rng(0).uniform(0.2, 1.0, (120, 160))
    assert grey(light, PLAIN).mean() == pytest.approx(125, abs=8)
    light[:40, :80] = 50 * brightness  # a window
    assert grey(light, PLAIN).mean() == pytest.approx(125, abs=8)
    assert (
        grey(light, Look(0.5)).mean() < grey(light, Look()).mean() < grey(light, Look(2.0)).mean()
    )


def test_response_is_srgb_with_a_soft_shoulder() -> None:
    light = np.linspace(0, 16**0.5, len(RESPONSE)) ** 2
    below = light < 0.7
    srgb = np.where(light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(RESPONSE[below], 255 * srgb[below], atol=0.01)
    slope = np.diff(RESPONSE[light < 2].astype(float)) / np.diff(light[light < 2])
    assert (slope > 0).all()
    assert RESPONSE[light < 1][-1] < 245
    assert RESPONSE[-1] == pytest.approx(255)


def test_white_balance_and_vignetting() -> None:
    warm = grey(1.0, Look(white_balance=(1.2, 1.0, 0.8), vignetting=0.0, noise=0.0))
    red, green, blue = warm.reshape(-1, 3).mean(0)
    assert red > green + 5 > blue + 10
    dark_corners = grey(1.0, Look(vignetting=0.3, noise=0.0))
    assert dark_corners[60, 80].max() > dark_corners[0, 0].max() + 10


def test_noise_has_the_strength_and_grain_of_a_real_cameras() -> None:
    pictures = np.array([grey(1.0, Look(vignetting=0.0, noise=1.2), seed) for seed in range(8)])
    noise = pictures - pictures.mean()
    red, green, blue = noise.std((0, 1, 2))
    assert 1.2 < green < 1.8
    assert 1.2 < red < 1.9
    assert 1.2 < blue / green < 2.2
    neighbour = (noise[:, :, 1:] * noise[:, :, :-1]).mean() / noise.var()
    assert 0.45 < neighbour < 0.75


def test_motion_blurs_along_its_direction() -> None:
    light = np.full((120, 160), 0.05)
    light[60, 80] = 0.5
    for motion_px, length, across in (((8, 0), 0, 1), ((0, 8), 1, 0)):
        picture = grey(light, Look(vignetting=0.0, noise=0.0, motion_px=motion_px))
        lit = np.argwhere(picture[..., 0] > picture[0, 0, 0] + 8)
        extents = np.ptp(lit[:, 1]), np.ptp(lit[:, 0])
        assert 7 <= extents[length] <= 11
        assert extents[across] <= 3


def test_exposed_picture_is_that_of_plain_numpy() -> None:
    rng = np.random.default_rng(0)
    light = rng.uniform(-0.1, 3, (24, 32, 3)).astype(np.float32)
    noise = rng.standard_normal((24, 32)).astype(np.float32)
    colour = rng.standard_normal((24, 32, 3)).astype(np.float32)
    gains = np.array([1.1, 1.0, 0.9])
    rgb = expose(light, gains, 0.3, 1.5, noise, colour, RESPONSE)
    v, u = np.mgrid[:24, :32]
    share = 1 - 0.3 * ((u - 16) ** 2 + (v - 12) ** 2) / (16**2 + 12**2)
    root = np.sqrt(np.maximum(light * gains * share[..., None], 0))
    level = RESPONSE[np.rint(root * (len(RESPONSE) - 1) / 4).astype(int)]
    expected = np.clip(np.rint(level + 1.5 * (noise[..., None] + colour)), 0, 255)
    assert np.abs(rgb - expected).max() <= 1
    assert (rgb == expected).mean() > 0.99


def test_looks_vary_and_are_the_same_for_the_same_seed() -> None:
    looks = [draw_look(np.random.default_rng(seed), blur=True) for seed in range(40)]
    assert looks[7] == draw_look(np.random.default_rng(7), blur=True)
    assert 0.1 < np.std([np.log(look.exposure) for look in looks]) < 0.2
    assert 5 < sum(look.motion_px is not None for look in looks) < 25
    assert all(draw_look(np.random.default_rng(seed)).motion_px is None for seed in range(9))


def test_pictures_are_the_same_for_the_same_seed() -> None:
    light = np.random.default_rng(0).uniform(0, 1, (120, 160))
    first, second, third = (grey(light, Look(), seed) for seed in (1, 1, 2))
    assert first.dtype == np.uint8
    assert first.tobytes() == second.tobytes() != third.tobytes()


def test_darkness_is_black() -> None:
    assert grey(0.0, PLAIN).max() == 0


@pytest.mark.parametrize(
    "change", [{"exposure": 0.0}, {"white_balance": (1, -1, 1)}, {"vignetting": 1.0}, {"noise": -1}]
)
def test_impossible_looks_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        Look(**change)


def test_radiance_is_checked() -> None:
    with pytest.raises(ValueError, match=r"radiance: expected \(H, W, 3\) float32"):
        develop(np.zeros((4, 4, 3)), Look(), np.random.default_rng(0))


def flat_noise(images: list[Array]) -> Array:
    """Return (3,) the noise of the evenest tenth of patches, in grey levels."""
    side = 12
    v, u = (np.mgrid[:side, :side] / side).reshape(2, -1)
    trend = np.column_stack([np.ones(side**2), u, v, u * v, u**2, v**2])
    detrend = np.eye(side**2) - trend @ np.linalg.pinv(trend)
    patches = [
        detrend @ image[v : v + side, u : u + side].reshape(-1, 3).astype(float)
        for image in images
        for v in range(0, image.shape[0] - side, side)
        for u in range(0, image.shape[1] - side, side)
        if 12 < image[v, u].min() <= image[v, u].max() < 245
    ]
    deviations: Array = np.percentile([patch.std(0) for patch in patches], 10, axis=0)
    return deviations


def test_noise_is_that_of_recorded_pictures() -> None:
    root = os.environ.get("CURIOSIGHT_TEST_DATA")
    if root is None:
        pytest.skip("CURIOSIGHT_TEST_DATA is not set")
    folder = Path(root) / "data/redkitchen/seq-01"
    paths = sorted(folder.glob("*.color.jpg"))[::50]
    assert paths, f"no pictures in {folder}"
    recorded = flat_noise([read_rgb(path) for path in paths])
    light = cv2.GaussianBlur(np.random.default_rng(0).random((480, 640), np.float32), (0, 0), 40)
    light = 2 * (light - light.min()) / np.ptp(light) + 0.2
    ours = flat_noise([grey(cv2.resize(light, (160, 120)), Look(), seed) for seed in range(4)])
    np.testing.assert_allclose(ours, recorded, rtol=0.8)
    assert colour_sensor.COLOUR_NOISE[2] > colour_sensor.COLOUR_NOISE[1]
