"""Read recordings of 7-Scenes (Microsoft Research): frame-NNNNNN.color, .depth, .pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from curiosight.datasets.camera_file import CameraFile, read_camera_file, scaled_camera
from curiosight.datasets.decoding import UnreadableFile, read_depth
from curiosight.datasets.listing import find_ground_truth, find_sequences, list_images
from curiosight.datasets.recording import (
    Entry,
    Recording,
    check_frame_size,
    first_size,
    image_size,
)
from curiosight.datasets.registration import covered_window, register_depth
from curiosight.datasets.trajectory import read_pose
from curiosight.errors import DataError
from curiosight.frame import Camera, Depth, Pose

# The depth intrinsics are the data set's own. Its makers publish none for the colour camera:
# these, and the shift between the two, were fitted by aligning edges over 24 frames of
# RedKitchen. The rightmost 8 columns of this Kinect's depth never hold a reading (500 frames).
DEPTH_CAMERA = Camera(640, 480, 585.0, 585.0, 320.0, 240.0, depth_window=(0, 0, 632, 480))
COLOUR_CAMERA = Camera(640, 480, 526.5, 526.5, 320.4, 237.0)
COLOUR_FROM_DEPTH_METRES = (-0.026, 0.004, 0.0)
MILLIMETRE = 0.001


class SevenScenes(Recording):
    """A scene of 7-Scenes, or one of its sequences; depth is registered when read."""

    name = "7-Scenes"

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
        depth_size = first_size(depth_files, lambda file: read_depth(file, MILLIMETRE))
        calibration = read_camera_file(path) or CameraFile(
            scaled_camera(COLOUR_CAMERA, size), MILLIMETRE
        )
        self.depth_camera = scaled_camera(DEPTH_CAMERA, depth_size or size)
        super().__init__(
            path,
            entries,
            _with_window(path, calibration.camera, self.depth_camera),
            depth_scale=calibration.depth_scale,
            labels=calibration.labels,
        )

    def read_depth(self, path: Path) -> Depth:
        """Read depth and register it to the colour image."""
        depth = super().read_depth(path)
        camera = self.depth_camera
        check_frame_size(path, depth.shape, (camera.width, camera.height))
        assert self.camera is not None
        return register_depth(depth, camera, self.camera, _T_colour_depth())


def _sequences(path: Path) -> dict[str, Path]:
    return find_sequences(path, _holds_frames, levels=1, pattern="seq*")


def _with_window(path: Path, camera: Camera, depth_camera: Camera) -> Camera:
    """Add what the depth camera covers of the colour image, unless a window is given."""
    if camera.depth_window is not None:
        return camera
    window = covered_window(depth_camera, camera, _T_colour_depth())
    try:
        return replace(camera, depth_window=window)
    except ValueError as error:
        found = f"its colour and depth cameras have no view in common ({error})"
        raise DataError(path, found, "correct camera.json") from None


def _holds_frames(folder: Path) -> bool:
    return any(folder.glob("frame-*.color.*")) and any(folder.glob("frame-*.depth.png"))


def _list_sequence(root: Path, sequence: Path, prefix: str) -> list[Entry]:
    has_poses = any(sequence.glob("frame-*.pose.txt"))
    ground_truth = find_ground_truth(root, sequence, prefix)
    entries = []
    for id, rgb in list_images(sequence).items():
        pose, problem = _colour_pose(sequence / f"{id}.pose.txt") if has_poses else (None, None)
        entries.append(
            Entry(
                id=prefix + id,
                rgb=rgb,
                depth=sequence / f"{id}.depth.png",
                T_world_camera=pose,
                ground_truth=ground_truth.get(id),
                problem=problem,
            )
        )
    return entries


def _colour_pose(path: Path) -> tuple[Pose | None, str | None]:
    """Return the colour camera's pose, from the file's of the depth camera, or the problem."""
    try:
        T_world_depth = read_pose(path)
    except UnreadableFile as fault:
        return None, str(fault)
    return T_world_depth @ np.linalg.inv(_T_colour_depth()), None


def _T_colour_depth() -> Pose:  # noqa: N802
    pose = np.eye(4)
    pose[:3, 3] = COLOUR_FROM_DEPTH_METRES
    return pose
