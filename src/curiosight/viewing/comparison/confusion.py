"""Where a map agrees with the truth and where not, and maps as grey images."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Label, Rgb
from curiosight.viewing.comparison.content import Labels, Saliency
from curiosight.viewing.mistakes import INVENTED, MISSED, RIGHT
from curiosight.viewing.overlays import Colour, blend, greyed
from curiosight.viewing.truth import hatch

Image = npt.NDArray[np.uint8]

OUTCOMES: dict[str, Colour] = {"found": RIGHT, "missed": MISSED, "false alarm": INVENTED}
_OPACITY = 0.7


def confusion(rgb: Rgb, truth: Labels, saliency: Saliency, threshold: float) -> Image:
    """Tint an image by what a map makes of each pixel, (H, W, 3) uint8.

    Found, missed and false alarms have the colours of `OUTCOMES`; what is not salient and was
    not taken for it stays grey; ignored pixels are hatched.

    truth: (H, W) labels: 255 salient, 0 not, else ignored.
    saliency: (h, w) in [0, 1], resized to the image; above `threshold` it is predicted salient.
    """
    if truth.shape != rgb.shape[:2]:
        raise ValueError(f"truth: expected {rgb.shape[:2]} like the image, got {truth.shape}")
    is_predicted = resized(saliency, truth.shape) > threshold
    is_salient, is_not = truth == Label.SALIENT, truth == Label.NOT_SALIENT
    masks = (is_salient & is_predicted, is_salient & ~is_predicted, is_not & is_predicted)
    tint = np.zeros_like(rgb)
    for mask, colour in zip(masks, OUTCOMES.values(), strict=True):
        tint[mask] = colour
    opacity = np.where(np.any(masks, axis=0), np.float32(_OPACITY), np.float32(0))[..., None]
    picture = blend(greyed(rgb), tint, opacity)
    hatch(picture, ~(is_salient | is_not))
    return picture


def map_picture(saliency: Saliency, size: tuple[int, int]) -> Image:
    """Return a map as (H, W, 3) uint8, white is 1; size: H and W."""
    levels = np.round(255 * resized(saliency, size)).astype(np.uint8)
    picture: Image = cv2.cvtColor(levels, cv2.COLOR_GRAY2RGB)
    return picture


def resized(saliency: Saliency, size: tuple[int, ...]) -> npt.NDArray[np.float32]:
    """Return an (h, w) map in [0, 1] as (H, W) float32."""
    if saliency.ndim != 2 or not ((saliency >= 0) & (saliency <= 1)).all():
        raise ValueError(f"saliency: expected (h, w) from 0 to 1, got {saliency.shape}")
    height, width = size
    is_smaller = height * width < saliency.size
    how = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
    scaled = cv2.resize(saliency.astype(np.float32), (width, height), interpolation=how)
    clipped: npt.NDArray[np.float32] = np.clip(scaled, 0, 1)
    return clipped
