"""R. Achanta, S. Hemami, F. Estrada and S. Süsstrunk, "Frequency-tuned Salient Region Detection",
CVPR 2009.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.maps import Saliency, check_rgb, stretched
from curiosight.frame import Rgb

BLUR_SIGMA = 3.0
_GREYS = np.arange(256) / 255
LINEAR_OF_GREY = np.where(
    _GREYS <= 0.04045, _GREYS / 12.92, ((_GREYS + 0.055) / 1.055) ** 2.4
).astype(np.float32)
# XYZ of linear sRGB, each divided by that of the white D65.
WHITE = np.array([0.950456, 1.0, 1.088754])
XYZ_OF_RGB = (
    np.array(
        [
            [0.412453, 0.357580, 0.180423],
            [0.212671, 0.715160, 0.072169],
            [0.019334, 0.119193, 0.950227],
        ]
    )
    / WHITE[:, None]
)
LAB_OF_ROOTS = np.array(
    [[0.0, 116.0, 0.0, -16.0], [500.0, -500.0, 0.0, 0.0], [0.0, 200.0, -200.0, 0.0]]
)
ROOTS_FROM = 0.008856
# Squared distances that are none but for rounding; a grey level's is 0.01 or more.
SAME_COLOUR = 1e-6


def frequency_tuned(rgb: Rgb) -> Saliency:
    """Return how far each colour is from the mean colour, (H, W) in [0, 1] (eq. 4).

    Blurred by 3x3 pixels, in CIELab, and squared, as in the authors' MATLAB demonstration; its
    mean is that of the blurred image.
    """
    check_rgb(rgb)
    colours = rgb.astype(np.float64)
    blurred = cv2.GaussianBlur(colours, (3, 3), BLUR_SIGMA, borderType=cv2.BORDER_REFLECT)
    lab = cielab(np.rint(blurred).astype(np.uint8))
    from_mean = cv2.subtract(lab, cv2.mean(lab))
    distance: Saliency = cv2.transform(from_mean**2, np.ones((1, 3)))
    return stretched(distance) if distance.max() > SAME_COLOUR else np.zeros_like(distance)


def cielab(rgb: Rgb) -> npt.NDArray[np.float32]:
    """Return (H, W, 3) float32 CIELab of 8-bit sRGB: L to 100.

    OpenCV's own is an approximation that can be seen in the map.
    """
    xyz = cv2.transform(cv2.LUT(rgb, LINEAR_OF_GREY), XYZ_OF_RGB)
    is_bright = xyz > ROOTS_FROM
    roots = np.where(is_bright, cv2.pow(xyz, 1 / 3), 7.787 * xyz + np.float32(16 / 116))
    lab: npt.NDArray[np.float32] = cv2.transform(roots, LAB_OF_ROOTS)
    return lab
