"""Read frames named as in 7-Scenes that have a camera file: 3DMatch, TSDF demos, MIT-Princeton."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_file import FILE_NAME
from curiosight.datasets.cameras.camera_text import read_leaves
from curiosight.datasets.cameras.intrinsics import read_intrinsics
from curiosight.datasets.depth_bits import rotated_bits
from curiosight.datasets.depth_files import ASSUMED, DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, find_sequences, list_images
from curiosight.datasets.pose_files import find_poses
from curiosight.frame import Pose, is_rigid

# camera.json of our own may stand beside 7-Scenes too.
CAMERA_FILE = re.compile(
    r"^_?(?!camera\.json$)(?:(?:cam(?:era)?|colou?r|rgb|info|intrinsics?|intr|calib(?:ration)?|k)"
    r"[-_. ]?)+\.(?:txt|json|ya?ml|csv)$",
    re.IGNORECASE,
)
# Of MIT-Princeton's picking challenge: poses are in it, raw depth in raw/ beside registered.
POSES_INSIDE = "cam.info.txt"
TENTH_OF_A_MILLIMETRE = 0.0001
POSE_NAME = re.compile(r"camera.*world.*frame-?(\d+)")
Numbered = dict[int, Pose]


class ThreeDMatch(Calibrated):
    """A scene of 3DMatch, or of those who write its form; depth is registered to colour.

    Sequences that share a camera file share a world. Whether bits of depth are rotated, as in
    SUN3D and MIT-Princeton's picking challenge, is told by what the files hold.
    """

    name = "3DMatch / MIT-Princeton"
    has_any_unit = True
    evidence = "*.color.* with *.depth.png and camera-intrinsics.txt or cam.info.txt"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one in it, holds such frames and a camera file."""
        return path.is_dir() and bool(_sequences(path))

    def __init__(self, path: Path) -> None:
        sequences = _sequences(path)
        remarks: list[str] = []
        entries: list[Entry] = []
        for prefix, sequence in sequences.items():
            entries += _list_sequence(path, sequence, prefix, remarks)
        cameras = [_camera_file(sequence) for sequence in sequences.values()]
        camera = cameras[0]
        assert camera is not None
        if len(set(cameras)) > 1 and any(e.T_world_camera is not None for e in entries):
            remarks = ["each folder has a camera of its own: open a single one to have poses"]
            entries = [replace(entry, T_world_camera=None) for entry in entries]
        bits = rotated_bits([entry.depth for entry in entries if entry.depth is not None])
        if bits:
            remarks.append(f"bits of depth are rotated by {bits}, as its numbers tell: turned back")
        is_fine = bool(bits) and camera.name == POSES_INSIDE
        super().__init__(
            path,
            entries,
            remarks,
            usual_form=DepthForm(TENTH_OF_A_MILLIMETRE) if is_fine else ASSUMED,
            rotated_bits=bits,
            camera_folder=path if (path / FILE_NAME).is_file() else camera.parent,
        )


def _sequences(path: Path) -> dict[str, Path]:
    return find_sequences(path, _holds_frames, levels=1)


def _holds_frames(folder: Path) -> bool:
    has_images = any(folder.glob("*.color.*")) and any(folder.glob("*.depth.png"))
    return has_images and _camera_file(folder) is not None


def _camera_file(sequence: Path) -> Path | None:
    """Return the file with the intrinsics of a sequence, in it or one folder up."""
    for folder in (sequence, sequence.resolve().parent):
        # A folder that cannot be listed gives nothing here, where iterdir would raise.
        for path in sorted(folder.glob("*.*")):
            if CAMERA_FILE.match(path.name) and read_intrinsics(path) is not None:
                return path
    return None


def _list_sequence(root: Path, sequence: Path, prefix: str, remarks: list[str]) -> list[Entry]:
    images = list_images(sequence)
    inside = _poses_inside(sequence / POSES_INSIDE)
    poses: tuple[Pose | None, ...] = tuple(inside.get(_number(id)) for id in images)
    found = None if inside else find_poses(sequence, list(images))
    if found is not None:
        poses = found.poses
        remarks.append(found.remark)
    ground_truth = find_ground_truth(root, sequence, prefix)
    return [
        Entry(
            id=prefix + id,
            rgb=rgb,
            depth=sequence / f"{id}.depth.png",
            T_world_camera=pose,
            ground_truth=ground_truth.get(id),
        )
        for (id, rgb), pose in zip(images.items(), poses, strict=True)
    ]


def _poses_inside(path: Path) -> Numbered:
    """Map numbers of frames to the poses that a file of the camera holds beside intrinsics."""
    poses: Numbered = {}
    for name, numbers in read_leaves(path) or []:
        match = POSE_NAME.search(name)
        if match and len(numbers) == 16:
            pose = np.reshape(numbers, (4, 4)).astype(np.float64)
            if is_rigid(pose):
                poses[int(match[1])] = pose
    return poses


def _number(name: str) -> int:
    digits = re.findall(r"\d+", name)
    return int(digits[-1]) if digits else -1
