"""Lay what the teacher said, or what was predicted, over the colour image."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import LABEL_COLOURS, Label, Rgb
from curiosight.teacher import Segmentation

Colour = tuple[int, int, int]
Image = npt.NDArray[np.uint8]

OUTLINE_COLOUR: Colour = (255, 225, 60)
LABEL_NAMES: dict[Label, str] = {
    Label.SALIENT: "salient",
    Label.NOT_SALIENT: "not salient",
    Label.UNKNOWN: "unknown",
    Label.UNAVAILABLE: "no depth, or far",
}
_OPACITY = {
    Label.SALIENT: 0.40,
    Label.NOT_SALIENT: 0.55,
    Label.UNKNOWN: 0.35,
    Label.UNAVAILABLE: 0.80,
}
_HATCH_SPACING_PX = 12


def overlay_labels(rgb: Rgb, segmentation: Segmentation, *, has_legend: bool = False) -> Image:
    """Tint each pixel by its label; outline each object.

    Unknown pixels are hatched, so that they differ from a grey wall. has_legend: add a strip
    below that names the colours; else the result has the size of `rgb`.
    """
    labels = segmentation.labels
    _check_same_size("segmentation", labels.shape, rgb)
    # What teaches no object loses its own colour: a red wall tinted blue would be violet.
    is_coloured = np.isin(labels, (Label.SALIENT, Label.UNKNOWN))[..., None]
    below = np.where(is_coloured, rgb, greyed(rgb))
    tint = np.zeros_like(rgb)
    opacity = np.zeros((*labels.shape, 1), np.float32)
    for label, colour in LABEL_COLOURS.items():
        tint[labels == label] = colour
        opacity[labels == label] = _OPACITY[label]
    blended = blend(below, tint, opacity)
    is_hatched = _hatching(labels.shape) & (labels == Label.UNKNOWN)
    blended[is_hatched] = blended[is_hatched] // 2 + np.uint8(120)
    blended[_outlines(segmentation.instances())] = OUTLINE_COLOUR
    return np.vstack([blended, _legend(rgb.shape[1])]) if has_legend else blended


def overlay_saliency(rgb: Rgb, saliency: npt.NDArray[np.floating]) -> Image:
    """Lay saliency over the grey image, as (H, W, 3) uint8: bright yellow is 1, grey is 0.

    saliency: (h, w) in [0, 1]; a map of a shrunken image is enlarged.
    """
    height, width = rgb.shape[:2]
    enlarged = cv2.resize(saliency.astype(np.float32), (width, height))
    heat = cv2.applyColorMap(np.round(255 * enlarged).astype(np.uint8), cv2.COLORMAP_INFERNO)
    grey = greyed(rgb)
    # Already a doubtful prediction shows, and a sure one still lets the object through.
    opacity = 0.75 * np.sqrt(enlarged)[..., None]
    return blend(grey // 2 + grey // 8, cv2.cvtColor(heat, cv2.COLOR_BGR2RGB), opacity)


def greyed(rgb: Rgb) -> Image:
    """Return the image without its colours, still (H, W, 3)."""
    grey: Image = cv2.cvtColor(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
    return grey


def _check_same_size(name: str, shape: tuple[int, ...], rgb: Rgb) -> None:
    if shape != rgb.shape[:2]:
        raise ValueError(f"{name}: expected {rgb.shape[:2]} like the image, got {shape}")


def blend(below: Image, above: Image, opacity: npt.NDArray[np.float32]) -> Image:
    """Mix two (H, W, 3) images; opacity: (H, W, 1), 1 shows only `above`."""
    mixed = below + opacity * (above.astype(np.float32) - below)
    return np.round(mixed).astype(np.uint8)


def _hatching(shape: tuple[int, ...]) -> npt.NDArray[np.bool_]:
    """(H, W) bool: thin diagonal lines."""
    v, u = np.ogrid[: shape[0], : shape[1]]
    lines: npt.NDArray[np.bool_] = (u + v) % _HATCH_SPACING_PX == 0
    return lines


def _outlines(instances: npt.NDArray[np.uint16]) -> npt.NDArray[np.bool_]:
    """(H, W) bool: the two outermost pixels of each instance."""
    kernel = np.ones((5, 5), np.uint8)
    # Beyond the image counts as the instance itself: its edge there is not its own.
    inner = cv2.erode(instances, kernel, borderType=cv2.BORDER_REPLICATE)
    outer = cv2.dilate(instances, kernel, borderType=cv2.BORDER_REPLICATE)
    outline: npt.NDArray[np.bool_] = (instances > 0) & (inner != outer)
    return outline


def _legend(width: int) -> Image:
    """Return a (28, width, 3) strip with a swatch and a name for each label."""
    strip = np.full((28, width, 3), 255, np.uint8)
    step = width / len(LABEL_COLOURS)
    for column, (label, colour) in enumerate(LABEL_COLOURS.items()):
        left = int(column * step) + 8
        swatch = strip[6:22, left : left + 16]
        swatch[:] = colour
        if label is Label.UNKNOWN:
            swatch[_hatching(swatch.shape)] = 235
        if label is Label.SALIENT:
            cv2.rectangle(strip, (left, 6), (left + 15, 21), OUTLINE_COLOUR, 2)
        size = min(0.5, step / 320)
        position = (left + 22, 19)
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(strip, LABEL_NAMES[label], position, font, size, (0, 0, 0), 1, cv2.LINE_AA)
    return strip
