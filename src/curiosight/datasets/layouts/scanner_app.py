"""Read exports of 3D Scanner App (iPhone, iPad): frame_N.jpg, frame_N.json, depth_N.png."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.datasets.cameras.intrinsics import pixels_of_numbers
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.scans import Scan, Scans, numbered, remark_on_poses, with_depth
from curiosight.datasets.sizes import Size, image_size
from curiosight.errors import DataError
from curiosight.errors.inputs import read_json_object
from curiosight.frame import Camera, Pose, is_rigid

POSE_KEY, CAMERA_KEY, TIME_KEY = "cameraPoseARFrame", "intrinsics", "time"
# ARKit's camera axes are right, up, backward.
AXES_ARKIT = np.diag([1.0, -1.0, -1.0, 1.0])
N_LOOKED_AT = 5
NS_PER_SECOND = 1e9
MAX_SECONDS = 1e9


@dataclass(frozen=True, slots=True)
class View:
    """What `frame_N.json` says; None where it does not."""

    camera: Camera | None
    T_world_camera: Pose | None
    stamp_ns: int | None


class ScannerApp(Scans):
    """An export of 3D Scanner App, or a folder of them; its intrinsics change as it focuses."""

    name = "3D Scanner App"
    evidence = f"frame_N.json with {POSE_KEY}, depth_N.png"

    @staticmethod
    def holds_scan(folder: Path) -> bool:
        """Tell whether there are depth images, and JSON that tells the camera of a frame."""
        if not any(folder.glob("depth_*.png")):
            return False
        files = itertools.islice(folder.glob("frame_*.json"), N_LOOKED_AT)
        return any({POSE_KEY, CAMERA_KEY} <= read_json_object(file).keys() for file in files)

    def read_scan(self, folder: Path) -> Scan:
        """List the frames that have depth."""
        remarks: list[str] = []
        colour = numbered(p for e in ("jpg", "jpeg", "png") for p in folder.glob(f"frame_*.{e}"))
        depth = numbered(folder.glob("depth_*.png"))
        confidence = numbered(folder.glob("conf_*.png"))
        about = numbered(folder.glob("frame_*.json"))
        numbers = with_depth(colour, depth, folder, remarks)
        size = image_size(folder, [colour[number] for number in numbers])
        views = [_view(about.get(number), size) for number in numbers]
        cameras = [view.camera for view in views]
        usual = next((camera for camera in cameras if camera is not None), None)
        if usual is None:
            found = f"no {CAMERA_KEY} of 3x3 numbers in any frame_N.json"
            raise DataError(folder, found, "export the scan again, with all data")
        if None in cameras:
            remarks.append(f"{cameras.count(None)} frames have no {CAMERA_KEY}: a near one's stand")
        entries = []
        for number, view in zip(numbers, views, strict=True):
            usual = view.camera or usual
            entries.append(
                Entry(
                    colour[number].stem,
                    colour[number],
                    depth[number],
                    view.T_world_camera,
                    view.stamp_ns,
                    confidence=confidence.get(number),
                    camera=usual,
                )
            )
        remark_on_poses(entries, remarks)
        assert entries[0].camera is not None
        return Scan(entries, entries[0].camera, remarks=remarks)


def _view(path: Path | None, size: Size) -> View:
    content = {} if path is None else read_json_object(path)
    pixels = pixels_of_numbers(_numbers(content.get(CAMERA_KEY), 9))
    pose = _pose(_numbers(content.get(POSE_KEY), 16))
    seconds = _numbers([content.get(TIME_KEY)], 1)
    has_time = bool(seconds) and 0 <= seconds[0] < MAX_SECONDS
    return View(
        Camera(*size, *pixels) if pixels else None,
        pose,
        round(seconds[0] * NS_PER_SECOND) if has_time else None,
    )


def _numbers(values: Any, n_values: int) -> list[float]:
    """Return so many numbers, which may stand in rows; empty where these are none."""
    try:
        numbers = np.asarray(values, np.float64).ravel()
    except (TypeError, ValueError, OverflowError):
        return []
    return numbers.tolist() if len(numbers) == n_values else []


def _pose(numbers: list[float]) -> Pose | None:
    if not numbers:
        return None
    pose = np.reshape(numbers, (4, 4)) @ AXES_ARKIT
    return pose if is_rigid(pose) else None
