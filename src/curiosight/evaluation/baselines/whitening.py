"""Colours in the axes of their own spread."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

# Added to every variance, in grey levels squared, so that a plain image does not blow up.
LEAST_VARIANCE = 50.0


def whitening_of(colours: Array) -> npt.NDArray[np.float64]:
    """Return the (3, 3) matrix that turns (n, 3) colours, times it, into uncorrelated ones.

    The sign of an axis decides where thresholds on it fall, so it is OpenCV's, as in the
    originals.
    """
    flags = cv2.COVAR_NORMAL | cv2.COVAR_ROWS | cv2.COVAR_SCALE
    covariance, _ = cv2.calcCovarMatrix(colours, None, flags, ctype=cv2.CV_64F)
    covariance += LEAST_VARIANCE * np.eye(3)
    variances, axes, _ = cv2.SVDecomp(covariance)
    matrix: npt.NDArray[np.float64] = axes / np.sqrt(variances).ravel()
    return matrix
