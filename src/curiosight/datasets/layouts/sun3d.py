"""Read SUN3D (Princeton): image/ and depth/ called by number and time, poses in extrinsics/."""

from __future__ import annotations

import re
from pathlib import Path

from curiosight.datasets.association import associate
from curiosight.datasets.depth_bits import rotated_bits
from curiosight.datasets.depth_files import MILLIMETRES
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, list_images
from curiosight.datasets.pose_files import find_poses
from curiosight.errors import DataError

NAME = re.compile(r"^\d+-(\d{12})$")
NS_PER_MICROSECOND = 1000
NO_DEPTH = "no depth image was taken within 20 ms"


class Sun3d(Calibrated):
    """A sequence of SUN3D; colour takes the depth that is nearest in time."""

    name = "SUN3D"
    evidence = "image/ and depth/ with names such as 0000001-000000000000 and intrinsics.txt"
    usual_form = MILLIMETRES

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds colour and depth with such names, and intrinsics."""
        folders = path / "image", path / "depth"
        if not (path / "intrinsics.txt").is_file() or not all(map(Path.is_dir, folders)):
            return False
        return all(any(_micros(file) is not None for file in f.iterdir()) for f in folders)

    def __init__(self, path: Path) -> None:
        images = list_images(path / "image")
        depth = [(_stamp(file), file) for file in sorted((path / "depth").glob("*.png"))]
        colour = [(_stamp(rgb), rgb) for rgb in images.values()]
        depth_of = {rgb: file for _, rgb, file in associate(colour, depth)} if depth else {}
        if not depth_of:
            raise DataError(path, "no image has depth within 20 ms", "check the files' names")
        remarks: list[str] = []
        # The latest is the best of them.
        files = sorted((path / "extrinsics").glob("*.txt"))[-1:]
        found = find_poses(path, [rgb.stem for rgb in images.values()], files=files)
        poses = found.poses if found else (None,) * len(images)
        remarks += [found.remark] if found else []
        ground_truth = find_ground_truth(path)
        entries = [
            Entry(
                id=id,
                rgb=rgb,
                depth=depth_of.get(rgb, path / "depth" / f"{rgb.stem}.png"),
                T_world_camera=pose,
                stamp_ns=_stamp(rgb),
                ground_truth=ground_truth.get(id),
                problem=None if rgb in depth_of else NO_DEPTH,
            )
            for (id, rgb), pose in zip(images.items(), poses, strict=True)
        ]
        bits = rotated_bits(list(depth_of.values()))
        if not bits:
            remarks.append("bits of depth are not rotated here: read as plain numbers")
        super().__init__(path, entries, remarks, rotated_bits=bits)


def _micros(path: Path) -> int | None:
    match = NAME.match(path.stem)
    return int(match[1]) if match else None


def _stamp(path: Path) -> int:
    """Return nanoseconds since the sequence began; far off where the name tells no time."""
    micros = _micros(path)
    return -(NS_PER_MICROSECOND**3) if micros is None else micros * NS_PER_MICROSECOND
