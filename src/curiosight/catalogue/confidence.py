"""How sure it is that an entry is one thing, whole, and where the catalogue says."""

from __future__ import annotations

import numpy as np

from curiosight.catalogue.things import Thing

# Log-odds, fitted by logistic regression on the drawn home 31: at first; for each e-fold of views
# and of pixels (of 1000 in a 640x480 image); for each metre of length.
FIRST, PER_VIEWS, PER_PIXELS, PER_LENGTH = 1.0, 1.2, 0.6, -3.5
# What the map takes from a thing that looks salient to it by less than a half.
PER_SALIENCY = 4.0


def confidence_of(thing: Thing, length: float, n_image_pixels: int) -> float:
    """Return a share in [0, 1]: of such entries, about so many are right.

    length: metres, of its longer side. n_image_pixels: of a whole image.
    """
    _, best = thing.best
    n_pixels = best.n_pixels * 640 * 480 / n_image_pixels
    odds = FIRST + PER_VIEWS * np.log(len(thing.views)) + PER_PIXELS * np.log(n_pixels / 1000)
    odds += PER_LENGTH * length
    if np.isfinite(thing.saliency):
        odds += PER_SALIENCY * (min(thing.saliency, 0.5) - 0.5)
    return float(1 / (1 + np.exp(-odds)))
