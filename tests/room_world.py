"""The ray-cast room as a recording in memory, and as a world to explore."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.datasets import Dataset
from curiosight.frame import Frame
from curiosight.worlds import ReplayWorld
from room import ROOM, Box, kinect, look, render

# The wall stands near enough to be taught: how a forest scores what it was never taught of is
# left to chance.
NEAR_WALL = Box((0.0, 1.3, 1.25), (12.0, 0.2, 2.5), (190, 190, 170), is_salient=False)
SMALL_ROOM = (*(box for box in ROOM if box.is_salient), NEAR_WALL)


class RoomRecording:
    """Views from an arc of 60 degrees around the boxes, ground truth for all of them.

    offset_deg turns the whole arc, so that two recordings share no view. Tests spoil single
    frames by replacing them, and take ground truth away by emptying `truths`.
    """

    name = "room"
    has_depth = True
    remarks: tuple[str, ...] = ()

    def __init__(self, n_frames: int = 24, *, offset_deg: float = 0.0) -> None:
        self.camera = kinect()
        self.poses = [look(heading) for heading in np.linspace(-30, 30, n_frames) + offset_deg]
        self.ids = [f"view-{index}" for index in range(n_frames)]
        views = [render(self.camera, pose, SMALL_ROOM) for pose in self.poses]
        self.frames = [
            Frame(id, view.rgb, view.depth, self.camera, pose)
            for id, view, pose in zip(self.ids, views, self.poses, strict=True)
        ]
        self.truths = {index: view.ground_truth for index, view in enumerate(views)}

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, index: int) -> Frame:
        return self.frames[index]

    def has_ground_truth(self, index: int) -> bool:
        return index in self.truths

    def ground_truth(self, index: int) -> npt.NDArray[np.uint8] | None:
        return self.truths.get(index)

    def labelled(self) -> list[tuple[Frame, npt.NDArray[np.uint8]]]:
        """Return frames with their ground truth, as `HeldOut` takes them."""
        return [(self.frames[index], truth) for index, truth in self.truths.items()]


def room_world(recording: Dataset) -> ReplayWorld:
    """Return a world of four regions, neighbouring views together."""
    return ReplayWorld(recording, np.arange(len(recording)) * 4 // len(recording))
