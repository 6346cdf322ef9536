"""How the toolbox of Harel, Koch and Perona makes one saliency map of many small ones."""

from __future__ import annotations

from math import floor
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.feature_channels import attenuated_border
from curiosight.evaluation.baselines.maps import Saliency, stretched
from curiosight.evaluation.baselines.matlab_resize import bicubic

Array = npt.NDArray[Any]

FADED_BORDER = 4
# Of the feature maps of a uniform image, which the originals would stretch to a full map.
ROUNDING = 1e-12


def master_size(image_size: tuple[int, int], longest_side: int) -> tuple[int, int]:
    """Return the (height, width) that has an image's proportions and this longer side."""
    height, width = (
        max(floor(longest_side * side / max(image_size) + 0.5), 1) for side in image_size
    )
    return height, width


def small_map(feature: Array, size: tuple[int, int]) -> Array:
    """Return a feature at the master map's size, stretched to [0, 1]; 0 where it is uniform."""
    return stretched(bicubic(feature, size), rounding=ROUNDING)


def finished(master: Array, image_size: tuple[int, int], blur_share: float) -> Saliency:
    """Return the (H, W) saliency in [0, 1] of an image from its small master map.

    The border fades, then the map is blurred by `blur_share` of its longer side and enlarged.
    """
    faded = stretched(attenuated_border(master, FADED_BORDER))
    sigma = blur_share * max(master.shape)
    n_taps = 2 * floor(2 * sigma + 0.5) + 1
    kernel = cv2.getGaussianKernel(n_taps, sigma, cv2.CV_64F)
    blurred = cv2.sepFilter2D(faded, -1, kernel, kernel, borderType=cv2.BORDER_REPLICATE)
    enlarged = bicubic(stretched(blurred), image_size)
    return stretched(enlarged).astype(np.float32)
