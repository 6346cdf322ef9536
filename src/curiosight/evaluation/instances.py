"""How well an image's objects are told apart, by the measures of Xie et al.

C. Xie, Y. Xiang, A. Mousavian, D. Fox, "Unseen Object Instance Segmentation for Robotic
Environments", IEEE Transactions on Robotics 2021, with the details of their published program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame.assignment import best_pairs

Mask = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.integer]
IGNORED = -1
AROUND = 2  # neither 0 nor 1, which a mask has
CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


@dataclass(frozen=True, slots=True)
class Agreement:
    """Precision and recall of pixels, in [0, 1]."""

    precision: float
    recall: float

    @property
    def f(self) -> float:
        """Their harmonic mean; 0 where both are 0."""
        total = self.precision + self.recall
        return 2 * self.precision * self.recall / total if total else 0.0


@dataclass(frozen=True, slots=True)
class InstanceScore:
    """How well the objects of one image are found, each true one by at most one predicted.

    overlap: of the objects' pixels. boundary: of the pixels of their outlines.
    n_detected: true objects whose match has an F of 0.75 or more.
    """

    overlap: Agreement
    boundary: Agreement
    n_true: int
    n_predicted: int
    n_detected: int

    @property
    def detected(self) -> float:
        """Share of the true objects that are detected; without any, 1 if none was predicted."""
        return self.n_detected / self.n_true if self.n_true else float(self.n_predicted == 0)


def score_instances(
    predicted: Numbers, truth: Numbers, *, tolerance: float = 0.003, min_f: float = 0.75
) -> InstanceScore:
    """Match predicted objects with the true ones of an image, and compare them.

    Matches maximise the sum of F over all pairs (Hungarian method). Pixels count in all objects,
    matched or not; the background does not count.

    predicted, truth: (H, W) a number an object, 0 = none; in `truth` -1 = ignored, where
        predicted objects lose their pixels.
    tolerance: of an outline's place, as a share of the image's diagonal, rounded up to pixels.
    min_f: of an object that is detected.
    """
    if predicted.shape != truth.shape:
        raise ValueError(f"predicted: expected {truth.shape} like the truth, got {predicted.shape}")
    predicted = np.where(truth == IGNORED, 0, predicted)
    truth = np.where(truth == IGNORED, 0, truth)
    of_prediction, of_truth = _objects(predicted), _objects(truth)
    n_true, n_predicted = len(of_truth), len(of_prediction)
    if not n_true or not n_predicted:
        # Nothing predicted is nothing wrong, and nothing there is nothing missed.
        nothing = Agreement(float(n_predicted == 0), float(n_true == 0))
        return InstanceScore(nothing, nothing, n_true, n_predicted, 0)
    shared = np.array([[np.count_nonzero(t & p) for p in of_prediction] for t in of_truth])
    sizes = [np.array([np.count_nonzero(mask) for mask in m]) for m in (of_truth, of_prediction)]
    f = 2 * shared / (sizes[0][:, None] + sizes[1])
    matches = [(t, p) for t, p in zip(*best_pairs(f), strict=True) if shared[t, p]]
    n_shared = sum(int(shared[match]) for match in matches)
    return InstanceScore(
        Agreement(n_shared / int(sizes[1].sum()), n_shared / int(sizes[0].sum())),
        _compare_outlines(of_prediction, of_truth, matches, tolerance),
        n_true,
        n_predicted,
        sum(bool(f[match] >= min_f) for match in matches),
    )


def instance_table(scores: Sequence[InstanceScore]) -> dict[str, float] | None:
    """Return the means over images, as the authors report them, and numbers of objects.

    Means are in [0, 1]. None without any image.
    """
    if not scores:
        return None
    columns = {
        "overlap_precision": [score.overlap.precision for score in scores],
        "overlap_recall": [score.overlap.recall for score in scores],
        "overlap_f": [score.overlap.f for score in scores],
        "boundary_precision": [score.boundary.precision for score in scores],
        "boundary_recall": [score.boundary.recall for score in scores],
        "boundary_f": [score.boundary.f for score in scores],
        "detected": [score.detected for score in scores],
    }
    return {
        **{name: float(np.mean(values)) for name, values in columns.items()},
        "n_true": sum(score.n_true for score in scores),
        "n_predicted": sum(score.n_predicted for score in scores),
        "n_detected": sum(score.n_detected for score in scores),
    }


def _objects(numbers: Numbers) -> list[Mask]:
    return [numbers == number for number in np.unique(numbers) if number > 0]


def _compare_outlines(
    predicted: list[Mask], truth: list[Mask], matches: list[tuple[int, int]], tolerance: float
) -> Agreement:
    """Return the shares of outline pixels that lie near the outline of the match."""
    radius = int(np.ceil(tolerance * np.hypot(*truth[0].shape)))
    of_prediction, of_truth = ([outline(mask) for mask in masks] for masks in (predicted, truth))
    n_right = n_found = 0
    for t, p in matches:
        n_right += int(np.count_nonzero(of_prediction[p] & _widened(of_truth[t], radius)))
        n_found += int(np.count_nonzero(of_truth[t] & _widened(of_prediction[p], radius)))
    n_predicted, n_true = (int(np.sum(lines)) for lines in (of_prediction, of_truth))
    return Agreement(n_right / n_predicted, n_found / n_true)


def outline(mask: Mask) -> Mask:
    """(H, W) bool: pixels of a mask beside what lies around it; holes have no outline.

    Beyond the image's edge is around it, too.
    """
    around = np.pad(mask, 1).astype(np.uint8)
    cv2.floodFill(around, None, (0, 0), AROUND, flags=4)
    beside = cv2.dilate((around == AROUND).astype(np.uint8), CROSS)[1:-1, 1:-1]
    line: Mask = mask & (beside > 0)
    return line


def _widened(line: Mask, radius: int) -> Mask:
    """Add what lies within `radius` pixels."""
    v, u = np.ogrid[-radius : radius + 1, -radius : radius + 1]
    disc = (u * u + v * v <= radius * radius).astype(np.uint8)
    widened: Mask = cv2.dilate(line.astype(np.uint8), disc) > 0
    return widened
