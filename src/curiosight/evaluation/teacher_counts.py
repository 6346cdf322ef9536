"""How right and how complete the teacher's labels are, against ground truth (sec. II-A.2)."""

from __future__ import annotations

from collections import Counter
from dataclasses import astuple, dataclass

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Label
from curiosight.teacher import REASONS, Segmentation
from curiosight.teacher.segmented import TOLD_NOTHING

Labels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

# Why a pixel of an object is not labelled salient, where it is not unknown either.
NOT_SALIENT = "taken for a support or a wall"


@dataclass(frozen=True, slots=True)
class TeacherCounts:
    """Pixels counted against ground truth; add them up over frames.

    salient: labelled so by the teacher, where truth is known. whole: of true objects that the
    image does not cut. object: of all true objects. true: where truth is known. taught:
    labelled salient or not salient there.
    """

    n_salient: int = 0
    n_salient_right: int = 0
    n_whole: int = 0
    n_whole_found: int = 0
    n_object: int = 0
    n_object_found: int = 0
    n_true: int = 0
    n_taught: int = 0

    def __add__(self, other: TeacherCounts) -> TeacherCounts:
        pairs = zip(astuple(self), astuple(other), strict=True)
        return TeacherCounts(*(mine + theirs for mine, theirs in pairs))

    @property
    def precision(self) -> float:
        """Share of the pixels labelled salient that are; NaN when none is, or none is labelled so.

        Where truth marks no object at all, it is not known to look for objects.
        """
        return _ratio(self.n_salient_right, self.n_salient if self.n_object else 0)

    @property
    def recall(self) -> float:
        """Share of the pixels of uncut true objects that are labelled salient; NaN if none."""
        return _ratio(self.n_whole_found, self.n_whole)

    @property
    def recall_of_all(self) -> float:
        """Share of the pixels of all true objects that are labelled salient; NaN if none."""
        return _ratio(self.n_object_found, self.n_object)

    @property
    def coverage(self) -> float:
        """Share of the pixels with a truth that are labelled salient or not salient; NaN if none.

        What an object or its surroundings are taken for makes no difference here.
        """
        return _ratio(self.n_taught, self.n_true)

    def shares(self) -> dict[str, float | None]:
        """Return all shares by name, None for NaN."""
        shares = {
            "precision": self.precision,
            "recall": self.recall,
            "recall_of_all": self.recall_of_all,
            "coverage": self.coverage,
        }
        return {name: None if np.isnan(share) else share for name, share in shares.items()}

    @property
    def n_wrong(self) -> int:
        """Count the pixels missed in uncut objects, and those labelled salient wrongly."""
        return self.n_whole - self.n_whole_found + self.n_salient - self.n_salient_right


def teacher_counts(
    labels: Labels, ground_truth: Labels, *, is_whole: Mask | None = None
) -> TeacherCounts:
    """Compare a teacher's labels with ground truth (255, 0, else ignored) of the same size.

    is_whole: (H, W) the pixels that recall looks at; None = those of `whole_objects`.
    """
    is_object = ground_truth == Label.SALIENT
    is_true = is_object | (ground_truth == Label.NOT_SALIENT)
    if is_whole is None:
        is_whole = whole_objects(ground_truth)
    is_salient = labels == Label.SALIENT
    is_taught = is_salient | (labels == Label.NOT_SALIENT)
    masks = (
        is_salient & is_true,
        is_salient & is_object,
        is_whole,
        is_salient & is_whole,
        is_object,
        is_salient & is_object,
        is_true,
        is_taught & is_true,
    )
    return TeacherCounts(*(int(np.count_nonzero(mask)) for mask in masks))


def whole_objects(ground_truth: Labels, *, border_px: int = 10) -> Mask:
    """(H, W) bool: true objects that keep out of the image's frame of `border_px`.

    An object is a connected component here. What touches the frame is unknown to the teacher
    on purpose (sec. II-A.2).
    """
    if border_px < 0:
        raise ValueError(f"border_px: expected 0 or more, got {border_px}")
    is_object = ground_truth == Label.SALIENT
    _, component = cv2.connectedComponents(is_object.astype(np.uint8), connectivity=8)
    is_frame = np.ones(ground_truth.shape, np.bool_)
    height, width = ground_truth.shape
    is_frame[border_px : height - border_px, border_px : width - border_px] = False
    is_cut = np.zeros(component.max() + 1, np.bool_)
    is_cut[component[is_frame]] = True
    whole: Mask = is_object & ~is_cut[component]
    return whole


def missed_by_reason(segmentation: Segmentation, missed: Mask) -> Counter[str]:
    """Count missed pixels by what the teacher took them for.

    missed: (H, W) pixels of true objects that are not labelled salient.
    """
    labels, why = segmentation.labels[missed], segmentation.reasons()[missed]
    n_for_reason = np.bincount(why[labels != Label.NOT_SALIENT], minlength=len(REASONS))
    reasons = Counter(dict(zip(REASONS.values(), n_for_reason.tolist(), strict=True)))
    reasons[NOT_SALIENT] = int(np.count_nonzero(labels == Label.NOT_SALIENT))
    if segmentation.problem is not None:
        reasons[segmentation.problem] = reasons.pop(TOLD_NOTHING)
    return +reasons  # without the zeros


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")
