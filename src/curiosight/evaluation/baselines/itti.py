"""Itti-Koch saliency: differences between the levels of a pyramid, those that stand alone first.

Itti, Koch and Niebur, "A model of saliency-based visual attention for rapid scene analysis",
PAMI 1998, as simplified in the GBVS toolbox of Harel, Koch and Perona (release of July 2012).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import floor
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.feature_channels import Level, gabor_energy, pyramid
from curiosight.evaluation.baselines.maps import Saliency, check_rgb, stretched
from curiosight.evaluation.baselines.master_map import finished, master_size, small_map
from curiosight.evaluation.baselines.matlab_resize import bicubic
from curiosight.frame import Rgb

Array = npt.NDArray[Any]
Channel = Callable[[Level], list[Array]]

CENTRE_LEVELS = (2, 3)
SURROUND_STEP = 2
ANGLES_DEG = (0, 45, 90, 135)
MASTER_SHARE = 1 / 8
BLUR_SHARE = 0.03
HIGHEST_PEAK = 10.0
LOWEST_PEAK = 1.0


def itti(rgb: Rgb) -> Saliency:
    """Return the Itti-Koch saliency, (H, W) in [0, 1]; a uniform image has none.

    The toolbox's own: two colour contrasts relative to the strongest colour, two centre levels
    with one surround each, squared differences.
    """
    check_rgb(rgb)
    image_size = rgb.shape[:2]
    size = master_size(image_size, floor(max(image_size) * MASTER_SHARE + 0.5))
    levels = pyramid(rgb, max(CENTRE_LEVELS) + SURROUND_STEP)
    master = np.zeros(size)
    for channel in (_colour_contrasts, _intensities, _orientations):
        conspicuity = np.zeros(size)
        for contrast in _contrasts(levels, channel):
            conspicuity += lone_peaks_raised(small_map(contrast, size))
        master += lone_peaks_raised(stretched(conspicuity))
    return finished(master, image_size, BLUR_SHARE)


def lone_peaks_raised(contrast: Array) -> Array:
    """Weight an (h, w) map in [0, 1] by how far its highest peak stands out of the others.

    A peak is an inner pixel that none of its four neighbours exceeds. Returned are multiples of
    ten times the map, itself where it has no peak of at least 1 in 10.
    """
    scaled = contrast * HIGHEST_PEAK
    inner = scaled[1:-1, 1:-1]
    neighbours = (scaled[:-2, 1:-1], scaled[2:, 1:-1], scaled[1:-1, :-2], scaled[1:-1, 2:])
    is_peak = inner >= LOWEST_PEAK
    for neighbour in neighbours:
        is_peak &= inner >= neighbour
    peaks = inner[is_peak]
    if len(peaks) == 0:
        return scaled
    if len(peaks) == 1:
        return scaled * HIGHEST_PEAK**2
    raised: Array = scaled * (HIGHEST_PEAK - peaks.mean()) ** 2
    return raised


def _contrasts(levels: list[Level], channel: Channel) -> Iterator[Array]:
    """Yield the squared differences between centres and surrounds, at the centres' sizes."""
    for index in CENTRE_LEVELS:
        surrounds = channel(levels[index + SURROUND_STEP])
        for centre, surround in zip(channel(levels[index]), surrounds, strict=True):
            yield (centre - bicubic(surround, centre.shape)) ** 2


def _colour_contrasts(level: Level) -> list[Array]:
    """Return blue against yellow and red against green, relative to the intensity."""
    is_lit = level.intensity > 0
    intensity = np.where(is_lit, level.intensity, 1)
    yellow = np.minimum(level.red, level.green)
    differences = (level.blue - yellow, level.red - level.green)
    return [np.where(is_lit, np.abs(difference) / intensity, 0) for difference in differences]


def _intensities(level: Level) -> list[Array]:
    return [level.intensity]


def _orientations(level: Level) -> list[Array]:
    return [gabor_energy(level.intensity, angle) for angle in ANGLES_DEG]
