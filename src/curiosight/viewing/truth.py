"""The truth as a picture, and how pixels whose truth is not known are shown."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.frame import Label
from curiosight.viewing.overlays import Colour

Image = npt.NDArray[np.uint8]
Labels = npt.NDArray[np.uint8]

IGNORED: Colour = (95, 95, 95)
HATCH: Colour = (170, 170, 170)
_N_LINES = 24  # of hatching, beside each other


def truth_picture(truth: Labels) -> Image:
    """Return the truth as (H, W, 3) uint8: white is salient, black is not, ignored is hatched."""
    is_salient = truth == Label.SALIENT
    picture = np.zeros((*truth.shape, 3), np.uint8)
    picture[is_salient] = 255
    hatch(picture, ~is_salient & (truth != Label.NOT_SALIENT))
    return picture


def hatch(picture: Image, mask: npt.NDArray[np.bool_]) -> None:
    """Paint part of a picture as ignored, with lines that show when it is shrunk too."""
    height, width = mask.shape
    spacing = max(4, width // _N_LINES)
    v, u = np.ogrid[:height, :width]
    picture[mask] = IGNORED
    picture[mask & ((u + v) % spacing < spacing // 4)] = HATCH
