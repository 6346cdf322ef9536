"""Read a plain folder: rgb/, depth/, camera.json, and what else there may be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from curiosight.datasets.cameras.camera_file import FILE_NAME, REMEDY, read_camera_file
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.listing import find_ground_truth, list_images
from curiosight.datasets.pose_files import find_poses
from curiosight.datasets.pose_match import match_stamps
from curiosight.datasets.recording import Entry, Recording
from curiosight.datasets.trajectory import read_trajectory, table_rows
from curiosight.datasets.y_up import with_y_down
from curiosight.errors import DataError
from curiosight.frame import Pose

POSE_FILE = "poses.txt"
BAD_POSE = f"{POSE_FILE} holds no valid pose for it"
BY_ORDER = f"{POSE_FILE} is taken line by line: its stamps are not the images' names"


class Folder(Recording):
    """A folder with `rgb/` and `depth/`, files of the same names, registered to each other."""

    name = "plain folder"
    evidence = "rgb/ with depth/"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds `rgb/` and `depth/`."""
        return (path / "rgb").is_dir() and (path / "depth").is_dir()

    def __init__(self, path: Path) -> None:
        calibration = read_camera_file(path, may_be_y_up=True)
        if calibration is None:
            raise DataError(path, f"has no {FILE_NAME}", REMEDY)
        images = list_images(path / "rgb")
        if not images:
            raise DataError(path / "rgb", "holds no images", "add colour images")
        if not any((path / "depth").glob("*.png")):
            raise DataError(path / "depth", "holds no .png files", "add 16-bit depth images")
        poses, stamps, remarks = _poses(path, list(images))
        ground_truth = find_ground_truth(path)
        entries = [
            Entry(
                id=id,
                rgb=rgb,
                depth=path / "depth" / f"{rgb.stem}.png",
                T_world_camera=pose,
                stamp_ns=stamp,
                ground_truth=ground_truth.get(id),
                problem=BAD_POSE if pose is None and stamp is not None else None,
            )
            for (id, rgb), pose, stamp in zip(images.items(), poses, stamps, strict=True)
        ]
        if calibration.is_y_up:
            entries = with_y_down(entries, remarks)
        super().__init__(
            path,
            entries,
            calibration.camera,
            depth_form=DepthForm(calibration.depth_scale),
            remarks=remarks,
        )


def _poses(
    path: Path, ids: Sequence[str]
) -> tuple[Sequence[Pose | None], Sequence[int | None], list[str]]:
    """Return each image's pose and the stamp of its line of `poses.txt`, and remarks."""
    unknown = [None] * len(ids)
    file = path / POSE_FILE
    _, words = next(table_rows(file), (0, [])) if file.is_file() else (0, [])
    if not file.is_file() or (words and len(words) != 8):
        found = find_poses(path, ids)
        if found is not None:
            return found.poses, unknown, [found.remark]
        if not file.is_file():
            return unknown, unknown, []
    trajectory = read_trajectory(file)
    rows, is_by_order = match_stamps(file, trajectory.stamps_ns.tolist(), ids)
    listed = trajectory.poses()
    return (
        [None if row is None else listed[row] for row in rows],
        [None if row is None else int(trajectory.stamps_ns[row]) for row in rows],
        [BY_ORDER] if is_by_order else [],
    )
