"""The depth camera beside the colour camera, for depth that is not registered to colour."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.cameras.intrinsics import read_camera_and_pose
from curiosight.datasets.cameras.registration import covered_window, register_depth
from curiosight.errors import DataError
from curiosight.frame import Camera, Depth, Pose

EXAMPLE = (
    'give "width", "height", "fx", "fy", "cx", "cy" of the depth camera and "T_colour_depth", '
    "4 rows of 4 numbers, metres: from the depth camera's axes to the colour camera's"
)


@dataclass(frozen=True, slots=True, eq=False)
class DepthCamera:
    """Intrinsics of the depth images, and where their camera is.

    T_colour_depth: (4, 4) from the depth camera's axes to the colour camera's, metres.
    has_the_poses: the recording's poses are of this camera rather than the colour camera.
    """

    camera: Camera
    T_colour_depth: Pose
    has_the_poses: bool = False

    def registered(self, depth: Depth, colour_camera: Camera) -> Depth:
        """Return (H, W) what the colour camera would have measured of (h, w) depth, metres."""
        camera = scaled_camera(self.camera, (depth.shape[1], depth.shape[0]))
        return register_depth(depth, camera, colour_camera, self.T_colour_depth)


def read_depth_camera(path: Path, size: tuple[int, int] | None) -> DepthCamera:
    """Read a depth camera from a file; raises `DataError` where it does not hold one.

    size: (width, height) of the depth images, for files that do not say it; None = not known.
    """
    camera, T_colour_depth = read_camera_and_pose(path, size)
    if T_colour_depth is None:
        raise DataError(path, "does not say where the depth camera is", EXAMPLE)
    return DepthCamera(camera, T_colour_depth)


def with_window(path: Path, camera: Camera, depth_camera: DepthCamera) -> Camera:
    """Add what the depth camera covers of the colour image, unless a window is given.

    Raises `DataError` where the two have no view in common.
    """
    if camera.depth_window is not None:
        return camera
    window = covered_window(depth_camera.camera, camera, depth_camera.T_colour_depth)
    try:
        return replace(camera, depth_window=window)
    except ValueError as error:
        found = f"its colour and depth cameras have no view in common ({error})"
        raise DataError(path, found, "correct the files of the cameras") from None
