"""Read recordings of the TUM RGB-D benchmark: rgb.txt, depth.txt, groundtruth.txt."""

from __future__ import annotations

import re
from pathlib import Path

from curiosight.datasets.association import associate
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import IMAGE_ENDINGS, find_ground_truth, frame_id
from curiosight.datasets.trajectory import parse_stamp, read_trajectory, text_lines
from curiosight.errors import DataError
from curiosight.frame import Camera, Pose

# The benchmark's default intrinsics. The window is where registered depth of its Kinect exists
# at all distances, from the share of readings a column and row over 121 frames of fr1/rpy.
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5, depth_window=(17, 40, 588, 477))
UNIT = DepthForm(1 / 5000, is_assumed=True)
WHOSE = "the benchmark's default intrinsics are used"


class TumRgbd(Calibrated):
    """A sequence of the TUM RGB-D benchmark, or one recorded in its form."""

    name = "TUM RGB-D"
    evidence = "rgb.txt with depth.txt"
    usual_camera = CAMERA
    usual_form = UNIT
    whose = WHOSE

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds `rgb.txt` and `depth.txt`."""
        return (path / "rgb.txt").is_file() and (path / "depth.txt").is_file()

    def __init__(self, path: Path) -> None:
        listed, depth = _read_list(path / "rgb.txt"), _read_list(path / "depth.txt")
        colour = sorted(set(listed))
        pairs = associate(colour, depth)
        if not pairs:
            raise DataError(
                path,
                "no colour image has a depth image within 20 ms",
                "check the stamps in rgb.txt and depth.txt",
            )
        remarks: list[str] = []
        if len(colour) < len(listed):
            n_repeated = len(listed) - len(colour)
            remarks.append(f"{n_repeated} lines of rgb.txt repeat another: left out")
        if len(pairs) < len(colour):
            n_left_out = len(colour) - len(pairs)
            remarks.append(f"{n_left_out} colour images have no depth within 20 ms: left out")
        entries = _entries(path, pairs, remarks)
        super().__init__(path, entries, remarks)


def _read_list(path: Path) -> list[tuple[int, Path]]:
    """Read lines of `stamp file`, sorted by stamp in nanoseconds."""
    images = []
    for number, line in enumerate(text_lines(path), start=1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        try:
            stamp, name = re.split(r"\s*,\s*|\s+", line, maxsplit=1)
            images.append((parse_stamp(stamp), _listed_file(path.parent, name)))
        except ValueError:
            raise DataError(
                path, f'line {number} is "{line[:60]}"', "expected: stamp in seconds, file name"
            ) from None
    if not images:
        raise DataError(path, "lists no images", "check that the recording is complete")
    return sorted(images)


def _listed_file(folder: Path, name: str) -> Path:
    """Return the file of a list's line, in whose name there may be anything; `ValueError`."""
    if not _is_image_name(name):
        name = re.split(r"\s#", name, maxsplit=1)[0].rstrip()  # a comment may follow
    if not _is_image_name(name) and re.search(r"\s", name):
        raise ValueError(f"name: expected a file, got {name!r}")
    if "\\" in name and not (folder / name).is_file():
        name = name.replace("\\", "/")  # as Windows writes it
    return folder / name


def _is_image_name(name: str) -> bool:
    return name.lower().endswith((*IMAGE_ENDINGS, ".tif", ".tiff"))


def _entries(path: Path, pairs: list[tuple[int, Path, Path]], remarks: list[str]) -> list[Entry]:
    poses: list[Pose | None] = [None] * len(pairs)
    if (path / "groundtruth.txt").is_file():
        trajectory = read_trajectory(path / "groundtruth.txt")
        poses = trajectory.interpolated([stamp for stamp, _, _ in pairs])
        n_bad = int((~trajectory.valid).sum())
        if n_bad:
            remarks.append(f"{n_bad} lines of groundtruth.txt hold no valid pose: left out")
    ground_truth = find_ground_truth(path)
    return [
        Entry(
            id=frame_id(rgb),
            rgb=rgb,
            depth=depth,
            T_world_camera=pose,
            stamp_ns=stamp,
            ground_truth=ground_truth.get(frame_id(rgb)),
        )
        for (stamp, rgb, depth), pose in zip(pairs, poses, strict=True)
    ]
