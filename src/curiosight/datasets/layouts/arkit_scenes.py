"""Read ARKitScenes (Apple): lowres_wide/ID_stamp.png, lowres_depth/, lowres_wide.traj."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.cameras.intrinsics import pixels_of_numbers
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.scans import Scan, Scans, remark_on_poses, with_depth
from curiosight.datasets.sizes import image_size
from curiosight.datasets.trajectory import Trajectory, parse_stamp, table_rows
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text
from curiosight.frame import Camera, Pose
from curiosight.frame.rotations import matrix_of, quaternion_about

COLOUR, DEPTH, CONFIDENCE = "lowres_wide", "lowres_depth", "confidence"
CAMERAS, POSES = "lowres_wide_intrinsics", "lowres_wide.traj"
# Names are cut to milliseconds, so that one moment has names a millisecond apart.
SAME_MOMENT_NS = 2_000_000
# Poses come at 10 Hz; a hand moves little beyond their first and last.
MAX_GAP_NS = 250_000_000
MAX_BEYOND_NS = 20_000_000


class ArkitScenes(Scans):
    """A video of ARKitScenes, or a folder of them.

    Pictures are as the phone was held: which way is up, their poses tell.
    """

    name = "ARKitScenes"
    evidence = f"{COLOUR}/ID_stamp.png with {DEPTH}/ and {CAMERAS}/"
    levels = 2

    @staticmethod
    def holds_scan(folder: Path) -> bool:
        """Tell whether the folder holds the images and their intrinsics."""
        return all((folder / name).is_dir() for name in (COLOUR, DEPTH, CAMERAS))

    def read_scan(self, folder: Path) -> Scan:
        """List the colour images that have depth of the same moment."""
        remarks: list[str] = []
        colour = _by_stamp(folder / COLOUR, ".png")
        depth = _of_moments(colour, _by_stamp(folder / DEPTH, ".png"))
        confidence = _of_moments(colour, _by_stamp(folder / CONFIDENCE, ".png"))
        stamps = with_depth(colour, depth, folder, remarks)
        size = image_size(folder, [colour[stamp] for stamp in stamps])
        files = _of_moments(colour, _by_stamp(folder / CAMERAS, ".pincam"))
        cameras = [_read_camera(files.get(stamp)) for stamp in stamps]
        usual = next((camera for camera in cameras if camera is not None), None)
        if usual is None:
            raise DataError(folder / CAMERAS, "tells the camera of no image", "download it again")
        poses = _poses(folder / POSES, stamps)
        entries = []
        for stamp, camera, pose in zip(stamps, cameras, poses, strict=True):
            usual = camera or usual
            entries.append(
                Entry(
                    colour[stamp].stem,
                    colour[stamp],
                    depth[stamp],
                    pose,
                    stamp,
                    confidence=confidence.get(stamp),
                    camera=usual,
                )
            )
        remark_on_poses(entries, remarks)
        assert entries[0].camera is not None
        return Scan(entries, scaled_camera(entries[0].camera, size), remarks=remarks)


def _by_stamp(folder: Path, ending: str) -> dict[int, Path]:
    """Map the stamps in names, nanoseconds, to the files of a folder, in order of time."""
    files = {}
    for path in folder.glob(f"*{ending}"):
        try:
            files[parse_stamp(path.name.removesuffix(ending).rpartition("_")[2])] = path
        except ValueError:
            continue
    return dict(sorted(files.items()))


def _of_moments(wanted: Mapping[int, Path], files: Mapping[int, Path]) -> dict[int, Path]:
    """Map stamps that are wanted to the file nearest in time, where it is of that moment."""
    if not files:
        return {}
    stamps, moments = np.array(list(files)), np.array(list(wanted), np.int64)
    after = np.searchsorted(stamps, moments).clip(max=len(stamps) - 1)
    before = (after - 1).clip(min=0)
    is_before = np.abs(stamps[before] - moments) < np.abs(stamps[after] - moments)
    nearest = stamps[np.where(is_before, before, after)]
    return {
        int(moment): files[int(stamp)]
        for moment, stamp in zip(moments, nearest, strict=True)
        if abs(int(stamp) - int(moment)) <= SAME_MOMENT_NS
    }


def _read_camera(path: Path | None) -> Camera | None:
    """Read a line of width, height, fx, fy, cx, cy; None where there is none."""
    try:
        words = [] if path is None else read_text(path).split()
        width, height, *pixels = (float(word) for word in words)
        known = pixels_of_numbers(pixels)
        return None if known is None else Camera(int(width), int(height), *known)
    except (OSError, ValueError, OverflowError):
        return None


def _poses(path: Path, stamps: list[int]) -> list[Pose | None]:
    if not path.is_file():
        return [None] * len(stamps)
    trajectory = _read_trajectory(path)
    first, last = int(trajectory.stamps_ns[0]), int(trajectory.stamps_ns[-1])
    kept = [min(max(stamp, first), last) for stamp in stamps]
    near = [
        held if abs(held - stamp) <= MAX_BEYOND_NS else stamp
        for held, stamp in zip(kept, stamps, strict=True)
    ]
    return trajectory.interpolated(near, max_gap_ns=MAX_GAP_NS)


def _read_trajectory(path: Path) -> Trajectory:
    """Read lines of stamp, axis times angle, position, world to camera; turn them round."""
    stamps, rows = [], []
    for number, words in table_rows(path):
        try:
            stamp, *numbers = words
            rows.append(np.array(numbers, np.float64).reshape(6))
            stamps.append(parse_stamp(stamp))
        except ValueError:
            found = f'line {number} is "{" ".join(words)[:60]}"'
            expected = "expected: stamp, three numbers of rotation, three of position"
            raise DataError(path, found, expected) from None
    if not stamps:
        raise DataError(path, "holds no poses", "fill it or delete it")
    order = np.argsort(stamps, kind="stable")
    values = np.array(rows)[order]
    is_pose = np.isfinite(values).all(axis=1, keepdims=True)
    to_world = quaternion_about(np.where(is_pose, -values[:, :3], 0.0))
    positions = -np.einsum("nij,nj->ni", matrix_of(to_world), values[:, 3:])
    quaternions = np.where(is_pose, to_world, np.nan)
    return Trajectory(np.array(stamps, np.int64)[order], positions, quaternions)
