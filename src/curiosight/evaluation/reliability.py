"""How far probabilities can be taken at their word."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Label

N_BINS = 15


class Reliability:
    """Collect maps of probability with their truth: of what got 0.3, are three in ten salient?

    Bins are equally wide; pixels of all frames are taken together.
    """

    def __init__(self, n_bins: int = N_BINS) -> None:
        # Pixels, those that are salient, and the sum of the probabilities, of each bin.
        self._sums = np.zeros((3, n_bins))

    def add(self, probability: npt.NDArray[np.float32], truth: npt.NDArray[np.uint8]) -> None:
        """Add a frame's (H, W) map in [0, 1] and truth: 255 salient, 0 not, else ignored."""
        if truth.shape != probability.shape:
            raise ValueError(f"truth: expected {probability.shape}, got {truth.shape}")
        is_known = (truth == Label.SALIENT) | (truth == Label.NOT_SALIENT)
        told, is_salient = probability[is_known].astype(float), truth[is_known] == Label.SALIENT
        n_bins = self._sums.shape[1]
        bins = np.clip((told * n_bins).astype(np.int64), 0, n_bins - 1)
        for row, weights in zip(self._sums, (None, is_salient, told), strict=True):
            row += np.bincount(bins, weights, n_bins)

    @property
    def expected_error(self) -> float | None:
        """The expected calibration error (Guo et al. 2017); None without a known pixel.

        How far the share of salient pixels in a bin is from what they were told, on average over
        pixels.
        """
        n_pixels, n_salient, told = self._sums
        if not n_pixels.any():
            return None
        return float(np.abs(n_salient - told).sum() / n_pixels.sum())

    @property
    def curve(self) -> npt.NDArray[np.float64]:
        """(n, 2): mean probability and share of salient pixels, of the bins that have any."""
        n_pixels, n_salient, told = self._sums[:, self._sums[0] > 0]
        curve: npt.NDArray[np.float64] = np.stack([told, n_salient], axis=1) / n_pixels[:, None]
        return curve

    def table(self) -> dict[str, Any]:
        """Return JSON-able figures; mean probability and share are None where a bin is empty."""
        n_pixels, n_salient, told = self._sums
        bins = [
            {
                "n_px": int(n),
                "mean_probability": float(p / n) if n else None,
                "salient_share": float(s / n) if n else None,
            }
            for n, s, p in zip(n_pixels, n_salient, told, strict=True)
        ]
        return {"expected_calibration_error": self.expected_error, "bins": bins}
