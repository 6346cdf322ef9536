"""Read recordings of Stray Scanner (iPhone, iPad): rgb.mp4, depth/, odometry.csv."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.cameras.intrinsics import pixels_of_numbers, read_intrinsics
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.scans import (
    Scan,
    Scans,
    centred_size,
    numbered,
    remark_on_poses,
    with_depth,
)
from curiosight.datasets.sizes import Size
from curiosight.datasets.video_frames import VideoFrames
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text
from curiosight.frame import Camera, Pose, Rgb
from curiosight.frame.rotations import matrix_of

VIDEO, ODOMETRY, CAMERA_FILE = "rgb.mp4", "odometry.csv", "camera_matrix.csv"
POSE_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
CAMERA_COLUMNS = ("fx", "fy", "cx", "cy")
PHONE_SIZE = (1920, 1440)
MILLIMETRES = DepthForm(0.001, float_scale=0.001)
NS_PER_SECOND = 1e9
MAX_SECONDS = 1e9


@dataclass(frozen=True, slots=True)
class Row:
    """What a line of `odometry.csv` says of a frame; None where it does not."""

    T_world_camera: Pose | None = None
    stamp_ns: int | None = None
    camera: Camera | None = None


class StrayScanner(Scans):
    """A recording of Stray Scanner, or a folder of them; colour is a video."""

    name = "Stray Scanner"
    evidence = f"{VIDEO} with depth/ and {ODOMETRY}"

    def __init__(self, path: Path) -> None:
        self._videos: dict[Path, VideoFrames] = {}
        super().__init__(path)

    @staticmethod
    def holds_scan(folder: Path) -> bool:
        """Tell whether the folder holds the video, its depth and its poses."""
        files = (VIDEO, ODOMETRY)
        return all((folder / file).is_file() for file in files) and (folder / "depth").is_dir()

    def read_scan(self, folder: Path) -> Scan:
        """List the frames that have depth."""
        remarks: list[str] = []
        video = self._videos[folder / VIDEO] = VideoFrames(folder / VIDEO, is_turned=False)
        size = video.shape[1], video.shape[0]
        rows = _read_odometry(folder / ODOMETRY, size)
        if len(rows) != video.n_frames:
            n_rows, n_frames = len(rows), video.n_frames
            remarks.append(f"{ODOMETRY} has {n_rows} rows for the {n_frames} frames of {VIDEO}")
        video.close()
        depth = numbered(
            path for ending in ("npy", "png") for path in (folder / "depth").glob(f"*.{ending}")
        )
        confidence = numbered((folder / "confidence").glob("*.png"))
        colour = dict.fromkeys(range(video.n_frames), folder / VIDEO)
        entries = [
            Entry(
                f"{number:06d}",
                colour[number],
                depth[number],
                rows.get(number, Row()).T_world_camera,
                rows.get(number, Row()).stamp_ns,
                confidence=confidence.get(number),
                camera=rows.get(number, Row()).camera,
            )
            for number in with_depth(colour, depth, folder, remarks)
        ]
        remark_on_poses(entries, remarks)
        return Scan(entries, _camera(folder, size, entries), MILLIMETRES, remarks)

    def colour_size(self) -> Size:
        """Return (width, height) of the first video."""
        height, width, _ = next(iter(self._videos.values())).shape
        return width, height

    def decode_rgb(self, entry: Entry) -> Rgb:
        """Decode the frame of the video that an entry is called after."""
        for path, video in self._videos.items():
            if path != entry.rgb:
                video.close()
        return self._videos[entry.rgb].read(int(entry.id.rpartition("/")[2]))


def _camera(folder: Path, size: Size, entries: Sequence[Entry]) -> Camera:
    """Return the intrinsics of the video; `DataError` where nothing tells them."""
    found = read_intrinsics(folder / CAMERA_FILE)
    if found is not None:
        known = found.size or centred_size(found.cx, found.cy, (size, PHONE_SIZE))
        return scaled_camera(found.camera(known), size)
    camera = next((entry.camera for entry in entries if entry.camera is not None), None)
    if camera is None:
        raise DataError(folder, f"has no {CAMERA_FILE} of 3x3 numbers", "copy it from the phone")
    return camera


def _read_odometry(path: Path, size: Size) -> dict[int, Row]:
    """Map frame numbers to what the table says of them; `DataError` for another table."""
    try:
        table = csv.reader(io.StringIO(read_text(path, "utf-8-sig"), newline=""))
        lines = [[cell.strip() for cell in line] for line in table if line]
    except (OSError, ValueError, csv.Error) as error:
        raise DataError(path, f"cannot be read as a table ({error})", "replace the file") from None
    names = [name.lower() for name in lines[0]] if lines else []
    if not set(POSE_COLUMNS) <= set(names):
        found = f'has the columns "{", ".join(names)[:80]}"'
        raise DataError(path, found, f"expected a header with {', '.join(POSE_COLUMNS)}")
    rows: dict[int, Row] = {}
    for place, line in enumerate(lines[1:]):
        values = {name: _number(cell) for name, cell in zip(names, line, strict=False)}
        frame = values.get("frame", np.nan)
        rows.setdefault(int(frame) if np.isfinite(frame) else place, _row(values, size))
    return rows


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _row(values: dict[str, float], size: Size) -> Row:
    seconds = values.get("timestamp", np.nan)
    pixels = [values.get(name, np.nan) for name in CAMERA_COLUMNS]
    known = pixels_of_numbers(pixels) if np.isfinite(pixels).all() else None
    camera = None
    if known is not None:
        of_size = centred_size(known[2], known[3], (size, PHONE_SIZE))
        camera = scaled_camera(Camera(*of_size, *known), size)
    return Row(
        _pose([values.get(name, np.nan) for name in POSE_COLUMNS]),
        round(seconds * NS_PER_SECOND) if 0 <= seconds < MAX_SECONDS else None,
        camera,
    )


def _pose(numbers: list[float]) -> Pose | None:
    """Return camera to world of x y z qx qy qz qw; None where these are no pose."""
    if not np.isfinite(numbers).all() or not 0.9 < np.linalg.norm(numbers[3:]) < 1.1:
        return None
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(numbers[3:])
    pose[:3, 3] = numbers[:3]
    return pose
