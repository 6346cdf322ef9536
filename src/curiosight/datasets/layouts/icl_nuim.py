"""Read ICL-NUIM (Imperial College London) in its TUM form: drawn rooms, y axis up."""

from __future__ import annotations

import re
from pathlib import Path

from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, list_images
from curiosight.datasets.pose_text import read_pose_rows
from curiosight.datasets.poses_of_entries import mirrored
from curiosight.errors import DataError
from curiosight.frame import Camera, Pose

# The makers' own, but for the sign of fy: they have the y axis point up.
CAMERA = Camera(640, 480, 481.2, 480.0, 319.5, 239.5)
UNIT = DepthForm(1 / 5000)
WHOSE = "the makers' intrinsics and unit, 0.0002 m, are taken"
FOLDER_NAME = re.compile(r"^(living|office)(?:_?room)?_(?:traj|kt)(\d)", re.IGNORECASE)


class IclNuim(Calibrated):
    """A trajectory of ICL-NUIM. Poses are mirrored, so that the y axis of the world points down.

    `*.gt.freiburg` gives poses of a camera whose y axis points up; the number in front is that
    of the image. Of the first image there may be none.
    """

    name = "ICL-NUIM"
    evidence = "rgb/ and depth/ with *.gt.freiburg"
    # They are mirrored here whatever the file of the camera says.
    poses_follow_camera = False
    usual_camera = CAMERA
    usual_form = UNIT
    whose = WHOSE

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds `rgb/`, `depth/` and the data set's own poses or name."""
        if not (path / "rgb").is_dir() or not (path / "depth").is_dir():
            return False
        is_named = FOLDER_NAME.match(path.resolve().name) and not (path / "rgb.txt").is_file()
        return _pose_file(path) is not None or bool(is_named)

    def __init__(self, path: Path) -> None:
        images = list_images(path / "rgb")
        file = _pose_file(path)
        remarks: list[str] = []
        poses: dict[str, Pose | None] = {}
        if file is not None:
            poses = _read_poses(file)
            n_other = sum(poses.get(_number(id)) is None for id in images)
            remarks.append(
                f"poses of {file.name} are matched by number and mirrored: there the y axis "
                "points up" + (f"; it has none for {n_other} images" if n_other else "")
            )
        ground_truth = find_ground_truth(path)
        entries = [
            Entry(
                id=id,
                rgb=rgb,
                depth=path / "depth" / f"{rgb.stem}.png",
                T_world_camera=poses.get(_number(id)),
                ground_truth=ground_truth.get(id),
            )
            for id, rgb in images.items()
        ]
        super().__init__(path, entries, remarks)


def _pose_file(path: Path) -> Path | None:
    """Return the poses' file: in the folder, or beside it where the two are called alike."""
    own = next(iter(sorted(path.glob("*.gt.freiburg"))), None)
    match = FOLDER_NAME.match(path.resolve().name)
    if own is not None or match is None:
        return own
    room = "livingRoom" if match[1].lower() == "living" else "traj"
    beside = path.resolve().parent / f"{room}{match[2]}.gt.freiburg"
    return beside if beside.is_file() else None


def _number(name: str) -> str:
    """Return a name's number without leading zeros, or the name."""
    return str(int(name)) if name.isdecimal() else name


def _read_poses(path: Path) -> dict[str, Pose | None]:
    """Map numbers of images to poses, the y axes of camera and world pointing down."""
    rows = read_pose_rows(path)
    if rows is None or any(row.key is None for row in rows):
        found = "does not hold lines of a number, tx ty tz qx qy qz qw"
        raise DataError(path, found, "copy it again or delete it")
    return {
        _number(row.key or ""): None if row.pose is None else mirrored(row.pose) for row in rows
    }
