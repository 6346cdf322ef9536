"""The files of a recording's frames, before any of them is opened."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from curiosight.datasets.cameras.depth_camera import DepthCamera
from curiosight.errors import DataError
from curiosight.frame import Camera, Pose


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """The files of one frame, before any of them is opened.

    depth: where the file should be; None only in recordings without depth.
    T_world_camera: as the recording has it, see `DepthCamera.has_the_poses`.
    confidence: an image of how sure depth is, more is surer.
    camera: intrinsics of this very image; None = the recording's.
    depth_camera: the camera of this very depth image; None = the recording's.
    problem: what listing the recording already found wrong with the frame. pose_problem: what is
        wrong with its pose, which counts where other frames have one.
    """

    id: str
    rgb: Path
    depth: Path | None = None
    T_world_camera: Pose | None = None
    stamp_ns: int | None = None
    ground_truth: Path | None = None
    problem: str | None = None
    pose_problem: str | None = None
    confidence: Path | None = None
    camera: Camera | None = None
    depth_camera: DepthCamera | None = None


def check_unique_ids(path: Path, entries: Iterable[Entry]) -> None:
    """Raise `DataError` where two frames have the same id: their outputs would be one file."""
    rgb_of_id: dict[str, Path] = {}
    for entry in entries:
        if entry.id in rgb_of_id:
            found = f"two frames are called '{entry.id}', {rgb_of_id[entry.id]} and {entry.rgb}"
            raise DataError(path, found, "give every colour image a name of its own")
        rgb_of_id[entry.id] = entry.rgb
