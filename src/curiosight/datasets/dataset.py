"""What a dataset is: a recording to look at, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Frame, Pose

GroundTruth = npt.NDArray[np.uint8]
InstanceTruth = npt.NDArray[np.int32]


class Dataset(Protocol):
    """A recording to look at, frame by frame; `check_dataset` tells whether it keeps its word.

    name: the layout, such as "7-Scenes".
    ids: one unique name a frame, usable as a relative file name; outputs are named by it.
    poses: (4, 4) camera-to-world of the colour camera or None, known without decoding.
    camera: intrinsics of the colour image; None only where `has_depth` is False.
    remarks: sentences on how the source was read that its owner should know.
    """

    @property
    def name(self) -> str: ...
    @property
    def ids(self) -> Sequence[str]: ...
    @property
    def poses(self) -> Sequence[Pose | None]: ...
    @property
    def camera(self) -> Camera | None: ...
    @property
    def has_depth(self) -> bool: ...
    @property
    def remarks(self) -> Sequence[str]: ...

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> Frame:
        """Decode a frame; what is wrong with it stands in `Frame.problem`, nothing is raised."""
        ...

    def has_ground_truth(self, index: int) -> bool:
        """Tell whether `ground_truth` has an answer, without decoding it."""
        ...

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return (H, W) uint8: 255 salient, 0 not salient, 125 ignored; None if there is none."""
        ...


@runtime_checkable
class KnowsDistances(Protocol):
    """A dataset that knows more than its depth sensor sees, such as a drawn room."""

    def true_depth(self, index: int) -> Depth:
        """Return (H, W) float32 metres along z, without noise, holes or limit of range."""
        ...


@runtime_checkable
class KnowsPlaces(Protocol):
    """A dataset that knows in which room each frame was taken: truth, for scoring alone.

    No learner, region or strategy may ask.
    """

    def place(self, index: int) -> int:
        """Return the number of the room, from 0."""
        ...


@runtime_checkable
class KnowsInstances(Protocol):
    """A dataset whose ground truth may tell one object from another."""

    def instance_truth(self, index: int) -> InstanceTruth | None:
        """Return (H, W) int32: a number an object, 0 = none, -1 = ignored; None if unknown."""
        ...
