"""What a camera gives: frames, intrinsics, viewpoints; and the four labels of a pixel."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

Rgb = npt.NDArray[np.uint8]
Depth = npt.NDArray[np.float32]
Pose = npt.NDArray[np.float64]

# How a camera is held: to which side of its image up points, or "towards" the camera, which then
# looks straight down, or "away" from it.
Mount = Literal["up", "down", "left", "right", "towards", "away"]
MOUNTS: tuple[Mount, ...] = get_args(Mount)
# A pose farther from the world's origin is a slip of the pen or of an estimate, metres.
MAX_AWAY = 10_000.0
# Fused trajectories are written with few digits: 7-Scenes' are off by 4e-4.
RIGID_TOLERANCE = 1e-2


class Label(IntEnum):
    """Grey code of a pixel in the teacher's mask (sec. II-A.2)."""

    NOT_SALIENT = 0
    UNAVAILABLE = 75
    UNKNOWN = 125
    SALIENT = 255


# As red, green, blue: told apart by lightness as well as by hue, so that no kind of colour vision
# is needed.
LABEL_COLOURS: dict[Label, tuple[int, int, int]] = {
    Label.SALIENT: (0, 200, 140),
    Label.NOT_SALIENT: (30, 70, 150),
    Label.UNKNOWN: (150, 150, 150),
    Label.UNAVAILABLE: (20, 20, 20),
}


@dataclass(frozen=True, slots=True)
class Camera:
    """Intrinsics of a pinhole camera, in pixels.

    `depth_window` is the part of the image that the depth sensor's full rectangle covers,
    (u_min, v_min, u_max, v_max) with exclusive ends, inside the image and not empty; None
    where it is the whole image.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    depth_window: tuple[int, int, int, int] | None = None

    def __post_init__(self) -> None:
        for name in ("width", "height", "fx", "fy"):
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name}: expected a positive number, got {getattr(self, name)}")
        if not (np.isfinite(self.cx) and np.isfinite(self.cy)):
            raise ValueError(f"cx, cy: expected finite pixels, got {self.cx}, {self.cy}")
        if self.depth_window is None:
            return
        u_min, v_min, u_max, v_max = self.depth_window
        if not (0 <= u_min < u_max <= self.width and 0 <= v_min < v_max <= self.height):
            raise ValueError(
                "depth_window: expected u_min < u_max and v_min < v_max inside the "
                f"{self.width}x{self.height} image, got {self.depth_window}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One look of the camera.

    rgb: (H, W, 3) uint8, red first.
    depth: (H, W) float32 metres along z, registered to `rgb`, NaN = no reading; None where
        the source has no depth at all.
    camera: intrinsics of the colour image; None only where `depth` is None.
    T_world_camera: (4, 4) pose of the colour camera, camera points to world; None = unknown.
    problem: why this frame cannot teach (an unreadable file, say), in words; None = nothing
        is wrong. What could not be read is black in `rgb` and NaN in `depth`.
    """

    id: str
    rgb: Rgb
    depth: Depth | None = None
    camera: Camera | None = None
    T_world_camera: Pose | None = None
    stamp_ns: int | None = None
    problem: str | None = None

    def __post_init__(self) -> None:
        rgb = self.rgb
        if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8:
            raise ValueError(f"rgb: expected (H, W, 3) uint8, got {rgb.shape} {rgb.dtype}")
        _check_pose(self.T_world_camera)
        if self.depth is None:
            return
        size = rgb.shape[:2]
        if self.depth.shape != size or self.depth.dtype != np.float32:
            raise ValueError(
                f"depth: expected {size} float32 metres, got {self.depth.shape} {self.depth.dtype}"
            )
        if self.camera is None:
            raise ValueError("camera: expected intrinsics beside depth, got None")
        if (self.camera.height, self.camera.width) != size:
            raise ValueError(
                f"camera: expected {size[1]}x{size[0]} like the image, "
                f"got {self.camera.width}x{self.camera.height}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Viewpoint:
    """A place to look from: the world's number for it, its region, its pose if known."""

    index: int
    region: int
    T_world_camera: Pose | None = None


def is_rigid(pose: Pose) -> bool:
    """Tell whether a matrix is a finite (4, 4) rotation and translation, of at most 10 km."""
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        return False
    rotation = pose[:3, :3]
    if np.abs(pose[:3, 3]).max() > MAX_AWAY:
        return False
    is_orthonormal = np.abs(rotation.T @ rotation - np.eye(3)).max() < RIGID_TOLERANCE
    is_affine = np.abs(pose[3] - [0, 0, 0, 1]).max() < RIGID_TOLERANCE
    return bool(is_orthonormal and is_affine and np.linalg.det(rotation) > 0)


def _check_pose(pose: Pose | None) -> None:
    if pose is None:
        return
    if np.shape(pose) != (4, 4):
        raise ValueError(f"T_world_camera: expected (4, 4), got {np.shape(pose)}")
    if not np.isfinite(pose).all():
        raise ValueError("T_world_camera: expected finite numbers, got NaN or infinity")
