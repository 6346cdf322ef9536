"""Show where the teacher was right, what it missed and what it invented."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation import ScoredFrame
from curiosight.evaluation.instances import outline
from curiosight.frame import Label
from curiosight.viewing.overlays import OUTLINE_COLOUR

Colour = tuple[int, int, int]
Image = npt.NDArray[np.uint8]

# Told apart by lightness as well as by hue; blue and orange differ for every kind of colour vision.
RIGHT: Colour = (0, 200, 140)
MISSED: Colour = (255, 150, 0)
INVENTED: Colour = (200, 0, 120)
CUT: Colour = (90, 150, 255)
LEGEND = {
    "right": RIGHT,
    "missed": MISSED,
    "invented": INVENTED,
    "cut: no loss": CUT,
    "one object": OUTLINE_COLOUR,
}
_OPACITY = 0.55


def overlay_mistakes(scored: ScoredFrame) -> Image:
    """Tint a frame's image by what became of its salient pixels, and outline predicted objects.

    What is not salient and was not taken for it stays grey, ignored pixels are dark. A strip
    below names the colours.
    """
    grey = cv2.cvtColor(scored.frame.rgb, cv2.COLOR_RGB2GRAY)
    picture: Image = cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB)
    picture[scored.truth == Label.UNKNOWN] //= 2
    is_object = scored.truth == Label.SALIENT
    is_right = is_object & (scored.segmentation.labels == Label.SALIENT)
    is_cut = is_object & ~scored.is_whole & ~is_right
    masks = (is_right, scored.is_missed, scored.is_invented, is_cut)
    for mask, colour in zip(masks, (RIGHT, MISSED, INVENTED, CUT), strict=True):
        tinted = (1 - _OPACITY) * picture[mask] + _OPACITY * np.array(colour)
        picture[mask] = np.round(tinted).astype(np.uint8)
    instances = scored.segmentation.instances()
    for number in range(1, instances.max() + 1):
        picture[outline(instances == number)] = OUTLINE_COLOUR
    return np.vstack([picture, _legend(picture.shape[1])])


def _legend(width: int) -> Image:
    """Return a (28, width, 3) strip with a swatch and a name for each colour."""
    strip = np.full((28, width, 3), 255, np.uint8)
    step = width / len(LEGEND)
    for column, (name, colour) in enumerate(LEGEND.items()):
        left = int(column * step) + 8
        strip[6:22, left : left + 16] = colour
        size = min(0.5, step / 320)
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(strip, name, (left + 22, 19), font, size, (0, 0, 0), 1, cv2.LINE_AA)
    return strip
