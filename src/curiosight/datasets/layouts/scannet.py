"""Read exports of ScanNet: color/, depth/, pose/ and the intrinsics of both cameras."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.cameras.depth_camera import DepthCamera, with_window
from curiosight.datasets.cameras.intrinsics import pixels_of_numbers
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import DepthForm, read_raw_depth
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.scans import (
    Scan,
    Scans,
    centred_size,
    numbered,
    remark_on_poses,
    with_depth,
)
from curiosight.datasets.listing import list_images
from curiosight.datasets.sizes import Size, first_size, image_size
from curiosight.datasets.trajectory import read_pose
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text
from curiosight.frame import Camera, Pose

IMAGE_FOLDERS = ("color", "depth")
# Those of SensReader, then those of the 25 000 frames.
CAMERA_FILES = ("intrinsic/intrinsic_{}.txt", "intrinsics_{}.txt", "intrinsic_{}.txt")
ABOUT_FILES = ("_info.txt", "scene*.txt")
COLOUR_SIZE, DEPTH_SIZE = (1296, 968), (640, 480)
MILLIMETRE = 0.001
# Of depth images: less is what rounding leaves.
MAX_APART_PX = 1.0

About = dict[str, list[float]]


class ScanNet(Scans):
    """A scene of ScanNet, or a folder of them.

    Both cameras stand in one place; where more than scale tells their images apart, depth is
    cast into the colour image.
    """

    name = "ScanNet"
    evidence = "color/ with depth/, intrinsic_color.txt or scene*.txt"
    levels = 2

    @staticmethod
    def holds_scan(folder: Path) -> bool:
        """Tell whether colour, depth and intrinsics stand in the folder or in its `frames`."""
        base = _base(folder)
        return base is not None and _pixels(base, "color", _read_about(base)) is not None

    def read_scan(self, folder: Path) -> Scan:
        """List the frames that have depth."""
        base = _base(folder)
        assert base is not None
        remarks: list[str] = []
        colour = numbered(list_images(base / "color").values())
        depth = numbered((base / "depth").glob("*.[pP][nNgG][gGmM]"))
        numbers = with_depth(colour, depth, base, remarks)
        poses = numbered((base / "pose").glob("*.txt"))
        entries = [
            Entry(colour[number].stem, colour[number], depth[number], _pose(poses.get(number)))
            for number in numbers
        ]
        remark_on_poses(entries, remarks)
        about = _read_about(base)
        size = image_size(base, [entry.rgb for entry in entries])
        depth_size = first_size([depth[number] for number in numbers], read_raw_depth)
        camera = _camera(base, "color", about, (size, COLOUR_SIZE, DEPTH_SIZE))
        if camera is None:
            raise DataError(base, "has no intrinsics of colour", "export it with intrinsics")
        camera = scaled_camera(camera, size)
        depth_camera = _depth_camera(base, about, camera, depth_size or size)
        if depth_camera is not None:
            camera = with_window(base, camera, depth_camera)
            remarks.append("depth is cast into the colour image: their intrinsics differ")
        shift = next(iter(about.get("m_depthShift", [])), 0.0)
        form = DepthForm(1 / shift if shift > 0 else MILLIMETRE)
        return Scan(entries, camera, form, remarks, depth_camera)


def _base(folder: Path) -> Path | None:
    for base in (folder, folder / "frames"):
        if all((base / name).is_dir() for name in IMAGE_FOLDERS):
            return base
    return None


def _pose(path: Path | None) -> Pose | None:
    """Return camera to world; None where tracking was lost, which is written as -inf."""
    try:
        return None if path is None else read_pose(path)
    except UnreadableFile:
        return None


def _depth_camera(base: Path, about: About, colour: Camera, size: Size) -> DepthCamera | None:
    """Return the depth camera, where more than its size tells it from the colour camera."""
    camera = _camera(base, "depth", about, (size, DEPTH_SIZE))
    if camera is None:
        return None
    camera = scaled_camera(replace(camera, depth_window=None), size)
    like = scaled_camera(colour, size)
    ends = np.array([0.0, size[0] - 1.0]), np.array([0.0, size[1] - 1.0])
    apart = max(
        np.abs((ends[0] - camera.cx) * like.fx / camera.fx + like.cx - ends[0]).max(),
        np.abs((ends[1] - camera.cy) * like.fy / camera.fy + like.cy - ends[1]).max(),
    )
    return DepthCamera(camera, np.eye(4)) if apart > MAX_APART_PX else None


def _camera(base: Path, kind: str, about: About, sizes: tuple[Size, ...]) -> Camera | None:
    """Return the intrinsics of "color" or "depth" for the likeliest of some sizes of images."""
    pixels = _pixels(base, kind, about)
    if pixels is None:
        return None
    return Camera(*centred_size(pixels[2], pixels[3], sizes), *pixels)


def _pixels(base: Path, kind: str, about: About) -> tuple[float, float, float, float] | None:
    for name in CAMERA_FILES:
        path = base / name.format(kind)
        if path.is_file() and (pixels := pixels_of_numbers(_numbers(_text(path)))):
            return pixels
    matrix = about.get(f"m_calibration{kind.capitalize()}Intrinsic", [])
    keys = [f"{key}_{kind}" for key in ("fx", "fy", "mx", "my")]
    named = [about[key][0] for key in keys if about.get(key)]
    return pixels_of_numbers(matrix if matrix else named)


def _read_about(base: Path) -> About:
    """Read lines of `key = numbers` from what stands beside a scan."""
    about: About = {}
    for path in _about_files(base):
        for line in _text(path).splitlines():
            key, _, values = line.partition("=")
            numbers = _numbers(values)
            if numbers:
                about.setdefault(key.strip(), numbers)
    return about


def _about_files(base: Path) -> Iterator[Path]:
    folders = [base, base.parent] if base.name == "frames" else [base]
    for folder in folders:
        for pattern in ABOUT_FILES:
            yield from sorted(folder.glob(pattern))


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except (OSError, UnicodeDecodeError):
        return ""


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []
