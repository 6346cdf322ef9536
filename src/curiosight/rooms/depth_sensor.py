"""What a Kinect v1 reads of a scene whose depth is known exactly.

The sensor throws a pattern of dots and finds it again in its infrared image, so all its faults
are those of triangulation: noise and steps that grow with z², a shadow to the left of near
things, ragged outlines, holes where too little of the pattern comes back. Without this module
a rendered depth is a perfect sensor's: every pixel, at any range.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth
from curiosight.rooms.compiling import kernel

Array = npt.NDArray[Any]

MIN_METRES = 0.5
MAX_METRES = 4.5
BASELINE_METRES = 0.075
INFRARED_FOCAL_PX = 580.0
# The sensor tells disparities of an eighth of a pixel apart: one step of inverse depth, 1/m.
INVERSE_STEP = 1 / (8 * INFRARED_FOCAL_PX * BASELINE_METRES)

# The sensor compares blocks of dots: what is narrower neither hides nor loses anything.
BLOCK_PX = 7
MIN_SHADOW_PX = 2.0
# Neighbouring pixels look at much the same dots: as correlated as in recordings of flat things.
NOISE_BLUR_PX = 2.0
OUTLINE_BLUR_PX = 3.0
OUTLINE_SHIFT_PX = 1.3
MAX_SHIFT_PX = 3.0
# Off the plane of a pixel's neighbours by this much, 1/m, another surface begins: 5 mm at 1 m.
OUTLINE_JUMP = 0.005

HOLE_BLUR_PX = 3.0
GRAZING_COSINE = 0.25
BLIND_COSINE = 0.05
# This share of the light that comes back drowns in the room's own.
DROWNED_SHARE = 0.05
# Half of the readings are lost where so little comes back: share · cosine / z², 1/m².
FAINT_LIGHT = 0.007


def kinect_depth(
    depth: Depth, cosine: Array, infrared: Array, camera: Camera, rng: np.random.Generator
) -> Depth:
    """Return what a Kinect v1, registered to colour, reads: (H, W) float32 metres, NaN = nothing.

    depth: (H, W) float32 true metres along z, NaN = nothing there.
    cosine: (H, W) |cosine| between the ray and the surface's normal.
    infrared: (H, W) share of the sensor's light that the surface sends back.

    Lengths in pixels (of outlines, holes, noise) are those of a 640x480 image.
    """
    check_sizes(camera, depth=depth, cosine=cosine, infrared=infrared)
    size = (camera.height, camera.width)
    noise = smooth_noise(size, NOISE_BLUR_PX, rng)
    holes = smooth_noise(size, HOLE_BLUR_PX, rng)
    shift_u, shift_v = (smooth_noise(size, OUTLINE_BLUR_PX, rng) for _ in range(2))
    inverse = np.reciprocal(depth)
    inverse[cast_shadows(inverse, camera.fx * BASELINE_METRES)] = np.nan
    source = fray_outlines(inverse, shift_u, shift_v)
    block = (BLOCK_PX, BLOCK_PX)
    surface = cv2.blur(cosine, block), cv2.blur(infrared, block)
    flat = [image.ravel() for image in (inverse, *surface, source, noise, holes)]
    reading: Depth = read(*flat).reshape(size)
    return reading


def check_sizes(camera: Camera, **images: Array) -> None:
    """Raise ValueError for an image, given by its name, that is not (H, W) as the camera's."""
    size = (camera.height, camera.width)
    for name, image in images.items():
        if image.shape != size:
            raise ValueError(f"{name}: expected {size} like the camera's image, got {image.shape}")


def smooth_noise(size: tuple[int, int], blur_px: float, rng: np.random.Generator) -> Array:
    """Draw (H, W) float32 noise, white but for a blur of `blur_px` pixels, standard deviation 1."""
    height, width = size
    # As coarse as the blur hides: a fraction of the random numbers.
    step = max(1, int(blur_px))
    coarse = rng.random((-(-height // step), -(-width // step)), np.float32) - np.float32(0.5)
    coarse = cv2.GaussianBlur(coarse, (0, 0), blur_px / step)
    field: Array = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_LINEAR)
    field *= math.sqrt(field.size) / cv2.norm(field)
    return field


@kernel
def cast_shadows(inverse: Array, focal_baseline: float) -> Array:
    """Tell which pixels the projector, a baseline to the right of the camera, cannot see.

    inverse: (H, W) 1/m, NaN = nothing. focal_baseline: pixels · metres, so that the product is
    the disparity: a point at column u is in the projector's column u - disparity, where the
    largest disparity of a row hides the others.
    """
    height, width = inverse.shape
    is_hidden = np.zeros((height, width), np.bool_)
    margin = int(focal_baseline / 0.3) + 2  # nearer than 0.3 m nothing hides anything
    nearest = np.empty(width + margin + 2)
    for v in range(height):
        nearest[:] = 0.0
        for u in range(width):
            disparity = focal_baseline * inverse[v, u]
            if disparity < margin:
                column = int(u - disparity + margin)
                # Two columns: a surface that the projector sees stretched leaves no gaps.
                nearest[column] = max(nearest[column], disparity)
                nearest[column + 1] = max(nearest[column + 1], disparity)
        for u in range(width):
            disparity = focal_baseline * inverse[v, u]
            if disparity < margin:
                column = int(u - disparity + margin)
                hiding = min(nearest[column], nearest[column + 1])
                # A shadow is as wide as its step in disparity.
                is_hidden[v, u] = hiding > disparity + MIN_SHADOW_PX
    return is_hidden


@kernel
def fray_outlines(inverse: Array, shift_u: Array, shift_v: Array) -> Array:
    """Return (H, W) int32 places, v · W + u, that the pixels take their reading from.

    A pixel whose neighbour at (shift_v, shift_u) lies on another surface, or in a hole, reads
    that one; all others read themselves.
    """
    height, width = inverse.shape
    source = np.empty((height, width), np.int32)
    for v in range(height):
        for u in range(width):
            du = round(min(max(OUTLINE_SHIFT_PX * shift_u[v, u], -MAX_SHIFT_PX), MAX_SHIFT_PX))
            dv = round(min(max(OUTLINE_SHIFT_PX * shift_v[v, u], -MAX_SHIFT_PX), MAX_SHIFT_PX))
            other_u = min(max(u + du, 0), width - 1)
            other_v = min(max(v + dv, 0), height - 1)
            other = inverse[other_v, other_u]
            source[v, u] = v * width + u
            if not abs(other - inverse[v, u]) < OUTLINE_JUMP:
                plane = _plane_through(inverse, v, u, other_v, other_u)
                if not abs(other - plane) < OUTLINE_JUMP:
                    source[v, u] = other_v * width + other_u
    return source


@kernel
def _plane_through(inverse: Array, v: int, u: int, other_v: int, other_u: int) -> float:
    """Return the inverse depth at another pixel if the surface at (v, u) went on evenly."""
    height, width = inverse.shape
    here = inverse[v, u]
    left = inverse[v, u - 1] if u > 0 else np.nan
    right = inverse[v, u + 1] if u < width - 1 else np.nan
    above = inverse[v - 1, u] if v > 0 else np.nan
    below = inverse[v + 1, u] if v < height - 1 else np.nan
    slope_u, slope_v = _slope(left, here, right), _slope(above, here, below)
    return float(here + slope_u * (other_u - u) + slope_v * (other_v - v))


@kernel
def _slope(before: float, here: float, after: float) -> float:
    """Return the flatter of the two one-sided slopes: across an outline, that of the inside."""
    back, ahead = here - before, after - here
    if np.isnan(back) or abs(ahead) < abs(back):
        back = ahead
    return 0.0 if np.isnan(back) else back


@kernel
def read(
    inverse: Array, cosine: Array, infrared: Array, source: Array, noise: Array, holes: Array
) -> Array:
    """Return (N,) float32 metres: what each pixel's source gives, NaN where it gives nothing.

    All are (N,), images flattened. noise, holes: smooth noise of standard deviation 1.
    """
    reading = np.empty(len(source), np.float32)
    for pixel in range(len(source)):
        place = source[pixel]
        depth = 1 / inverse[place]
        chance = loss(depth, cosine[place], infrared[place])
        noisy = inverse[place] + noise[pixel] * noise_before_steps(depth) / depth**2
        steps = np.floor(noisy / INVERSE_STEP + 0.5)
        rounded = 1 / (steps * INVERSE_STEP)
        is_read = MIN_METRES <= rounded <= MAX_METRES and holes[pixel] >= normal_quantile(chance)
        reading[pixel] = rounded if is_read else math.nan
    return reading


@kernel
def loss(depth: float, cosine: float, infrared: float) -> float:
    """Return the chance that the sensor finds nothing: the ray grazes, or it is too dark."""
    grazing = max(GRAZING_COSINE - cosine, 0.0) / (GRAZING_COSINE - BLIND_COSINE)
    light = max(infrared - DROWNED_SHARE, 0.0) * cosine / depth**2
    faint = 1 / (1 + (light / FAINT_LIGHT) ** 4)
    return min(max(grazing**2, faint), 1.0)


@kernel
def normal_quantile(chance: float) -> float:
    """Return what a normal number is below with this chance, by a logistic one: to 0.01."""
    if chance < 1e-3:
        return -np.inf
    return math.log(chance / (1 - chance)) / 1.702 if chance < 1 else np.inf


@kernel
def noise_before_steps(depth: float) -> float:
    """Return the standard deviation that rounding brings up to 1.2 mm + 1.9 mm · (z - 0.4)²."""
    sigma = 0.0012 + 0.0019 * (depth - 0.4) ** 2
    step = INVERSE_STEP * depth**2
    return math.sqrt(sigma**2 - step**2 / 12)
