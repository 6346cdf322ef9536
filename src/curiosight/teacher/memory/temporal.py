"""A teacher that remembers: what several views agree on corrects what one view says."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label
from curiosight.teacher.cloud.points import scale_of, spread
from curiosight.teacher.cloud.tracking import UpTracker
from curiosight.teacher.memory.votes import REJECTED, ViewVote, VoxelVotes
from curiosight.teacher.resizing import in_full_size, in_own_size
from curiosight.teacher.segmented import CODE_OF, UNDER_TABLE, Segmentation
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.teacher import Teacher
from curiosight.teacher.things.verdicts import Verdict

Array = npt.NDArray[Any]

# Of the grid that is looked at and votes, in a 640x480 image: what is remembered may take longer
# and be finer.
STRIDE = 2
# What only this view does not know; every other verdict is a vote against.
ABSTAINS = frozenset({Verdict.CUT, Verdict.FAR, Verdict.SMALL, Verdict.FLAT})
# Of an unknown cluster: from this share on what is surely not salient counts; one more of which
# this share may be salient is left in doubt.
MIN_SETTLED, MAX_SALIENT = 0.5, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Remembered:
    """All that a frame changed of a memory, for `TemporalTeacher.remember_again`.

    gone: (n,) voxels that it saw through. told: what it told of others.
    """

    gone: Array
    told: ViewVote


class TemporalTeacher:
    """A teacher with a memory of the place, where poses tell what is where.

    Every frame votes with what it shows by itself. Then a thing that the image cuts, or that
    stands too close to another, is salient where it was seen whole before; and what most views
    take for table or wall is not salient in one of them. What has gone is forgotten.

    teacher: whose survey and thresholds it takes over, on a finer grid.
    min_ahead: votes by which salient must lead. Twice as many against take it back, unless more
        views than not see something salient here or beside: poses drift by more than a mug is
        thick.
    is_remembering: set it to False once it has seen all there is to see: it then labels frames
        by what it knows, and they do not vote again. What a view does not know is then not
        salient where others know it.
    is_noting: set it to True to have `noted` say what the last frame changed of the memory; None
        = nothing.
    """

    def __init__(self, teacher: Teacher, *, min_ahead: int = 2) -> None:
        settings = replace(teacher.settings, stride=STRIDE)
        self.teacher = Teacher(teacher.survey, settings, masks=teacher.masks)
        self.votes = VoxelVotes()
        self.min_ahead = min_ahead
        self.is_remembering = True
        self.is_noting = False
        self.noted: Remembered | UpTracker | None = None
        self._tracker = UpTracker()

    @property
    def survey(self) -> Survey:
        return self.teacher.survey

    @property
    def settings(self) -> SegmentationSettings:
        return self.teacher.settings

    def remember(self, frames: Iterable[Frame]) -> None:
        """Let some frames vote beforehand, such as those of the survey."""
        for frame in frames:
            self.segment(frame)

    def memory(self) -> tuple[VoxelVotes, UpTracker]:
        """Return all that frames change, as it is, not copied: for `recall`."""
        return self.votes, self._tracker

    def recall(self, memory: tuple[VoxelVotes, UpTracker]) -> None:
        """Go on from the `memory` of a teacher with the same survey and settings."""
        self.votes, self._tracker = memory

    def remember_again(self, noted: Remembered | UpTracker) -> None:
        """Remember what another teacher with the same memory has `noted`."""
        if isinstance(noted, UpTracker):
            self._tracker = copy(noted)
            return
        self.votes.forget(noted.gone)
        self.votes.add_again(noted.told)

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel of a frame by itself, correct it by memory, and remember it.

        A frame without pose is not corrected: only which way is up is carried to the next.
        """
        self.noted = None
        repeats = self.teacher.repeats_in(frame)
        # Masks are as large as the image.
        if repeats is not None and self.teacher.masks is None:
            return in_full_size(self.segment(in_own_size(frame, repeats)), repeats)
        pose = frame.T_world_camera
        if pose is None:
            return self._tracked(frame)
        alone = self.teacher.segment(frame)
        if frame.depth is None or frame.camera is None or alone.problem:
            return alone
        stride = self.settings.stride_at(scale_of(frame.camera))
        voxels = self.votes.voxels_of(frame.depth, frame.camera, pose, stride=stride)
        if self.is_remembering:
            gone = self.votes.forget_removed(frame.depth, frame.camera, pose)
        corrected = self._corrected(alone, stride, voxels)
        if self.is_remembering:
            ballots = _ballots(alone, stride)
            if self.is_noting:
                self.noted = Remembered(gone, self.votes.add_and_note(voxels, ballots))
            else:
                self.votes.add(voxels, ballots)
        full, _, _ = spread(
            corrected.astype(np.int32),
            np.ascontiguousarray(frame.depth[::stride, ::stride]),
            frame.depth,
            stride,
            max_depth=self.settings.max_range,
            beyond=Label.UNAVAILABLE,
            is_one=True,
        )
        if self.teacher.masks is not None:
            # Where depth has holes, masks may have told more than memory can.
            full = np.where(np.isnan(frame.depth), alone.labels, full)
        return replace(alone, labels=full)

    def confidence(self, frame: Frame, segmentation: Segmentation) -> npt.NDArray[np.float32]:
        """(H, W) in [0, 1]: as sure as the frame by itself makes it, see `Teacher.confidence`."""
        return self.teacher.confidence(frame, segmentation)

    def _tracked(self, frame: Frame) -> Segmentation:
        if frame.depth is None or frame.problem is not None:
            return self.teacher.segment(frame)
        tracked = self.teacher.segment(frame, up=self._tracker.up_in(frame.depth))
        self._tracker.update(frame.depth, [s.plane for s in tracked.supports])
        if self.is_noting:
            self.noted = copy(self._tracker)
        return tracked

    def _corrected(self, alone: Segmentation, stride: int, voxels: Array) -> npt.NDArray[np.uint8]:
        """(h, w): the labels of a frame as the votes of earlier views make them."""
        corrected: npt.NDArray[np.uint8] = alone.labels[::stride, ::stride].copy()
        where = np.flatnonzero((corrected == Label.UNKNOWN) | (corrected == Label.SALIENT))
        here, around, settled = self.votes.balance(voxels.take(where)).T
        is_unknown = corrected.take(where) == Label.UNKNOWN
        may_be_object = _may_be_object(alone, stride).take(where)
        is_told = is_unknown & (around >= self.min_ahead) & may_be_object
        denied = ~is_unknown & (here <= -2 * self.min_ahead) & (around <= 0)
        corrected.ravel()[where[is_told]] = Label.SALIENT
        corrected.ravel()[where[denied]] = Label.UNKNOWN
        # As long as more is to come, what no view has recognised may still be a thing.
        if not self.is_remembering:
            is_other = is_unknown & (settled <= -self.min_ahead)
            cluster = alone.cluster_of_pixel[::stride, ::stride].take(where)
            is_other &= _of_most(cluster, is_other, is_told)
            corrected.ravel()[where[is_other]] = Label.NOT_SALIENT
        return corrected


def _of_most(cluster: Array, is_other: Array, is_salient: Array) -> npt.NDArray[np.bool_]:
    """(n,) whether a pixel's cluster is mostly `is_other`, and hardly salient; true in none.

    The foot of a mug lies in voxels of the table: a thing is judged as a whole.
    """
    n_clusters = int(cluster.max(initial=0)) + 1
    n_pixels = np.bincount(cluster, minlength=n_clusters)
    n_other = np.bincount(cluster[is_other], minlength=n_clusters)
    n_salient = np.bincount(cluster[is_salient], minlength=n_clusters)
    is_most = (n_other >= MIN_SETTLED * n_pixels) & (n_salient <= MAX_SALIENT * n_pixels)
    is_most[0] = True
    return np.asarray(is_most[cluster])


def _may_be_object(alone: Segmentation, stride: int) -> Array:
    """(h, w) bool: all but what lies under a table: its legs and apron are close to objects."""
    assert alone.found is not None
    is_under = alone.found[::stride, ::stride] == CODE_OF[UNDER_TABLE]
    in_cluster = alone.cluster_of_pixel[::stride, ::stride] > 0
    return np.asarray(in_cluster | ~is_under)


def _ballots(alone: Segmentation, stride: int) -> npt.NDArray[np.uint8]:
    """(h, w): what a frame says by itself, codes of `Label`, or `REJECTED`: a doubtful no."""
    is_rejected = np.array(
        [False]
        + [c.verdict not in ABSTAINS and c.verdict is not Verdict.OBJECT for c in alone.clusters]
    )
    ballots: npt.NDArray[np.uint8] = alone.labels[::stride, ::stride].copy()
    ballots[is_rejected.take(alone.cluster_of_pixel[::stride, ::stride])] = REJECTED
    return ballots
