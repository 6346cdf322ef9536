"""Sets of features: a name, the names of its columns, and how an image's superpixels get them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb
from curiosight.learner.features.colour import Rows
from curiosight.learner.features.superpixel_sums import Sums
from curiosight.learner.features.superpixels import ColourSpace, Superpixels


@dataclass(frozen=True, slots=True)
class FeatureSet:
    """Features of superpixels, one's own too.

    name: by which a model file knows the set again.
    columns: the names of the features; as many as a row has.
    describe: from an (h, w, 3) uint8 image, 320 pixels wide, and the (h, w) int32 superpixel of
        each pixel to (n, len(columns)) uint8, where n is the highest superpixel + 1. A
        superpixel may have no pixel; its row is never read. See `to_bytes`, `mean_of_pixels`.
    colour_space: of the image that `describe` is given.
    digest: of whatever else the features come from, a network's file for instance.
    from_sums: `describe` takes a third argument, `sum_superpixels` of the same image: several sets
        share it.
    """

    name: str
    columns: tuple[str, ...]
    describe: Callable[..., Rows]
    colour_space: ColourSpace = "rgb"
    digest: str = ""
    from_sums: bool = False

    def __post_init__(self) -> None:
        if not self.name or not self.columns:
            raise ValueError(
                f"features: expected a name and columns, got {self.name!r}, {self.columns}"
            )

    def __call__(self, image: Rgb, superpixels: Superpixels, sums: Sums | None = None) -> Rows:
        """Return the rows; raises ValueError where they are not what was declared.

        sums: see `sum_superpixels`; None = they are found here where they are needed.
        """
        if self.from_sums:
            rows = self.describe(image, superpixels, sums)
        else:
            rows = self.describe(image, superpixels)
        expected = (int(superpixels.max()) + 1, len(self.columns))
        if rows.shape != expected or rows.dtype != np.uint8:
            raise ValueError(
                f"features {self.name!r}: expected {expected} uint8, got {rows.shape} {rows.dtype}"
            )
        return rows

    def definition(self) -> dict[str, Any]:
        """Return what a model file says of the set, JSON-able."""
        said: dict[str, Any] = {"name": self.name, "columns": list(self.columns)}
        return said | ({"digest": self.digest} if self.digest else {})


def to_bytes(values: npt.NDArray[np.floating], low: float, high: float) -> Rows:
    """Return numbers as uint8: `low` is 0, `high` is 255, what lies beyond is cut."""
    scaled = (values - low) * (255 / (high - low))
    rows: Rows = np.rint(np.clip(scaled, 0, 255)).astype(np.uint8)
    return rows


def mean_of_pixels(
    maps: Sequence[npt.NDArray[np.floating]] | npt.NDArray[np.floating], superpixels: Superpixels
) -> npt.NDArray[np.float64]:
    """Return the (n, k) mean of each of k (h, w) maps over each superpixel; 0 without a pixel."""
    flat, n_superpixels = superpixels.ravel(), int(superpixels.max()) + 1
    counts = np.maximum(np.bincount(flat, minlength=n_superpixels), 1)
    sums = [np.bincount(flat, np.ravel(one), n_superpixels) for one in maps]
    return np.stack(sums, axis=1) / counts[:, None]
