"""Read Replica as NICE-SLAM ships it: results/frameNNNNNN.jpg, depthNNNNNN.png, traj.txt."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.calibration import find_calibration
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.scans import Scan, Scans, numbered, remark_on_poses, with_depth
from curiosight.datasets.sizes import image_size
from curiosight.datasets.trajectory import table_rows
from curiosight.errors import DataError
from curiosight.frame import Camera, Pose, is_rigid

POSE_FILE = "traj.txt"
CAMERA = Camera(1200, 680, 600.0, 600.0, 599.5, 339.5)
DEPTH_SCALE = 1 / 6553.5
WHOSE = "the usual intrinsics of this data set are assumed"


class Replica(Scans):
    """A room, or a folder of them."""

    name = "Replica"
    evidence = f"results/frameNNNNNN.jpg with results/depthNNNNNN.png, {POSE_FILE}"

    @staticmethod
    def holds_scan(folder: Path) -> bool:
        """Tell whether the folder holds poses, and colour and depth in `results`."""
        images = folder / "results"
        is_complete = (folder / POSE_FILE).is_file() and images.is_dir()
        return is_complete and any(images.glob("frame*.*")) and any(images.glob("depth*.png"))

    def read_scan(self, folder: Path) -> Scan:
        """List the frames; line k of the poses is of the k-th frame."""
        remarks: list[str] = []
        images = folder / "results"
        colour = numbered(p for e in ("jpg", "jpeg", "png") for p in images.glob(f"frame*.{e}"))
        depth = numbered(images.glob("depth*.png"))
        numbers = with_depth(colour, depth, images, remarks)
        poses = _read_poses(folder / POSE_FILE)
        if len(poses) != len(colour):
            n_frames = len(colour)
            remarks.append(f"{POSE_FILE} has {len(poses)} lines for {n_frames} frames: in order")
        pose_of = dict(zip(colour, poses, strict=False))
        size = image_size(images, [colour[number] for number in numbers])
        calibration = find_calibration(folder, size, remarks, CAMERA, whose=WHOSE)
        entries = [
            Entry(colour[number].stem, colour[number], depth[number], pose_of.get(number))
            for number in numbers
        ]
        remark_on_poses(entries, remarks)
        form = calibration.depth_form(DepthForm(DEPTH_SCALE, is_assumed=True))
        return Scan(entries, calibration.camera, form, remarks)


def _read_poses(path: Path) -> list[Pose | None]:
    """Read lines of 16 numbers, camera to world, None = not a pose; `DataError` if malformed."""
    poses: list[Pose | None] = []
    for number, words in table_rows(path):
        try:
            pose = np.array(words, np.float64).reshape(4, 4)
        except ValueError:
            found = f'line {number} is "{" ".join(words)[:60]}"'
            raise DataError(path, found, "expected: the 16 numbers of a 4x4 matrix") from None
        poses.append(pose if is_rigid(pose) else None)
    if not poses:
        raise DataError(path, "holds no poses", "fill it or delete it")
    return poses
