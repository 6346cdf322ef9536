"""Boolean maps for eye fixations: J. Zhang and S. Sclaroff, "Exploiting Surroundedness for
Saliency Detection: A Boolean Map Approach", PAMI 2016.

Unlike in `bms`, the colours are whitened first, nothing is closed, and a surrounded
region counts apart from the surrounded holes in its inverse. The originals' red and blue change
places here too.
"""

from __future__ import annotations

import cv2
import numpy as np

from curiosight.evaluation.baselines.boolean_maps import (
    add_maps,
    dilate,
    levels_of,
    maps_between,
    reach_of,
    thresholds_of,
)
from curiosight.evaluation.baselines.maps import (
    Saliency,
    check_rgb,
    in_size_of,
    resized_to,
    to_grey,
)
from curiosight.evaluation.baselines.whitening import whitening_of
from curiosight.frame import Rgb

LONGER_SIDE = 400
SQUARE = np.ones((3, 3), np.uint8)


def bms_pami(rgb: Rgb, *, step: int = 8) -> Saliency:
    """Return the map of where people look, (H, W) in [0, 1].

    It is blurred, and its greatest value is below 1. `step`: grey levels from one threshold to
    the next.
    """
    check_rgb(rgb)
    lab = cv2.cvtColor(resized_to(rgb, LONGER_SIDE), cv2.COLOR_BGR2LAB)
    total = np.zeros(lab.shape[:2])
    for channel in _whitened(lab):
        thresholds = thresholds_of(channel, step)
        levels = levels_of(channel, thresholds)
        low, high = reach_of(levels, len(thresholds))
        for words in (maps_between(low, levels), maps_between(levels, high)):
            add_maps(total, dilate(words[1:-1, 1:-1], 3), by_norm=True)
    grey = cv2.dilate(to_grey(total), SQUARE, iterations=4)
    return in_size_of(rgb, cv2.GaussianBlur(grey, (37, 37), 9))


def _whitened(lab: Rgb) -> list[Rgb]:
    """Return the three whitened channels, each stretched to 0 … 255 and freed of specks."""
    colours = lab.reshape(-1, 3).astype(np.float32)
    channels = (colours @ whitening_of(colours)).reshape(lab.shape)
    return [cv2.medianBlur(to_grey(channel), 3) for channel in cv2.split(channels)]
