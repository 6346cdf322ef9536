"""What the measures of salient objects need of a ground truth, worked out once for all methods."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from curiosight.evaluation.nearest import nearest_marked
from curiosight.frame import Label

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

N_LEVELS = 256
N_QUADRANTS = 4
EPSILON = float(np.spacing(1))  # what the measures' authors add to denominators
HALF_IMPORTANCE_PX = 5.0  # a false alarm weighs 1 beside an object, 1.5 there, 2 far away


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """How the pixels lie to what is salient.

    nearest: (H, W) flat index of the nearest salient pixel, its own for a salient one.
    importance: (H, W) what an error weighs: 1 on what is salient, rising to 2 far away.
    """

    nearest: npt.NDArray[np.int64]
    importance: Floats


class ObjectTruth:
    """A frame's ground truth, prepared for any number of maps to be compared with it.

    labels: (H, W) uint8: 255 salient, 0 not salient, anything else ignored; kept as given.
    is_salient, is_known: (H, W); n_salient, n_known: their pixels.
    """

    def __init__(self, labels: npt.NDArray[np.uint8]) -> None:
        if labels.ndim != 2 or labels.size == 0 or labels.dtype != np.uint8:
            raise ValueError(f"labels: expected (H, W) uint8, got {labels.shape} {labels.dtype}")
        self.labels = labels
        self.is_salient: Bools = labels == Label.SALIENT
        self.is_known: Bools = self.is_salient | (labels == Label.NOT_SALIENT)
        self.n_salient = int(np.count_nonzero(self.is_salient))
        self.n_known = int(np.count_nonzero(self.is_known))

    def count_levels(self, levels: npt.NDArray[np.uint8]) -> Floats:
        """Count the known pixels of (H, W) levels: (quadrant, not salient or salient, level)."""
        n_bins = N_QUADRANTS * 2 * N_LEVELS
        counts = np.bincount((self._first_bins + levels).ravel(), minlength=n_bins)
        known: Floats = counts[:n_bins].astype(np.float64)
        return known.reshape(N_QUADRANTS, 2, N_LEVELS)

    @cached_property
    def surroundings(self) -> Surroundings | None:
        """None where nothing is salient."""
        if self.n_salient == 0:
            return None
        nearest = nearest_marked(self.is_salient)
        rows, columns = np.indices(nearest.shape)
        v, u = np.divmod(nearest, nearest.shape[1])
        distances = np.sqrt((v - rows) ** 2 + (u - columns) ** 2)
        fading = np.exp(np.log(0.5) / HALF_IMPORTANCE_PX * distances)
        return Surroundings(
            nearest=nearest,
            importance=np.where(self.is_salient, 1.0, 2 - fading),
        )

    @cached_property
    def _first_bins(self) -> npt.NDArray[np.int64]:
        """(H, W): the bin of a pixel's quadrant and label at level 0; ignored pixels come last."""
        part = 2 * self._quadrants() + self.is_salient
        part[~self.is_known] = 2 * N_QUADRANTS
        return part * N_LEVELS

    def _quadrants(self) -> npt.NDArray[np.int64]:
        """(H, W): on which sides of the centroid of what is salient a pixel lies, 0 to 3.

        The centroid's own line and column belong to the first sides.
        """
        if self.n_salient == 0:
            return np.zeros(self.is_salient.shape, np.int64)
        v, u = np.argwhere(self.is_salient).mean(axis=0).round()
        height, width = self.is_salient.shape
        is_below, is_right = np.arange(height) > v, np.arange(width) > u
        quadrants: npt.NDArray[np.int64] = 2 * is_below[:, None].astype(np.int64) + is_right
        return quadrants
