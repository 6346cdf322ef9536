"""`check_dataset` finds each breach of the contract, and says which."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from curiosight.datasets import check_dataset
from curiosight.frame import Frame
from room import kinect, poses_around, render


class InMemory:
    """A sound dataset of the room, to be spoilt in one place."""

    name = "in memory"
    has_depth = True
    remarks = ()

    def __init__(self) -> None:
        self.camera = kinect(64, 48)
        self.poses: list[Any] = list(poses_around(2))
        self.views = [render(self.camera, pose) for pose in self.poses]
        self.ids = ["a", "b"]
        self.depths: list[Any] = [view.depth for view in self.views]
        self.truths: list[Any] = [self.views[0].ground_truth, None]

    def __len__(self) -> int:
        return 2

    def __getitem__(self, index: int) -> Frame:
        return Frame(
            self.ids[index],
            self.views[index].rgb,
            self.depths[index],
            self.camera,
            self.poses[index],
        )

    def has_ground_truth(self, index: int) -> bool:
        return index == 0

    def ground_truth(self, index: int) -> Any:
        return self.truths[index]


class Restless(InMemory):
    """Gives another picture at every reading."""

    def __getitem__(self, index: int) -> Frame:
        self.depths[index] = self.depths[index] * np.float32(1.01)
        return super().__getitem__(index)


class Forgetful(InMemory):
    """Lists poses that its frames do not carry."""

    def __getitem__(self, index: int) -> Frame:
        return Frame(self.ids[index], self.views[index].rgb, self.depths[index], self.camera)


def test_sound_dataset_passes() -> None:
    check_dataset(InMemory())


def with_zeros(dataset: InMemory) -> None:
    dataset.depths[1] = np.where(dataset.views[1].surface == 0, 0, dataset.depths[1])


def in_millimetres(dataset: InMemory) -> None:
    dataset.depths = [depth * np.float32(1000) for depth in dataset.depths]


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda it: it.ids.append("c"), "ids: expected 2"),
        (lambda it: it.ids.__setitem__(1, "a"), "unique names, got 'a' twice"),
        (lambda it: it.ids.__setitem__(0, "../a"), "safe relative file names"),
        (lambda it: it.ids.__setitem__(0, "/a"), "safe relative file names"),
        (lambda it: it.ids.__setitem__(0, "a\\b"), "safe relative file names"),
        (lambda it: it.poses.pop(), "poses: expected 2"),
        (lambda it: it.poses.__setitem__(0, np.diag([2.0, 1, 1, 1])), "poses of a: expected"),
        (with_zeros, "NaN where there is no reading"),
        (in_millimetres, "is it in millimetres?"),
        (lambda it: setattr(it, "has_depth", False), "depth of a: expected None"),
        (lambda it: setattr(it, "camera", kinect(64, 50)), "camera"),
        (lambda it: it.truths.__setitem__(0, None), "as `has_ground_truth` says"),
        (lambda it: it.truths.__setitem__(0, np.zeros((4, 4), np.uint8)), "ground truth of a"),
        (lambda it: it.truths.__setitem__(0, np.full((48, 64), 7, np.uint8)), "125 and 255"),
        (lambda it: delattr(it, "camera"), "camera: expected a member"),
    ],
)
def test_breach_is_named(spoil: Callable[[InMemory], Any], words: str) -> None:
    dataset = InMemory()
    spoil(dataset)
    with pytest.raises(ValueError, match=r".") as caught:
        check_dataset(dataset)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "words"), [(Restless, "the same at every reading"), (Forgetful, "pose of a")]
)
def test_frames_that_break_their_word(kind: type[InMemory], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        check_dataset(kind())
