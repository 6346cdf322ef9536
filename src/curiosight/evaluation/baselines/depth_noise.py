"""The depth segmentation as a rival of what is learned from it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.evaluation.baselines.maps import Saliency
from curiosight.frame import Label

NOISY = (Label.UNKNOWN, Label.UNAVAILABLE)


def depth_noise(labels: npt.NDArray[np.uint8], rng: np.random.Generator) -> Saliency:
    """Return a teacher's labels as a map, (H, W) in [0, 1], with noise where it has none.

    Salient is 1 and not salient 0. Where the depth does not tell, or is missing, uniform noise
    gives the ROC curve a point for every threshold (sec. III-A).

    labels: (H, W), each a `Label`.
    """
    if labels.ndim != 2 or labels.dtype != np.uint8:
        raise ValueError(f"labels: expected (H, W) uint8, got {labels.shape} {labels.dtype}")
    strange = np.setdiff1d(labels, list(Label))
    if strange.size:
        known = ", ".join(str(label.value) for label in Label)
        raise ValueError(f"labels: expected only {known}, got {strange[0]}")
    # One number a pixel, wherever it is used: the noise of a frame does not hang on its labels.
    noise = rng.random(labels.shape, dtype=np.float32)
    is_salient = (labels == Label.SALIENT).astype(np.float32)
    return np.where(np.isin(labels, NOISY), noise, is_salient)
