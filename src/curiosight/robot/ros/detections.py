"""Boxes round what a map takes for salient, the surest first."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]
# Of an image's pixels: smaller spots are no things.
MIN_SHARE = 0.0005


@dataclass(frozen=True, slots=True)
class Detection:
    """A box, (x, y, width, height) in pixels, and the mean saliency of the spot inside it."""

    box: tuple[int, int, int, int]
    score: float


def detect(
    saliency: Floats, *, threshold: float = 0.5, min_share: float = MIN_SHARE, top: int = 50
) -> list[Detection]:
    """Return the connected spots of an (H, W) map above a threshold, the most salient first."""
    if not 0 <= threshold <= 1:
        raise ValueError(f"threshold: expected 0 to 1, got {threshold}")
    is_salient = (saliency > threshold).astype(np.uint8)
    n, labels, stats, _ = cv2.connectedComponentsWithStats(is_salient, connectivity=8)
    if n < 2:
        return []
    sums = np.bincount(labels.ravel(), saliency.ravel(), minlength=n)
    areas = stats[:, cv2.CC_STAT_AREA]
    spots = [number for number in range(1, n) if areas[number] >= min_share * saliency.size]
    found = [
        Detection(
            (int(stats[one, 0]), int(stats[one, 1]), int(stats[one, 2]), int(stats[one, 3])),
            float(min(1.0, sums[one] / areas[one])),
        )
        for one in spots
    ]
    return sorted(found, key=lambda one: one.score, reverse=True)[:top]
