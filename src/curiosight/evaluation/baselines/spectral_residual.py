"""X. Hou and L. Zhang, "Saliency Detection: A Spectral Residual Approach", CVPR 2007."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.maps import Saliency, check_rgb, stretched
from curiosight.evaluation.baselines.matlab_resize import bicubic_to_width
from curiosight.frame import Rgb

# MATLAB's: the inverse of its matrix from YIQ, not the rounded 0.299, 0.587, 0.114.
GREY_OF_RGB = np.array([0.298936021293775, 0.587043074451121, 0.114020904255103])
WORKING_WIDTH = 64
BLUR_PIXELS = 10
BLUR_SIGMA = 2.5


def spectral_residual(rgb: Rgb, *, is_small: bool = False) -> Saliency:
    """Return what is unexpected in the image's spectrum, (H, W) in [0, 1].

    is_small: leave the map 64 pixels wide, as the authors' demonstration does.

    An image of one grey level has an empty map.
    """
    check_rgb(rgb)
    grey = np.rint(rgb @ GREY_OF_RGB)
    residual = _residual(bicubic_to_width(grey / 255, WORKING_WIDTH))
    small: Saliency = stretched(_blurred(residual)).astype(np.float32)
    return small if is_small else cv2.resize(small, rgb.shape[1::-1])


def _residual(grey: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the image of the log spectrum minus its local mean, squared."""
    if np.ptp(grey) < np.finfo(np.float32).eps:
        return np.zeros_like(grey)
    spectrum = np.fft.fft2(grey)
    amplitude = np.maximum(np.abs(spectrum), np.finfo(np.float64).tiny)
    logarithm = np.log(amplitude)
    mean = cv2.blur(logarithm, (3, 3), borderType=cv2.BORDER_REPLICATE)
    image = np.fft.ifft2(np.exp(logarithm - mean) * spectrum / amplitude)
    residual: npt.NDArray[np.float64] = np.abs(image) ** 2
    return residual


def _blurred(image: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Blur with a Gaussian of 10 pixels, whose origin is the fifth; beyond the image is 0."""
    place = np.arange(BLUR_PIXELS) - (BLUR_PIXELS - 1) / 2
    kernel = np.exp(-(place**2) / (2 * BLUR_SIGMA**2))
    origin = (BLUR_PIXELS // 2 - 1,) * 2
    blurred: npt.NDArray[np.float64] = cv2.sepFilter2D(
        image, -1, kernel, kernel, anchor=origin, borderType=cv2.BORDER_CONSTANT
    )
    return blurred
