"""Saliency of Boolean maps: J. Zhang and S. Sclaroff, "Saliency Detection: A Boolean Map
Approach", ICCV 2013.

What is surrounded, in the image cut at many grey levels of its colour channels, stands out
(sec. 3). Kept of the authors' program, because its maps are what others compare with: red and
blue change places on the way to Lab; each Boolean map is closed first, and so is its inverse,
so that the two of a threshold differ; the image is brought to a width of 600 pixels, be it
smaller or larger.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.boolean_maps import (
    add_maps,
    dilate,
    levels_of,
    maps_between,
    reach_of,
    thresholds_of,
)
from curiosight.evaluation.baselines.border_jumps import BorderJumps, move_seeds, start_jumps
from curiosight.evaluation.baselines.maps import Saliency, check_rgb, in_size_of, stretched, to_grey
from curiosight.evaluation.baselines.matlab_resize import bicubic, bicubic_to_width
from curiosight.evaluation.baselines.reconstruction import open_and_close_by_reconstruction
from curiosight.frame import Rgb

Grey = npt.NDArray[np.uint8]

WORKING_WIDTH = 600
LONGEST_SHAPE = 16
SMOOTHING_WIDTH = 400
DISK_RADIUS = 15
SQUARE = np.ones((3, 3), np.uint8)


def bms(
    rgb: Rgb, *, step: int = 8, has_jumping_border: bool = True, is_smoothed: bool = False
) -> Saliency:
    """Return the map of salient objects, (H, W) in [0, 1].

    step: grey levels from one threshold to the next.
    has_jumping_border: as in the program where it looks for objects (see `border_jumps`).
    is_smoothed: with the post-processing of the authors' script, which flattens objects and
        takes small ones away.

    Raises ValueError for an image that is more than 16 times as high as wide, or the reverse.
    """
    small = _working_image(rgb)
    jumps = start_jumps(*small.shape[:2]) if has_jumping_border else None
    grey = _attention(small, step=step, n_closing=6, jumps=jumps)
    return _smoothed(cv2.resize(grey, rgb.shape[1::-1])) if is_smoothed else in_size_of(rgb, grey)


def bms_fixation(rgb: Rgb, *, step: int = 8) -> Saliency:
    """Return the map of where people look, (H, W) in [0, 1].

    It is blurred, and its greatest value is below 1. `step` and errors as in `bms`.
    """
    small = _working_image(rgb)
    grey = _attention(small, step=step, n_closing=2, n_dilation=3, by_norm=True)
    grey = cv2.dilate(grey, SQUARE, iterations=11)
    return in_size_of(rgb, cv2.GaussianBlur(grey, (51, 51), 20))


def bms_rliac(rgb: Rgb, *, step: int = 8) -> Saliency:
    """Return the map of C. Craye's port of BMS, (H, W) in [0, 1]: the paper's authors' own.

    It works at full size and takes the program's widths for numbers of iterations, so its maps
    are blockier; one random number is thrown away at the start. `step` as in `bms`.
    """
    check_rgb(rgb)
    jumps = start_jumps(*rgb.shape[:2], n_skipped=1)
    return in_size_of(rgb, _attention(rgb, step=step, n_closing=13, n_dilation=1, jumps=jumps))


def _attention(
    rgb: Rgb,
    *,
    step: int,
    n_closing: int,
    n_dilation: int = 0,
    by_norm: bool = False,
    jumps: BorderJumps | None = None,
) -> Grey:
    """Return the sum of all attention maps, stretched to 0 … 255."""
    total = np.zeros(rgb.shape[:2])
    for channel in cv2.split(cv2.cvtColor(rgb, cv2.COLOR_BGR2LAB)):
        thresholds = thresholds_of(channel, step)
        # Closing f > t for every t is closing f; closing the inverse is opening f.
        levels = [
            levels_of(cv2.morphologyEx(channel, way, SQUARE, iterations=n_closing), thresholds)
            for way in (cv2.MORPH_CLOSE, cv2.MORPH_OPEN)
        ]
        surrounded = [maps_between(*reach_of(level, len(thresholds))) for level in levels]
        if jumps is not None:
            for k in range(len(thresholds)):
                for words, level in zip(surrounded, levels, strict=True):
                    move_seeds(words, level, k, jumps)
        for words in surrounded:
            add_maps(total, dilate(words[1:-1, 1:-1], n_dilation), by_norm=by_norm)
    return to_grey(total)


def _working_image(rgb: Rgb) -> Rgb:
    """Bring an image to 600 pixels of width, slightly blurred."""
    check_rgb(rgb)
    height, width = rgb.shape[:2]
    if max(height, width) > LONGEST_SHAPE * min(height, width):
        raise ValueError(f"rgb: expected sides of 16 to 1 or less, got {width}x{height}")
    size = (WORKING_WIDTH, int(WORKING_WIDTH * height / width))
    small = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
    blurred: Rgb = cv2.GaussianBlur(small, (3, 3), 1)
    return blurred


def _smoothed(grey: Grey) -> Saliency:
    """Take away what is smaller than a disk of 15 pixels where the image is 400 wide."""
    resized = bicubic_to_width(grey, SMOOTHING_WIDTH)
    small = np.clip(np.rint(resized), 0, 255).astype(np.uint8)
    v, u = np.mgrid[-DISK_RADIUS : DISK_RADIUS + 1, -DISK_RADIUS : DISK_RADIUS + 1]
    disk = (u**2 + v**2 <= DISK_RADIUS**2).astype(np.uint8)
    flat = open_and_close_by_reconstruction(small, disk, n_neighbours=8)
    smoothed: Saliency = np.clip(bicubic(stretched(flat / 255), grey.shape), 0, 1)
    return smoothed.astype(np.float32)
