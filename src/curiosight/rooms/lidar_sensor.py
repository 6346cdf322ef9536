"""What a phone with a LiDAR gives for depth: small, smooth, whole, and told how sure it is.

A few hundred points of light are measured, and made an image of 256x192 with the help of colour.
It has no holes; in exchange it runs smoothly from one surface to the next, and the phone says
where not to trust it: 0, 1 or 2 a pixel, 2 = sure (Baruch et al. 2021, "ARKitScenes"). Its error
is that of whole regions, about 1 cm at the distances of a room (Luetzenburg, Kroon and Bjørk
2021, "Evaluation of the Apple iPhone 12 Pro LiDAR for an application in geosciences"); within
some pixels it is a millimetre. In a phone's recording of a corridor, residuals of planes over 12
pixels are 1 mm up to 3 m, 3 mm at 4.5 m and 6 mm at 6 m, numbers are those that 16-bit floats in
metres can hold, and of the pixels beyond 5 m 80 % are of confidence 0, of those at outlines half.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth
from curiosight.rooms.compiling import kernel
from curiosight.rooms.depth_sensor import check_sizes, smooth_noise

Array = npt.NDArray[Any]

WIDTH = 256  # of its image; the height is that of the colour image's shape
SMOOTH_PX = 0.7
# Points lie 10 pixels apart: what is off at one is off around it.
WAVE_BLUR_PX = 8.0
WAVE_METRES, WAVE_SHARE = 0.002, 0.003
NOISE_METRES, NOISE_SHARE = 0.0002, 0.0002
MIN_METRES = 0.2
# Beyond, too little light comes back: the phone guesses, five times as far off a metre further.
MAX_METRES = 5.0
GUESSED_PER_METRE = 5.0

# Doubts add up: from a half on a reading is of confidence 1, from 1 on of 0. That of an outline
# is 1 at most: half of them are of confidence 0.
DOUBTFUL_SLOPE = 0.03  # from pixel to pixel, in shares of the distance: a doubt of a half
DOUBTFUL_LIGHT = 0.003  # share · cosine / z², 1/m², of the light that comes back
DOUBT_BLUR_PX, DOUBT_NOISE = 3.0, 0.15


@dataclass(frozen=True, slots=True, eq=False)
class LidarReading:
    """The two images of a phone, (h, w) of its own size.

    depth: float32 metres along z in whole millimetres, NaN = nothing.
    confidence: uint8, 0 = none, 1 = medium, 2 = high.
    """

    depth: Depth
    confidence: npt.NDArray[np.uint8]


def lidar_depth(
    depth: Depth, cosine: Array, infrared: Array, camera: Camera, rng: np.random.Generator
) -> LidarReading:
    """Return what a phone reads, at its own size: `lidar_size`.

    depth: (H, W) float32 true metres along z of the colour image, NaN = nothing there.
    cosine: (H, W) |cosine| between the ray and the surface's normal.
    infrared: (H, W) share of the sensor's light that the surface sends back.
    """
    check_sizes(camera, depth=depth, cosine=cosine, infrared=infrared)
    width, height = lidar_size(camera)
    waves = smooth_noise((height, width), WAVE_BLUR_PX, rng)
    doubts = smooth_noise((height, width), DOUBT_BLUR_PX, rng)
    noise = smooth_noise((height, width), 0.5, rng)
    smooth = smoothed(depth, (width, height))
    light = cv2.resize(cosine * infrared, (width, height), interpolation=cv2.INTER_AREA)
    metres = in_half_floats(smooth + waves * wave_metres(smooth) + noise * noise_metres(smooth))
    return LidarReading(metres, confidence(smooth, light, doubts))


def lidar_size(camera: Camera) -> tuple[int, int]:
    """Return (width, height) of the depth image: 256x192 for colour of 4 to 3."""
    width = min(WIDTH, camera.width)
    return width, max(1, round(width * camera.height / camera.width))


def smoothed(depth: Depth, size: tuple[int, int]) -> Array:
    """Return (h, w) float32 metres, each pixel the mean of what is around it; NaN = nothing."""
    is_there = np.isfinite(depth)
    layers = (np.where(is_there, depth, np.float32(0)), is_there.astype(np.float32))
    small = (cv2.resize(layer, size, interpolation=cv2.INTER_AREA) for layer in layers)
    total, share = (cv2.GaussianBlur(layer, (0, 0), SMOOTH_PX) for layer in small)
    return np.where(share > 0.5, total / np.maximum(share, 0.5), np.float32(np.nan))


def wave_metres(depth: Array) -> Array:
    """Return the standard deviation of the error that neighbours share, metres."""
    guessed = 1 + GUESSED_PER_METRE * np.maximum(depth - np.float32(MAX_METRES), 0)
    return np.asarray((WAVE_METRES + WAVE_SHARE * depth) * guessed, np.float32)


def noise_metres(depth: Array) -> Array:
    """Return the standard deviation of the error of each pixel, metres."""
    return np.asarray(NOISE_METRES + NOISE_SHARE * depth, np.float32)


def in_half_floats(metres: Array) -> Depth:
    """Return float32 metres as 16-bit floats hold them, in whole millimetres as files do."""
    halves = np.maximum(metres, 0).astype(np.float16).astype(np.float32)
    millimetres = np.floor(halves * np.float32(1000) + np.float32(0.5))
    reading: Depth = np.where(millimetres > 0, millimetres * np.float32(0.001), np.float32(np.nan))
    return reading


@kernel
def confidence(depth: Array, light: Array, noise: Array) -> Array:
    """Return (h, w) uint8, 0 to 2: low at outlines, far away, and where little light comes back.

    depth: (h, w) metres, NaN = nothing. light: share · cosine. noise: of standard deviation 1.
    """
    height, width = depth.shape
    sure = np.zeros((height, width), np.uint8)
    for v in range(height):
        for u in range(width):
            here = depth[v, u]
            if not here >= MIN_METRES:
                continue
            slope = 0.0
            for dv, du in ((-1, 0), (1, 0), (0, -1), (0, 1)):
                if 0 <= v + dv < height and 0 <= u + du < width:
                    step = abs(depth[v + dv, u + du] - here) / here
                    slope = max(slope, 1.0 if np.isnan(step) else step)
            doubt = slope**2 / (slope**2 + DOUBTFUL_SLOPE**2) + (here / MAX_METRES) ** 8
            doubt += DOUBTFUL_LIGHT * here**2 / max(light[v, u], 1e-6)
            doubt += DOUBT_NOISE * noise[v, u]
            sure[v, u] = 2 if doubt < 0.5 else 1 if doubt < 1 else 0
    return sure
