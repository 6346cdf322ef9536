"""VOCUS2: centre-surround contrast of three colour planes on a pyramid of twin scales.

Frintrop, Werner and Martin Garcia, "Traditional saliency reloaded: a good old model in new
shape", CVPR 2015. The three published parameter files differ in two sigmas only; the one for
cluttered scenes (coffee) is what our paper compares with.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import floor, log2, sqrt
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.maps import Saliency, check_rgb, stretched
from curiosight.frame import Rgb

Plane = npt.NDArray[Any]

LAST_OCTAVE = 4
N_SCALES = 2  # in an octave
WIDE_SIGMA = 4
BLOCK_SIZE = 32
# Of the added contrasts of a uniform image, which the original would stretch to a full map.
ROUNDING = 1e-5


def vocus2_coffee(rgb: Rgb) -> Saliency:
    """Return VOCUS2 for small things in cluttered scenes, (H, W) in [0, 1]."""
    return vocus2(rgb, centre_sigma=2, surround_sigma=6)


def vocus2_kitchen(rgb: Rgb) -> Saliency:
    """Return VOCUS2 for the smallest things, (H, W) in [0, 1]."""
    return vocus2(rgb, centre_sigma=1, surround_sigma=2)


def vocus2_msra(rgb: Rgb) -> Saliency:
    """Return VOCUS2 for one large thing, the original program's default, (H, W) in [0, 1]."""
    return vocus2(rgb, centre_sigma=3, surround_sigma=13)


def vocus2(rgb: Rgb, centre_sigma: float = 2, surround_sigma: float = 6) -> Saliency:
    """Return the saliency of VOCUS2, (H, W) in [0, 1], with sigmas in pixels.

    The original enlarges and averages the on-centre and the off-centre contrast of every plane
    and scale apart, in several means of equal weight. Enlarging is linear, so it is one mean of
    |centre - surround|, of which maps of one size are added before they are enlarged. Like the
    original's, the cubic enlargement may undershoot zero. A uniform image has no saliency.
    """
    check_rgb(rgb)
    if not 0 < centre_sigma < surround_sigma:
        raise ValueError(
            "centre_sigma, surround_sigma: expected 0 < centre_sigma < surround_sigma, "
            f"got {centre_sigma}, {surround_sigma}"
        )
    height, width = rgb.shape[:2]
    contrasts = [
        list(_contrasts(plane, centre_sigma, surround_sigma)) for plane in _opponent_planes(rgb)
    ]
    saliency = np.zeros((height, width), np.float32)
    for intensity, red_green, blue_yellow in zip(*contrasts, strict=True):
        contrast = intensity + red_green + blue_yellow
        saliency += cv2.resize(contrast, (width, height), interpolation=cv2.INTER_CUBIC)
    return stretched(saliency, rounding=ROUNDING)


def _opponent_planes(rgb: Rgb) -> tuple[Plane, Plane, Plane]:
    """Return intensity, red-green and blue-yellow as float32, the last two signed."""
    red, green, blue = cv2.split(rgb.astype(np.float32))
    intensity = (red + green + blue) / 765
    return intensity, (red - green) / 255, (blue - (red + green) / 2) / 255


def _contrasts(plane: Plane, centre_sigma: float, surround_sigma: float) -> Iterator[Plane]:
    """Yield |centre - surround| of each octave, added over its scales."""
    n_octaves = min(floor(log2(min(plane.shape))), LAST_OCTAVE) + 1
    to_surround = sqrt(surround_sigma**2 - centre_sigma**2)
    centre = _blurred(plane, centre_sigma)
    for _ in range(n_octaves):
        contrast = np.zeros_like(centre)
        for scale in range(N_SCALES):
            growth = 2 ** (scale / N_SCALES)
            contrast += cv2.absdiff(centre, _blurred(centre, to_surround * growth))
            # Blurs add up in squares: this one takes the centre on to the next scale's sigma.
            step = sqrt(4 ** (1 / N_SCALES) - 1) * growth * centre_sigma
            centre = _blurred(centre, step)
        yield contrast
        height, width = centre.shape
        centre = np.ascontiguousarray(centre[: height // 2 * 2 : 2, : width // 2 * 2 : 2])


def _blurred(plane: Plane, sigma: float) -> Plane:
    """Blur as `cv2.GaussianBlur` does with a repeated border; widely, by products of matrices.

    They are two to three times faster there than OpenCV.
    """
    if sigma < WIDE_SIGMA:
        narrow: Plane = cv2.GaussianBlur(plane, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
        return narrow
    height, width = plane.shape
    down, wide = np.empty_like(plane), np.empty_like(plane)
    for here, near, weights in _blur_blocks(height, sigma):
        down[here] = weights @ plane[near]
    for here, near, weights in _blur_blocks(width, sigma):
        wide[:, here] = down[:, near] @ weights.T
    return wide


@lru_cache(maxsize=128)
def _blur_blocks(n_pixels: int, sigma: float) -> tuple[tuple[slice, slice, Plane], ...]:
    """Cut the blur of one axis, as a matrix, to blocks of what is not 0 in it.

    A block is the pixels that it yields, those that it reads, and the weights (yielded, read).
    """
    radius = round(8 * sigma + 1) // 2  # OpenCV's, for float32 images
    kernel = cv2.getGaussianKernel(2 * radius + 1, sigma, cv2.CV_32F)[:, 0]
    pixels = np.arange(n_pixels)[:, None]
    matrix = np.zeros((n_pixels, n_pixels), np.float32)
    read = np.clip(pixels + np.arange(-radius, radius + 1), 0, n_pixels - 1)
    np.add.at(matrix, (pixels, read), kernel)
    blocks = []
    for start in range(0, n_pixels, BLOCK_SIZE):
        here = slice(start, start + BLOCK_SIZE)
        near = slice(max(start - radius, 0), start + BLOCK_SIZE + radius)
        blocks.append((here, near, np.ascontiguousarray(matrix[here, near])))
    return tuple(blocks)
