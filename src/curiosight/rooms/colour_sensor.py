"""Turn the light that falls into a camera into the picture that a cheap camera makes of it.

Its exposure, white balance and softness are those of a Kinect's colour camera, its noise as
measured on flat surfaces in real recordings: 1 to 2 grey levels wherever it is not too bright,
blotchy in colour because colour is transmitted at half the resolution.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb
from curiosight.rooms.compiling import kernel

Array = npt.NDArray[Any]

# What automatic exposure aims at, as the root of light: a mean grey of about 125.
MEAN_ROOT = 0.46
SOFTNESS_PX = 0.7
NOISE_BLUR_PX = 0.7
# Of red, green and blue, beside that of brightness; blue is the weakest channel indoors.
COLOUR_NOISE = (1.1, 1.0, 2.4)
# Below this share of white the response is straight; above it bends, and never quite clips.
SHOULDER = 0.7
MAX_LIGHT = 16.0
N_LEVELS = 4096


@dataclass(frozen=True, slots=True)
class Look:
    """How one picture is taken.

    exposure: in multiples of what automatic exposure chooses.
    white_balance: gain of red, green and blue.
    vignetting: share of the light that is missing in the corners.
    noise: standard deviation of brightness, in grey levels of 255.
    motion_px: (du, dv) that the image moves during the exposure; None = the camera rests.
    """

    exposure: float = 1.0
    white_balance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    vignetting: float = 0.15
    noise: float = 1.2
    motion_px: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        gains = (self.exposure, *self.white_balance)
        if not all(0 < gain < np.inf for gain in gains):
            raise ValueError(
                "exposure, white_balance: expected positive factors, "
                f"got {self.exposure}, {self.white_balance}"
            )
        if not 0 <= self.vignetting < 1 or not 0 <= self.noise < np.inf:
            raise ValueError(
                "vignetting, noise: expected 0 <= vignetting < 1 and 0 <= noise, "
                f"got {self.vignetting}, {self.noise}"
            )


def draw_look(rng: np.random.Generator, *, blur: bool = False) -> Look:
    """Draw a look; every third is blurred by motion where `blur` is set."""
    exposure = float(np.exp(rng.normal(0, 0.15)))
    red, blue = np.exp(rng.normal(0, 0.05, 2))
    vignetting, noise = (float(rng.uniform(*limits)) for limits in ((0.08, 0.25), (0.8, 1.6)))
    motion_px = None
    if blur and rng.random() < 1 / 3:
        length, direction = rng.uniform(2, 9), rng.uniform(0, np.pi)
        motion_px = (float(length * np.cos(direction)), float(length * np.sin(direction)))
    return Look(exposure, (float(red), 1.0, float(blue)), vignetting, noise, motion_px)


def develop(radiance: Array, look: Look, rng: np.random.Generator) -> Rgb:
    """Return the (H, W, 3) uint8 sRGB picture of (H, W, 3) float32 linear light."""
    if radiance.ndim != 3 or radiance.shape[2] != 3 or radiance.dtype != np.float32:
        raise ValueError(
            f"radiance: expected (H, W, 3) float32, got {radiance.shape} {radiance.dtype}"
        )
    height, width = radiance.shape[:2]
    light = cv2.GaussianBlur(radiance, (3, 3), SOFTNESS_PX)
    if look.motion_px is not None:
        light = cv2.filter2D(light, -1, _streak(look.motion_px), borderType=cv2.BORDER_REPLICATE)
    gains = _automatic_exposure(radiance) * look.exposure * np.asarray(look.white_balance)
    noises = brightness_noise(height, width, rng), colour_noise(height, width, rng)
    rgb: Rgb = expose(light, gains, look.vignetting, look.noise, *noises, RESPONSE)
    return rgb


def brightness_noise(height: int, width: int, rng: np.random.Generator) -> Array:
    """Draw (H, W) float32 noise of standard deviation 1, smooth as demosaicing leaves it."""
    taps = cv2.getGaussianKernel(5, NOISE_BLUR_PX)
    taps = taps / np.linalg.norm(taps)
    noise: Array = cv2.sepFilter2D(_white_noise((height, width), rng), -1, taps, taps)
    return noise


def colour_noise(height: int, width: int, rng: np.random.Generator) -> Array:
    """Draw (H, W, 3) float32 noise of half the resolution, strongest in blue."""
    coarse = _white_noise(((height + 1) // 2, (width + 1) // 2, 3), rng)
    noise: Array = cv2.resize(coarse * np.array(COLOUR_NOISE, np.float32), (width, height))
    return noise


def _white_noise(shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Draw float32 noise of standard deviation 1, evenly spread: the filters make it normal."""
    noise = rng.random(shape, np.float32)
    noise -= np.float32(0.5)
    noise *= np.float32(12**0.5)
    return noise


def _automatic_exposure(radiance: Array) -> float:
    """Return the gain that brings the mean of the picture to `MEAN_ROOT`; 1 for darkness."""
    root = np.sqrt(np.maximum(radiance[::8, ::8], 0))
    if not root.any():
        return 1.0
    gain = MEAN_ROOT / float(root.mean())
    for _ in range(3):  # a lamp or a window counts as no more than white
        gain *= MEAN_ROOT / float(np.minimum(root * gain, 1).mean())
    return gain**2


def _streak(motion_px: tuple[float, float]) -> Array:
    """Return the kernel that smears along a line of (du, dv) pixels."""
    du, dv = motion_px
    n_steps = 4 * int(np.ceil(max(abs(du), abs(dv), 1)))
    radius = int(np.ceil(max(abs(du), abs(dv)) / 2)) + 1
    smear = np.zeros((2 * radius + 1, 2 * radius + 1), np.float32)
    for share in np.linspace(-0.5, 0.5, n_steps):
        u, v = radius + share * du, radius + share * dv
        left, top = int(u), int(v)
        right, low = u - left, v - top
        weights = np.outer([1 - low, low], [1 - right, right])
        smear[top : top + 2, left : left + 2] += weights
    smear /= smear.sum()
    return smear


def _response() -> Array:
    """Return (N_LEVELS,) grey levels, 0 to 255, for light whose root goes evenly to the limit."""
    light = np.linspace(0, np.sqrt(MAX_LIGHT), N_LEVELS) ** 2
    room = 1 - SHOULDER
    bent = np.where(light < SHOULDER, light, 1 - room * np.exp((SHOULDER - light) / room))
    srgb = np.where(bent < 0.0031308, 12.92 * bent, 1.055 * bent ** (1 / 2.4) - 0.055)
    return (255 * srgb).astype(np.float32)


RESPONSE = _response()


@kernel
def expose(
    light: Array,
    gains: Array,
    vignetting: float,
    noise: float,
    brightness: Array,
    colour: Array,
    response: Array,
) -> Array:
    """Return (H, W, 3) uint8: light times gain, darker towards the corners, through the response.

    brightness (H, W) and colour (H, W, 3) are noise, here scaled to `noise` grey levels. Shot
    noise grows with the root of light, which gamma undoes: it is even over the grey levels.
    """
    height, width = brightness.shape
    per_root = (len(response) - 1) / math.sqrt(MAX_LIGHT)
    corner = (height**2 + width**2) / 4
    rgb = np.empty((height, width, 3), np.uint8)
    for v in range(height):
        for u in range(width):
            to_centre = (u - width / 2) ** 2 + (v - height / 2) ** 2
            share = 1 - vignetting * to_centre / corner
            for channel in range(3):
                root = math.sqrt(max(light[v, u, channel] * gains[channel] * share, 0.0))
                level = response[min(int(root * per_root + 0.5), len(response) - 1)]
                level += noise * (brightness[v, u] + colour[v, u, channel])
                rgb[v, u, channel] = int(min(max(level + 0.5, 0.0), 255.0))
    return rgb
