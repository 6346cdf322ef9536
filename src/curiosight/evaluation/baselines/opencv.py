"""The bottom-up methods that OpenCV brings."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from curiosight.evaluation.baselines.maps import Saliency, check_rgb
from curiosight.frame import Rgb


def fine_grained(rgb: Rgb) -> Saliency:
    """Return the fine-grained saliency of Montabone and Soto (2010), (H, W) in [0, 1]."""
    return _compute(cv2.saliency.StaticSaliencyFineGrained.create(), rgb)


def spectral_residual(rgb: Rgb) -> Saliency:
    """Return OpenCV's variant of the spectral residual, (H, W) in [0, 1].

    The map of Hou and Zhang's own demonstration is `spectral_residual` of this package.
    """
    return _compute(cv2.saliency.StaticSaliencySpectralResidual.create(), rgb)


def _compute(method: Any, rgb: Rgb) -> Saliency:
    check_rgb(rgb)
    is_done, saliency = method.computeSaliency(cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))
    if not is_done:
        raise ValueError(f"rgb: expected an image that OpenCV can work on, got {rgb.shape}")
    clipped: Saliency = np.clip(saliency, 0, 1).astype(np.float32)
    return clipped
