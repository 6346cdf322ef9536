"""The overall error on frames that are kept out of learning (sec. III-A)."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label
from curiosight.learner.description import Counts, Labels, fit_labels, sight_of
from curiosight.learner.experts import Change
from curiosight.learner.features import Rows
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.sight import Sight

Votes = npt.NDArray[np.float32]

# The authors score a grid of pixels too: their code shrinks maps and labels before comparing.
GRID = 4


@dataclass(frozen=True, slots=True, eq=False)
class TestView:
    """A labelled image as it is scored.

    rows: (n, F) of its description, those with labels. salient, other: (n,) pixels of each that
    are so labelled. sight: what tells its place; None where places are not told apart.
    """

    __test__ = False  # for pytest, which takes such names for tests

    rows: Rows
    salient: Counts
    other: Counts
    sight: Sight | None


def describe_tests(
    learner: SaliencyLearner, frames: Iterable[tuple[Frame, Labels]]
) -> Iterator[TestView]:
    """Yield frames as they are scored; without rows where nothing is labelled.

    frames: pairs of a frame and its (H, W) labels: 255 salient, 0 not salient, anything else
        ignored. Of a frame its colour and its pose count.

    Superpixels are scored with all of their pixels, as they are: before maps follow edges. Where
    every pixel has a row of its own, only each `GRID`-th pixel of each `GRID`-th line of the
    shrunken image is.
    """
    for frame, labels in frames:
        description = learner.describe(frame.rgb)
        counted = fit_labels(labels, description)
        if learner.describer.rows_per == "pixel":
            coarse = np.full_like(counted, Label.UNKNOWN)
            coarse[::GRID, ::GRID] = counted[::GRID, ::GRID]
            counted = coarse
        salient, other = description.count(counted)
        used = salient + other > 0
        sight = sight_of(description, frame.T_world_camera)
        yield TestView(description.rows[used], salient[used], other[used], sight)


class HeldOut:
    """A fixed set of labelled images, described once, scored after every step.

    Votes are kept per tree, so that only the trees that changed are asked again.

    views: see `describe_tests`.
    n_frames: those with a salient pixel. Only they have an F1, and count in the overall error,
        as in the authors' code (F1 = 0/0 is skipped); what is marked in the others counts in
        `pooled_error`.
    n_given: all frames.
    """

    def __init__(self, learner: SaliencyLearner, views: Iterable[TestView]) -> None:
        self._learner = learner
        given = list(views)
        self.n_given = len(given)
        self._views = [view for view in given if len(view.rows)]
        self.n_frames = sum(bool(view.salient.any()) for view in self._views)
        # The places among all that were given of those that have an F1.
        self.scored = [number for number, view in enumerate(given) if view.salient.any()]
        self._starts = np.cumsum([0, *(len(view.rows) for view in self._views)])[:-1]
        nothing = np.empty(0, np.int64)
        self._salient = np.concatenate([nothing, *(view.salient for view in self._views)])
        self._other = np.concatenate([nothing, *(view.other for view in self._views)])
        # Of each view which forests are asked; of each forest the votes for all who ask it.
        self._asked: list[dict[int, float]] = []
        self._votes: dict[int, Votes] = {}

    def copied(self, learner: SaliencyLearner) -> HeldOut:
        """Return the same tests of a copy of the learner, with the votes that are known."""
        other = copy.copy(self)
        other._learner = learner
        other._votes = {key: votes.copy() for key, votes in self._votes.items()}
        return other

    @property
    def asked(self) -> list[dict[int, float]]:
        """Of each view which forests are asked, and how much each counts; empty before any was."""
        return self._asked

    def ask_as_before(self, asked: list[dict[int, float]]) -> None:
        """Go on as tests that had asked these forests of the same learner."""
        self._asked = asked
        self._ask_chosen()

    def overall_error(self, change: Change | None = None) -> float | None:
        """Return the mean over the frames of 1 - F1 (eq. 1); None without any frame.

        change: what was learned since the last call; None = everything may be another.
        """
        errors = self.errors(change)
        return float(np.mean(errors)) if len(errors) else None

    def errors(self, change: Change | None = None) -> npt.NDArray[np.float64]:
        """Return (n_frames,) of 1 - F1 of those frames that have one; change: as there."""
        if self.n_frames == 0:
            return np.empty(0)
        if change is None or change.is_rearranged or not self._asked:
            self._ask_all()
        else:
            self._ask_again(change.trees)
        hits, marked_or_salient = self._count()
        scored = np.add.reduceat(self._salient, self._starts) > 0
        errors: npt.NDArray[np.float64] = 1 - 2 * hits[scored] / marked_or_salient[scored]
        return errors

    def pooled_error(self) -> float | None:
        """Return 1 - F1 of all frames' pixels together, at the last call of `overall_error`.

        Here false alarms in frames without anything salient count too. None as there, and before.
        """
        if self.n_frames == 0 or not self._asked:
            return None
        hits, marked_or_salient = self._count()
        return float(1 - 2 * hits.sum() / marked_or_salient.sum())

    def _ask_all(self) -> None:
        """Find out which forests know each view, and ask all their trees."""
        self._asked = [self._learner.experts.chosen(view.sight) for view in self._views]
        self._ask_chosen()

    def _ask_chosen(self) -> None:
        """Ask all trees of the forests that know any view."""
        asking = {key for asked in self._asked for key in asked}
        forests = self._learner.experts.forests()
        self._votes = {key: forests[key].votes(self._rows_for(key)) for key in sorted(asking)}

    def _ask_again(self, regrown: Mapping[int, tuple[int, ...]]) -> None:
        """Ask the trees that changed."""
        forests = self._learner.experts.forests()
        for key, trees in regrown.items():
            if key in self._votes and trees:
                self._votes[key][:, list(trees)] = forests[key].votes(self._rows_for(key), trees)

    def _rows_for(self, key: int) -> Rows:
        """Return the rows of the views that ask a forest, one after the other."""
        pairs = zip(self._views, self._asked, strict=True)
        return np.concatenate([view.rows for view, asked in pairs if key in asked])

    def _scores(self) -> npt.NDArray[np.float32]:
        """Return the saliency of all rows of all views."""
        means = {key: votes.mean(axis=1) for key, votes in self._votes.items()}
        used = dict.fromkeys(means, 0)
        parts = []
        for view, asked in zip(self._views, self._asked, strict=True):
            score = np.zeros(len(view.rows), np.float32)
            for key, weight in asked.items():
                start, used[key] = used[key], used[key] + len(score)
                score += np.float32(weight) * means[key][start : used[key]]
            parts.append(score)
        return self._learner.scale(np.concatenate(parts))

    def _count(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Return each frame's pixels rightly predicted salient, and predicted plus truly so."""
        predicted = self._scores() > self._learner.threshold
        hits = np.add.reduceat(self._salient * predicted, self._starts)
        false_alarms = np.add.reduceat(self._other * predicted, self._starts)
        salient = np.add.reduceat(self._salient, self._starts)
        return hits, hits + false_alarms + salient
