"""How sure a figure is: intervals from resampled frames (Efron's percentile bootstrap)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_BATCH_SIZE = 4_000_000  # numbers; bounds the memory of resampled means


class Interval(NamedTuple):
    """The ends of a confidence interval."""

    low: float
    high: float


def bootstrap_interval(
    per_frame: npt.NDArray[Any],
    statistic: Callable[[Any], float | None],
    rng: np.random.Generator,
    *,
    n_resamples: int = 1000,
    confidence: float = 0.95,
) -> Interval | None:
    """Return where a figure would lie had other such frames been recorded.

    Whole frames are drawn with replacement, as the pixels of a frame are not independent.
    The same seed draws the same frames for every method, given as many frames.

    per_frame: (n_frames, …) finite numbers; of several methods to compare them in pairs.
    statistic: makes the figure from the mean over the frames drawn, of shape (…): `float`
        itself for a mean, `roc_auc` for one of histograms. None = no meaning there.
    Returns None with fewer than two frames, or where no resample gives a figure.
    """
    per_frame = np.asarray(per_frame, np.float64)
    if per_frame.ndim == 0 or not np.isfinite(per_frame).all():
        raise ValueError("per_frame: expected (n_frames, …) finite numbers")
    if n_resamples < 1:
        raise ValueError(f"n_resamples: expected 1 or more, got {n_resamples}")
    if not 0 < confidence < 1:
        raise ValueError(f"confidence: expected more than 0, less than 1, got {confidence}")
    if len(per_frame) < 2:
        return None
    means = _resampled_means(per_frame, rng, n_resamples)
    figures = [figure for mean in means if (figure := statistic(mean)) is not None]
    if not figures:
        return None
    low, high = np.quantile(figures, [(1 - confidence) / 2, (1 + confidence) / 2])
    return Interval(float(low), float(high))


def _resampled_means(
    per_frame: Floats, rng: np.random.Generator, n_resamples: int
) -> Iterator[Floats]:
    """Yield the mean over as many frames as there are, drawn with replacement."""
    n_frames = len(per_frame)
    times_drawn = rng.multinomial(n_frames, np.full(n_frames, 1 / n_frames), n_resamples)
    frames = per_frame.reshape(n_frames, -1)
    n_batches = min(n_resamples, 1 + n_resamples * frames.shape[1] // _BATCH_SIZE)
    for batch in np.array_split(times_drawn, n_batches):
        # Not `@`: there the last digits depend on the number of threads.
        sums = np.einsum("rf,fk->rk", batch.astype(np.float64), frames)
        yield from sums.reshape(len(batch), *per_frame.shape[1:]) / n_frames
