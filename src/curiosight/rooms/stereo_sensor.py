"""What a stereo camera such as a RealSense D435 or a ZED reads of a scene whose depth is known.

It finds each block of its left image, which is the colour image here, in its right one. All its
faults are those of disparity: an error that grows with z² (Chatterjee and Govindu 2015, "Noise in
structured-light stereo depth cameras") and is the same over a block and its neighbours, so that
far surfaces are wavy; steps of a fraction of a pixel; nothing where the right image does not
reach, at the left of the image, nor at the left of near things; and nothing where neither the
scene nor the projector's dots give a block anything to be found by.

Grunnet-Jepsen, Sweetser and Woodfill ("Tuning depth cameras for best performance", Intel) put
the error at z² · subpixel / (focal length · baseline), and the steps at 1/32 pixel ("Subpixel
linearity improvement", Intel). The numbers below are those of flat pieces of a D435's recording,
in windows of 64 pixels: a subpixel of 0.05 up to 2 m, 0.15 at 4 m and 0.3 at 6 m and more, where
few pieces are flat, so that we take less; correlations of 0.93, 0.90, 0.78, 0.47 and 0 at
distances of 1, 2, 4, 8 and 16 pixels; steps of 1/32.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth
from curiosight.rooms.compiling import kernel
from curiosight.rooms.depth_sensor import (
    OUTLINE_BLUR_PX,
    cast_shadows,
    check_sizes,
    fray_outlines,
    normal_quantile,
    smooth_noise,
)

Array = npt.NDArray[Any]

MIN_METRES = 0.28
# Cameras go on for ever; their makers and users cut there.
MAX_METRES = 12.0
BASELINE_METRES = 0.05
STEPS_PER_PX = 32
STEP_METRES = 0.001

# Disparity of a block of some 9 pixels: noise, and the waves of what is too far for the dots.
NOISE_PX, NOISE_BLUR_PX = 0.045, 4.5
WAVE_PX, WAVE_BLUR_PX = 0.3, 12.0
# Where waves have half of their variance's limit: there the projector's dots have faded.
DOTS_METRES = 5.0

# Blocks that lie on two surfaces: those that differ by this much disparity, this far away.
JUMP_PX, JUMP_REACH = 2.0, 3
LOST_AT_JUMPS = -0.3  # deviations of noise: six in ten of them
OUTLINE_STRETCH = 1.5

HOLE_BLUR_PX = 6.0
BLOCK_PX = 9
# Half of the readings are lost where a block has this contrast, and where it has no contrast but
# this share · cosine / z², 1/m², of the dots' light: white walls at 5 m.
FAINT_CONTRAST = 0.004
FAINT_DOTS = 0.02


def stereo_depth(
    depth: Depth,
    cosine: Array,
    infrared: Array,
    radiance: Array,
    camera: Camera,
    rng: np.random.Generator,
) -> Depth:
    """Return what a stereo camera reads: (H, W) float32 metres in millimetres, NaN = nothing.

    depth: (H, W) float32 true metres along z of the left image, NaN = nothing there.
    cosine: (H, W) |cosine| between the ray and the surface's normal.
    infrared: (H, W) share of the projector's light that the surface sends back.
    radiance: (H, W, 3) float32 linear light, in which texture is found.

    Lengths in pixels are those of a 640x480 image.
    """
    check_sizes(camera, depth=depth, cosine=cosine, infrared=infrared, radiance=radiance[..., 0])
    size = (camera.height, camera.width)
    focal_baseline = camera.fx * BASELINE_METRES
    noise, waves, holes = (
        smooth_noise(size, blur_px, rng) for blur_px in (NOISE_BLUR_PX, WAVE_BLUR_PX, HOLE_BLUR_PX)
    )
    shifts = [OUTLINE_STRETCH * smooth_noise(size, OUTLINE_BLUR_PX, rng) for _ in range(2)]
    inverse = np.reciprocal(depth)
    inverse[cast_shadows(inverse, focal_baseline)] = np.nan
    source = fray_outlines(inverse, *shifts)
    clues = cv2.blur(cosine * infrared, (BLOCK_PX, BLOCK_PX)), contrast(radiance)
    reading: Depth = match(inverse, *clues, source, noise, waves, holes, focal_baseline)
    return reading


def contrast(radiance: Array) -> Array:
    """Return (H, W) float32: the deviation of light over each block, in shares of its mean."""
    block = (BLOCK_PX, BLOCK_PX)
    light = cv2.transform(radiance, np.full((1, 3), 1 / 3, np.float32))
    mean = cv2.blur(light, block)
    variance = cv2.sqrBoxFilter(light, cv2.CV_32F, block) - mean * mean
    shares: Array = np.sqrt(np.maximum(variance, 0)) / np.maximum(mean, 1e-6)
    return shares


@kernel
def match(
    inverse: Array,
    dots: Array,
    contrast: Array,
    source: Array,
    noise: Array,
    waves: Array,
    holes: Array,
    focal_baseline: float,
) -> Array:
    """Return (H, W) float32 metres: what each pixel's source gives, NaN where it gives nothing.

    All are (H, W). inverse: 1/m, NaN = nothing. dots: share · cosine. source: places v · W + u.
    noise, waves, holes: smooth noise of standard deviation 1.
    """
    height, width = inverse.shape
    reading = np.full((height, width), np.nan, np.float32)
    for v in range(height):
        for u in range(width):
            at_v, at_u = source[v, u] // width, source[v, u] % width
            depth = 1 / inverse[at_v, at_u]
            if not depth > 0:
                continue
            sigmas = disparity_noise(depth)
            disparity = focal_baseline / depth
            disparity += sigmas[0] * noise[v, u] + sigmas[1] * waves[v, u]
            disparity = math.floor(disparity * STEPS_PER_PX + 0.5) / STEPS_PER_PX
            if disparity <= 0 or u < disparity:  # the right image ends there
                continue
            chance = loss(dots[at_v, at_u] / depth**2, contrast[at_v, at_u])
            is_torn = holes[v, u] > LOST_AT_JUMPS and _is_at_jump(inverse, v, u, focal_baseline)
            metres = focal_baseline / disparity
            if holes[v, u] < normal_quantile(chance) or is_torn:
                continue
            if MIN_METRES <= metres <= MAX_METRES:
                steps = np.float32(math.floor(metres / STEP_METRES + 0.5))
                reading[v, u] = steps * np.float32(STEP_METRES)
    return reading


@kernel
def disparity_noise(depth: float) -> tuple[float, float]:
    """Return the standard deviations of noise and waves, pixels."""
    far = depth**2 / (depth**2 + DOTS_METRES**2)
    return NOISE_PX * math.sqrt(1 + far), WAVE_PX * far


@kernel
def loss(dots: float, contrast: float) -> float:
    """Return the chance that a block is found nowhere: no texture, and too few dots."""
    return 1 / (1 + (contrast / FAINT_CONTRAST + dots / FAINT_DOTS) ** 4)


@kernel
def _is_at_jump(inverse: Array, v: int, u: int, focal_baseline: float) -> bool:
    """Tell whether another surface begins within a block's reach."""
    height, width = inverse.shape
    here = inverse[v, u]
    for dv, du in ((-JUMP_REACH, 0), (JUMP_REACH, 0), (0, -JUMP_REACH), (0, JUMP_REACH)):
        other_v, other_u = v + dv, u + du
        is_inside = 0 <= other_v < height and 0 <= other_u < width
        if is_inside and abs(inverse[other_v, other_u] - here) * focal_baseline > JUMP_PX:
            return True
    return False
