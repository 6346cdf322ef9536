"""What the teacher says of one frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label, Pose
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.supports.supports import FLOOR, Support
from curiosight.teacher.supports.tops import Kind
from curiosight.teacher.things.verdicts import Cluster, Verdict

UNSEEN, ALONE = "no reading, or beyond the range", "in no cluster"
DOUBTED = "in an object: enclosed by it, or denied by other views"
UNDER_TABLE, TOLD_NOTHING = "under a table", "the frame tells nothing"
WALL, SALIENT = "wall", "object"
# What a level surface over the floor is called.
FOUND_AS: dict[Kind, str] = {kind: kind.value for kind in Kind if kind is not Kind.THING}
# Codes of `Segmentation.reasons`.
_REJECTED = [verdict.value for verdict in Verdict if verdict is not Verdict.OBJECT]
_FOUND = [FLOOR, *FOUND_AS.values(), WALL, SALIENT, UNDER_TABLE, TOLD_NOTHING]
REASONS = dict(enumerate(["known", UNSEEN, ALONE, DOUBTED, *_REJECTED, *_FOUND]))
# Of these, what is unknown for being one.
TOLD_UNKNOWN = (FOUND_AS[Kind.DOUBTFUL], UNDER_TABLE)
CODE_OF = {reason: code for code, reason in REASONS.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """What the teacher says of one frame.

    labels: (H, W) uint8, the codes of `Label`.
    cluster_of_pixel: (H, W) uint16, 1 + the place in `clusters`; 0 = none.
    supports, walls: in the camera's frame, lowest support first.
    problem: why nothing could be said; None = nothing is wrong.
    n_turns: quarter turns, against the clock, after which the image is upright: supports, walls
        and clusters were found in it then.
    lacks: why masks that were to tell where objects end told nothing of this frame; None = they
        did, or there are none.
    found: (H, W) uint8, codes of `REASONS`: floor, table, furniture, wall, under a table; 0 = none
        of them. None = not told.
    """

    labels: npt.NDArray[np.uint8]
    cluster_of_pixel: npt.NDArray[np.uint16]
    clusters: tuple[Cluster, ...] = ()
    supports: tuple[Support, ...] = ()
    walls: tuple[Wall, ...] = ()
    problem: str | None = None
    n_turns: int = 0
    found: npt.NDArray[np.uint8] | None = None
    lacks: str | None = None

    def up_in_world(self, T_world_camera: Pose | None) -> npt.NDArray[np.float64] | None:
        """Return (3,) which way is up in the world, where a posed frame shows a support."""
        if T_world_camera is None or not self.supports or self.n_turns:
            return None
        up: npt.NDArray[np.float64] = T_world_camera[:3, :3] @ self.supports[0].plane.normal
        return up

    @classmethod
    def of_labels(cls, labels: npt.NDArray[np.uint8], problem: str | None = None) -> Self:
        """Return a segmentation that says nothing but labels: for a detector of one's own."""
        return cls(labels, np.zeros(labels.shape, np.uint16), problem=problem)

    @classmethod
    def of_nothing(cls, frame: Frame, problem: str | None, max_range: float) -> Self:
        """Return that nothing can be said of a frame: within the range, metres, all is unknown."""
        labels = np.full(frame.rgb.shape[:2], Label.UNAVAILABLE, np.uint8)
        if frame.depth is not None:
            labels[frame.depth <= max_range] = Label.UNKNOWN
        return cls.of_labels(labels, problem)

    def with_images(self, change: Callable[[npt.NDArray[Any]], npt.NDArray[Any]]) -> Self:
        """Return it with all of its images changed in one way."""
        return replace(
            self,
            labels=change(self.labels),
            cluster_of_pixel=change(self.cluster_of_pixel),
            found=None if self.found is None else change(self.found),
        )

    @property
    def objects(self) -> tuple[Cluster, ...]:
        """The clusters that passed every test, in the order of their instance numbers."""
        return tuple(c for c in self.clusters if c.verdict is Verdict.OBJECT)

    def reasons(self) -> npt.NDArray[np.uint8]:
        """(H, W) what each pixel is, or why it is unknown or unavailable, codes of `REASONS`.

        0 = known, but not told from what.
        """
        alone = CODE_OF[ALONE if self.problem is None else TOLD_NOTHING]
        verdicts = [c.verdict for c in self.clusters]
        why = [DOUBTED if verdict is Verdict.OBJECT else verdict.value for verdict in verdicts]
        of_cluster = [alone, *(CODE_OF[reason] for reason in why)]
        reasons = np.array(of_cluster, np.uint8)[self.cluster_of_pixel]
        reasons[self.labels == Label.NOT_SALIENT] = 0
        if self.found is not None:
            # What memory corrected is no longer what this frame found.
            is_known = self.labels == Label.NOT_SALIENT
            is_unknown = np.isin(self.found, [CODE_OF[what] for what in TOLD_UNKNOWN])
            is_told = (self.found > 0) & (is_unknown ^ is_known) & (self.cluster_of_pixel == 0)
            reasons[is_told] = self.found[is_told]
        reasons[self.labels == Label.UNAVAILABLE] = CODE_OF[UNSEEN]
        reasons[self.labels == Label.SALIENT] = CODE_OF[SALIENT]
        return reasons

    def instances(self) -> npt.NDArray[np.uint16]:
        """(H, W) number of each pixel's object, from 1; 0 = none."""
        number = np.zeros(len(self.clusters) + 1, np.uint16)
        is_object = np.array([False] + [c.verdict is Verdict.OBJECT for c in self.clusters])
        number[is_object] = np.arange(1, 1 + is_object.sum())
        return number[self.cluster_of_pixel]
