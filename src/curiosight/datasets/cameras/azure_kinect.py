"""The calibration that an Azure Kinect, or a Femto in its place, stores with its recordings."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose, is_rigid

COLOUR, DEPTH = "CameraLocationPV0", "CameraLocationD0"
# Calibration is for the whole sensor, divided by its size. For each size of images: what the
# sensor is binned to, and the corner that is cut out of that.
DEPTH_MODES = {
    (320, 288): ((512, 512), (96, 90)),
    (640, 576): ((1024, 1024), (192, 180)),
    (512, 512): ((512, 512), (0, 0)),
    (1024, 1024): ((1024, 1024), (0, 0)),
}
MIN_DISTORTION = 1e-6
MAX_METRES = 1.0
Size = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """A camera, and how its lens bends lines: OpenCV's eight numbers; None = it does not."""

    camera: Camera
    distortion: npt.NDArray[np.float64] | None
    T_camera_rig: Pose

    def straightened(self, image: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return what a pinhole of the same intrinsics would show; depth by the nearest reading."""
        if self.distortion is None:
            return image
        camera = self.camera
        K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]])
        size = camera.width, camera.height
        u, v = cv2.initUndistortRectifyMap(K, self.distortion, None, K, size, cv2.CV_32FC1)  # type: ignore[call-overload]
        how = cv2.INTER_LINEAR if image.ndim == 3 else cv2.INTER_NEAREST
        straight: npt.NDArray[Any] = cv2.remap(image, u, v, how, borderValue=0)
        return straight


def read_calibration(content: bytes, colour: Size, depth: Size) -> tuple[Lens, Lens] | None:
    """Return the lenses of colour and depth of (width, height); None where it is no calibration."""
    try:
        told = json.loads(content.rstrip(b"\0"))
        cameras = told["CalibrationInformation"]["Cameras"]
        by_place = {str(one["Location"]).rpartition("_")[2]: one for one in cameras}
        lenses = (
            _lens(by_place[COLOUR], colour, *_colour_mode(colour)),
            _lens(by_place[DEPTH], depth, *DEPTH_MODES.get(depth, (depth, (0, 0)))),
        )
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError):
        return None
    return lenses


def _colour_mode(size: Size) -> tuple[Size, Size]:
    """Return the whole of the sensor, which is 4:3, and what a wider image leaves out above."""
    whole = size[0], max(size[1], round(size[0] * 3 / 4))
    return whole, (0, (whole[1] - size[1]) // 2)


def _lens(told: dict[str, Any], size: Size, whole: Size, corner: Size) -> Lens:
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = map(
        float, told["Intrinsics"]["ModelParameters"][:14]
    )
    camera = Camera(
        *size,
        fx * whole[0],
        fy * whole[1],
        cx * whole[0] - corner[0] - 0.5,
        cy * whole[1] - corner[1] - 0.5,
    )
    distortion = np.array([k1, k2, p1, p2, k3, k4, k5, k6])
    pose = np.eye(4)
    pose[:3, :3] = np.reshape(np.asarray(told["Rt"]["Rotation"], float), (3, 3))
    pose[:3, 3] = told["Rt"]["Translation"]
    if np.abs(pose[:3, 3]).max() > MAX_METRES:
        pose[:3, 3] /= 1000
    if not is_rigid(pose):
        raise ValueError("Rt: expected a rotation and a translation")
    is_bent = bool((np.abs(distortion) > MIN_DISTORTION).any())
    return Lens(camera, distortion if is_bent else None, pose)
