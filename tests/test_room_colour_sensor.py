"""A cheap camera's colour of a drawn room."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.datasets.decoding import read_rgb
from curiosight.rooms import colour_sensor
from curiosight.rooms.colour_sensor import RESPONSE, Look, develop, draw_look, expose

Array = npt.NDArray[Any]


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
