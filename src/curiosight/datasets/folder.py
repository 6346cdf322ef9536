"""Read a plain folder: rgb/, depth/, camera.json, and what else there may be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from curiosight.datasets.camera_file import FILE_NAME, REMEDY, read_camera_file
from curiosight.datasets.listing import find_ground_truth, list_images
from curiosight.datasets.recording import Entry, Recording
from curiosight.datasets.trajectory import Trajectory, parse_stamp, read_trajectory
from curiosight.errors import DataError

POSE_FILE = "poses.txt"
BAD_POSE = f"{POSE_FILE} holds no valid pose for it"
BY_ORDER = f"{POSE_FILE} is taken line by line: its stamps are not the images' names"
# A tracker may lose many frames, and a stamp with a fraction is not hit by chance; counted names
# are, so nearly all of theirs must be there.
MIN_SHARE_OF_STAMPS = 0.2
MIN_SHARE_OF_NUMBERS = 0.9


class Folder(Recording):
    """A folder with `rgb/` and `depth/`, files of the same names, registered to each other."""

    name = "plain folder"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds `rgb/` and `depth/`."""
        return (path / "rgb").is_dir() and (path / "depth").is_dir()

    def __init__(self, path: Path) -> None:
        calibration = read_camera_file(path)
        if calibration is None:
            raise DataError(path, f"has no {FILE_NAME}", REMEDY)
        images = list_images(path / "rgb")
        if not images:
            raise DataError(path / "rgb", "holds no images", "add colour images")
        if not any((path / "depth").glob("*.png")):
            raise DataError(path / "depth", "holds no .png files", "add 16-bit depth images")
        rows: Sequence[int | None] = [None] * len(images)
        remarks: list[str] = []
        if (path / POSE_FILE).is_file():
            trajectory = read_trajectory(path / POSE_FILE)
            rows, remarks = _match_rows(path / POSE_FILE, trajectory, list(images))
            poses = trajectory.poses()
        ground_truth = find_ground_truth(path)
        entries = [
            Entry(
                id=id,
                rgb=rgb,
                depth=path / "depth" / f"{rgb.stem}.png",
                T_world_camera=None if row is None else poses[row],
                stamp_ns=None if row is None else int(trajectory.stamps_ns[row]),
                ground_truth=ground_truth.get(id),
                problem=BAD_POSE if row is not None and poses[row] is None else None,
            )
            for (id, rgb), row in zip(images.items(), rows, strict=True)
        ]
        super().__init__(
            path,
            entries,
            calibration.camera,
            depth_scale=calibration.depth_scale,
            labels=calibration.labels,
            remarks=remarks,
        )


def _match_rows(
    path: Path, trajectory: Trajectory, ids: list[str]
) -> tuple[Sequence[int | None], list[str]]:
    """Return each frame's row of the trajectory, by stamp in its name or by order; remarks."""
    row_of_stamp = {int(stamp): row for row, stamp in enumerate(trajectory.stamps_ns)}
    stamps = [_stamp_of_name(id) for id in ids]
    rows = [None if stamp is None else row_of_stamp.get(stamp) for stamp in stamps]
    n_poses, n_matched = len(trajectory.stamps_ns), len(ids) - rows.count(None)
    share = MIN_SHARE_OF_STAMPS
    if all(id.isdecimal() for id in ids):
        # Names that count from 1 meet nearly all stamps that count from 0, each the wrong one.
        share = 1.0 if n_poses == len(ids) else MIN_SHARE_OF_NUMBERS
    if n_matched >= share * len(ids):
        return rows, []
    if n_poses == len(ids):
        return range(len(ids)), [] if None in stamps else [BY_ORDER]
    raise DataError(
        path,
        f"holds {n_poses} poses for {len(ids)} colour images, "
        f"and its stamps are the names of {n_matched or 'none'} of them",
        "give one line a frame, or name the images by their stamps",
    )


def _stamp_of_name(id: str) -> int | None:
    try:
        return parse_stamp(id)
    except ValueError:
        return None
