"""The colours that things and walls share, so that no colour tells an object by itself."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Colour = npt.NDArray[np.uint8]

VIVID = (
    (178, 34, 40),
    (206, 92, 28),
    (226, 178, 52),
    (84, 138, 62),
    (34, 102, 92),
    (38, 84, 150),
    (92, 66, 132),
    (196, 92, 128),
    (70, 150, 190),
)
MUTED = (
    (226, 218, 202),
    (200, 188, 168),
    (160, 144, 124),
    (122, 92, 66),
    (150, 110, 70),
    (92, 96, 98),
    (52, 52, 56),
    (182, 186, 186),
    (142, 154, 140),
    (120, 136, 150),
    (236, 234, 228),
)


def draw_colour(rng: np.random.Generator, *, vivid: float = 0.5, spread: float = 12.0) -> Colour:
    """Return an (3,) sRGB colour near one of the palette's.

    vivid: chance that it is one of the strong ones. spread: standard deviation of each channel.
    """
    colours = VIVID if rng.random() < vivid else MUTED
    colour = np.asarray(colours[rng.integers(len(colours))]) + rng.normal(0, spread, 3)
    return np.clip(np.rint(colour), 8, 247).astype(np.uint8)
