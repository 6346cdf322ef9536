"""Read recordings of 7-Scenes (Microsoft Research): frame-NNNNNN.color, .depth, .pose."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_file import CameraFile, read_camera_file, scaled_camera
from curiosight.datasets.cameras.depth_camera import DepthCamera, with_window
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import MILLIMETRES, read_raw_depth
from curiosight.datasets.entries import Entry
from curiosight.datasets.listing import find_ground_truth, find_sequences, list_images
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import first_size, image_size
from curiosight.datasets.trajectory import read_pose
from curiosight.frame import Camera, Pose

# The depth intrinsics are the data set's own. Its makers publish none for the colour camera:
# these, and the shift between the two, were fitted by aligning edges over 24 frames of
# RedKitchen. The rightmost 8 columns of this Kinect's depth never hold a reading (500 frames).
DEPTH_CAMERA = Camera(640, 480, 585.0, 585.0, 320.0, 240.0, depth_window=(0, 0, 632, 480))
COLOUR_CAMERA = Camera(640, 480, 526.5, 526.5, 320.4, 237.0)
COLOUR_FROM_DEPTH_METRES = (-0.026, 0.004, 0.0)


class SevenScenes(Recording):
    """A scene of 7-Scenes, or one of its sequences; depth is registered when read."""

    name = "7-Scenes"
    evidence = "frame-*.color.* with frame-*.depth.png, in the folder or in seq-*/"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or a `seq*` folder in it, holds frames of this layout."""
        return bool(_sequences(path))

    def __init__(self, path: Path) -> None:
        entries = [
            entry
            for prefix, sequence in _sequences(path).items()
            for entry in _list_sequence(path, sequence, prefix)
        ]
        size = image_size(path, [entry.rgb for entry in entries])
        depth_files = [entry.depth for entry in entries if entry.depth]
        depth_size = first_size(depth_files, read_raw_depth)
        calibration = read_camera_file(path) or CameraFile(scaled_camera(COLOUR_CAMERA, size), None)
        depth_camera = DepthCamera(
            scaled_camera(DEPTH_CAMERA, depth_size or size), _T_colour_depth(), has_the_poses=True
        )
        super().__init__(
            path,
            entries,
            with_window(path, calibration.camera, depth_camera),
            depth_form=calibration.depth_form(MILLIMETRES),
            depth_camera=depth_camera,
            labels=calibration.labels,
        )
        self.mount = calibration.mount


def _sequences(path: Path) -> dict[str, Path]:
    return find_sequences(path, _holds_frames, levels=1, pattern="seq*")


def _holds_frames(folder: Path) -> bool:
    return any(folder.glob("frame-*.color.*")) and any(folder.glob("frame-*.depth.png"))


def _list_sequence(root: Path, sequence: Path, prefix: str) -> list[Entry]:
    has_poses = any(sequence.glob("frame-*.pose.txt"))
    ground_truth = find_ground_truth(root, sequence, prefix)
    entries = []
    for id, rgb in list_images(sequence).items():
        pose, problem = _pose(sequence / f"{id}.pose.txt") if has_poses else (None, None)
        entries.append(
            Entry(
                id=prefix + id,
                rgb=rgb,
                depth=sequence / f"{id}.depth.png",
                T_world_camera=pose,
                ground_truth=ground_truth.get(id),
                pose_problem=problem,
            )
        )
    return entries


def _pose(path: Path) -> tuple[Pose | None, str | None]:
    """Return the pose of a file, or the problem."""
    try:
        return read_pose(path), None
    except UnreadableFile as fault:
        return None, str(fault)


def _T_colour_depth() -> Pose:  # noqa: N802
    pose = np.eye(4)
    pose[:3, 3] = COLOUR_FROM_DEPTH_METRES
    return pose
