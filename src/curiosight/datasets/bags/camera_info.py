"""From CameraInfo to the pinhole camera of the images as they were published."""

from __future__ import annotations

from typing import Any

import numpy as np

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.sizes import has_shape_of
from curiosight.frame import Camera

CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
# Distortion that moves nothing by a pixel.
MIN_DISTORTION = 1e-6


def to_camera(info: Any, size: tuple[int, int], *, is_rectified: bool) -> Camera | None:
    """Return the intrinsics of images of (width, height); None where the message holds none.

    is_rectified: the images are, so P holds; else K. Both are of the sensor's whole image: what
    binning and the region of interest took away is taken away here, unless the images have the
    whole size. Intrinsics for another size of the same shape are scaled.
    """
    raw, projected = (_matrix(info, name) for name in ("K", "P"))
    K = projected if is_rectified and projected[0, 0] > 0 else raw
    if not K[0, 0] > 0:
        K = projected
    fx, fy, cx, cy = (float(K[place]) for place in ((0, 0), (1, 1), (0, 2), (1, 2)))
    whole = int(info.width) or size[0], int(info.height) or size[1]
    try:
        camera = Camera(*whole, fx, fy, cx, cy)
        if size != whole:
            camera = _of_part(camera, info, size)
    except ValueError:
        return None
    is_alike = has_shape_of((camera.width, camera.height), size)
    return scaled_camera(camera, size) if is_alike else camera


def is_distorted(info: Any) -> bool:
    """Tell whether a message says that lines are not straight in its raw images."""
    terms = np.asarray(_field(info, "D"), np.float64)
    return bool((np.abs(terms) > MIN_DISTORTION).any())


def _of_part(camera: Camera, info: Any, size: tuple[int, int]) -> Camera:
    """Return the camera of a region of interest, binned, as ROS defines them."""
    roi = info.roi
    width, height = int(roi.width) or camera.width, int(roi.height) or camera.height
    bin_u, bin_v = max(1, int(info.binning_x)), max(1, int(info.binning_y))
    binned = width // bin_u, height // bin_v
    if binned != size and not has_shape_of(binned, size):
        return camera
    return Camera(
        *binned,
        camera.fx / bin_u,
        camera.fy / bin_v,
        (camera.cx - int(roi.x_offset)) / bin_u,
        (camera.cy - int(roi.y_offset)) / bin_v,
    )


def _matrix(info: Any, name: str) -> Any:
    """Return the 3x3 part of K or P."""
    values = np.asarray(_field(info, name), np.float64)
    return values.reshape(3, -1)[:, :3]


def _field(info: Any, name: str) -> Any:
    """Return a field that ROS 1 writes in capitals."""
    return getattr(info, name, None) if hasattr(info, name) else getattr(info, name.lower())
