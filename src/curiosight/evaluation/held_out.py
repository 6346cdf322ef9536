"""The overall error on frames that are kept out of learning (sec. III-A)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from curiosight.frame import Label, Rgb
from curiosight.learner.learner import Labels, SaliencyLearner, fit_labels

# The authors score a grid of pixels too: their code shrinks maps and labels before comparing.
GRID = 4


class HeldOut:
    """A fixed set of labelled images, described once, scored after every step.

    Votes are kept per tree, so that only the trees that changed are asked again. Superpixels
    are scored with all of their pixels; where every pixel has a row of its own, only each
    `GRID`-th pixel of each `GRID`-th line of the shrunken image is.

    frames: pairs of an (H, W, 3) RGB image and its (H, W) labels: 255 salient, 0 not salient,
        anything else ignored.
    n_frames: those with a salient pixel. Only they have an F1, and count in the overall error,
        as in the authors' code (F1 = 0/0 is skipped); what is marked in the others counts in
        `pooled_error`.
    n_given: all frames.
    """

    def __init__(self, learner: SaliencyLearner, frames: Iterable[tuple[Rgb, Labels]]) -> None:
        rows, salient, other, starts = [], [], [], [0]
        self.n_given = 0
        for rgb, labels in frames:
            self.n_given += 1
            description = learner.describe(rgb)
            counted = fit_labels(labels, description)
            if learner.rows_per == "pixel":
                coarse = np.full_like(counted, Label.UNKNOWN)
                coarse[::GRID, ::GRID] = counted[::GRID, ::GRID]
                counted = coarse
            n_salient, n_other = description.count(counted)
            used = n_salient + n_other > 0
            if not used.any():
                continue
            rows.append(description.rows[used])
            salient.append(n_salient[used])
            other.append(n_other[used])
            starts.append(starts[-1] + int(used.sum()))
        self.n_frames = sum(bool(counts.any()) for counts in salient)
        self._starts = np.array(starts[:-1], np.int64)
        self._rows = np.concatenate(rows) if rows else np.empty((0, 0), np.uint8)
        self._salient = np.concatenate(salient) if rows else np.empty(0, np.int64)
        self._other = np.concatenate(other) if rows else np.empty(0, np.int64)
        self._forest = learner.forest
        self._threshold = learner.threshold
        self._votes: npt.NDArray[np.float32] | None = None

    def overall_error(self, regrown: Sequence[int] | None = None) -> float | None:
        """Return the mean over the frames of 1 - F1 (eq. 1); None without any frame.

        regrown: the trees that changed since the last call; None = all of them.
        """
        if self.n_frames == 0:
            return None
        if self._votes is None or regrown is None:
            self._votes = self._forest.votes(self._rows)
        elif regrown:
            self._votes[:, list(regrown)] = self._forest.votes(self._rows, regrown)
        hits, marked_or_salient = self._count(self._votes)
        salient = np.add.reduceat(self._salient, self._starts)
        scored = salient > 0
        return float(np.mean(1 - 2 * hits[scored] / marked_or_salient[scored]))

    def pooled_error(self) -> float | None:
        """Return 1 - F1 of all frames' pixels together, at the last call of `overall_error`.

        Here false alarms in frames without anything salient count too. None as there, and before.
        """
        if self.n_frames == 0 or self._votes is None:
            return None
        hits, marked_or_salient = self._count(self._votes)
        return float(1 - 2 * hits.sum() / marked_or_salient.sum())

    def _count(
        self, votes: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Return each frame's pixels rightly predicted salient, and predicted plus truly so."""
        predicted = votes.mean(axis=1) > self._threshold
        hits = np.add.reduceat(self._salient * predicted, self._starts)
        false_alarms = np.add.reduceat(self._other * predicted, self._starts)
        salient = np.add.reduceat(self._salient, self._starts)
        return hits, hits + false_alarms + salient
