"""The weighted F-measure (Margolin et al., "How to evaluate foreground maps?", CVPR 2014)."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation.object_truth import EPSILON, ObjectTruth

Floats = npt.NDArray[np.float64]

# How far the errors inside an object make up for each other (sec. 4 of the paper).
KERNEL_SIZE, KERNEL_SIGMA = 7, 5.0


def weighted_f(values: Floats, truth: ObjectTruth) -> float | None:
    """Return the weighted F1 of an (H, W) map in [0, 1]; None where nothing is salient.

    An ignored pixel is no false alarm. To the salient pixels beside it, it is what any pixel
    outside the objects is: as wrong as the nearest salient one. So its own value counts nowhere.
    """
    if truth.surroundings is None:
        return None
    error = np.abs(values - truth.is_salient)
    spread = error.ravel()[truth.surroundings.nearest]
    kernel = cv2.getGaussianKernel(KERNEL_SIZE, KERNEL_SIGMA, cv2.CV_64F)
    averaged = cv2.sepFilter2D(spread, cv2.CV_64F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
    missed = np.minimum(error, averaged)[truth.is_salient]
    is_negative = truth.is_known & ~truth.is_salient
    false_alarms = float((error * truth.surroundings.importance)[is_negative].sum())
    hits = truth.n_salient - float(missed.sum())
    recall = 1 - float(missed.mean())
    precision = hits / (hits + false_alarms + EPSILON)
    return 2 * recall * precision / (recall + precision + EPSILON)
