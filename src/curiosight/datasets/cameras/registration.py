"""Register depth to the colour image: what the colour camera would have measured."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Camera, Depth, Pose

# Widens the footprint of a depth pixel on each side, in colour pixels. Neighbours on a slanted
# surface differ by one or two quantisation steps of the sensor, each of which moves them apart
# by 0.04 px (7-Scenes), and the background must not show between them.
FOOTPRINT_MARGIN_PX = 0.1


def register_depth(
    depth: Depth, depth_camera: Camera, colour_camera: Camera, T_colour_depth: Pose
) -> Depth:
    """Return depth as seen from the colour camera, (H, W) float32 metres, NaN = no reading.

    depth: (H, W) float32 metres in the depth camera, NaN = no reading. The nearest surface
    wins, and each depth pixel covers all colour pixels that it reaches over.
    """
    if depth.shape != (depth_camera.height, depth_camera.width) or depth.dtype != np.float32:
        raise ValueError(
            f"depth: expected ({depth_camera.height}, {depth_camera.width}) float32 metres, "
            f"got {depth.shape} {depth.dtype}"
        )
    homography, epipole = _transfer(depth_camera, colour_camera, T_colour_depth)
    half_u = 0.5 * colour_camera.fx / depth_camera.fx
    half_v = 0.5 * colour_camera.fy / depth_camera.fy
    registered = np.full((colour_camera.height, colour_camera.width), np.inf, np.float32)
    _splat(depth, homography, epipole, half_u, half_v, FOOTPRINT_MARGIN_PX, registered)
    registered[np.isinf(registered)] = np.nan
    return registered


def covered_window(
    depth_camera: Camera,
    colour_camera: Camera,
    T_colour_depth: Pose,
    *,
    near: float = 1.0,
    far: float = 4.0,
) -> tuple[int, int, int, int]:
    """Return the part of the colour image that the depth camera covers at every distance.

    The depth camera's own `depth_window` (else its whole image) is cast into the colour image
    from `near` to `far` metres; the answer is the rectangle common to all of them, (u_min,
    v_min, u_max, v_max) with exclusive ends.
    """
    u_min, v_min, u_max, v_max = depth_camera.depth_window or (
        (0, 0, depth_camera.width, depth_camera.height)
    )
    homography, epipole = _transfer(depth_camera, colour_camera, T_colour_depth)
    corners = np.array([[u, v, 1.0] for v in (v_min, v_max) for u in (u_min, u_max)])
    corners[:, :2] -= 0.5
    cast = np.stack([z * corners @ homography.T + epipole for z in (near, far)])
    u, v = cast[..., 0] / cast[..., 2], cast[..., 1] / cast[..., 2]
    return (
        max(0, math.ceil(u[:, [0, 2]].max())),
        max(0, math.ceil(v[:, [0, 1]].max())),
        min(colour_camera.width, math.floor(u[:, [1, 3]].min()) + 1),
        min(colour_camera.height, math.floor(v[:, [2, 3]].min()) + 1),
    )


def _transfer(
    depth_camera: Camera, colour_camera: Camera, T_colour_depth: Pose
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return A (3, 3) and b (3,): depth pixel p at z lands on z A p + b, homogeneous."""
    colour = _matrix(colour_camera)
    homography = colour @ T_colour_depth[:3, :3] @ np.linalg.inv(_matrix(depth_camera))
    return homography, colour @ T_colour_depth[:3, 3]


def _matrix(camera: Camera) -> npt.NDArray[np.float64]:
    return np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]])


@njit(cache=True, nogil=True)
def _splat(
    depth: npt.NDArray[np.float32],
    homography: npt.NDArray[np.float64],
    epipole: npt.NDArray[np.float64],
    half_u: float,
    half_v: float,
    margin: float,
    registered: npt.NDArray[np.float32],
) -> None:
    """Draw every depth pixel into `registered`, which starts as infinity; the nearest wins.

    half_u, half_v: half a depth pixel's size in the colour image, seen from the same distance.
    """
    last_column, last_row = registered.shape[1] - 1, registered.shape[0] - 1
    step_u, step_v, step_z = homography[0, 0], homography[1, 0], homography[2, 0]
    shift_u, shift_v, shift_z = epipole[0], epipole[1], epipole[2]
    for v in range(depth.shape[0]):
        row_u = homography[0, 1] * v + homography[0, 2]
        row_v = homography[1, 1] * v + homography[1, 2]
        row_z = homography[2, 1] * v + homography[2, 2]
        for u in range(depth.shape[1]):
            z = depth[v, u]
            colour_z = z * (step_z * u + row_z) + shift_z
            if not (z > 0 and colour_z > 0):
                continue
            scale = 1.0 / colour_z
            centre_u = (z * (step_u * u + row_u) + shift_u) * scale
            centre_v = (z * (step_v * u + row_v) + shift_v) * scale
            reach_u = half_u * z * scale + margin
            reach_v = half_v * z * scale + margin
            left = max(math.ceil(centre_u - reach_u), 0)
            right = min(math.floor(centre_u + reach_u), last_column)
            top = max(math.ceil(centre_v - reach_v), 0)
            bottom = min(math.floor(centre_v + reach_v), last_row)
            if left <= right and top <= bottom:
                _draw(registered, left, right, top, bottom, np.float32(colour_z))


@njit(cache=True, nogil=True)
def _draw(
    registered: npt.NDArray[np.float32],
    left: int,
    right: int,
    top: int,
    bottom: int,
    z: np.float32,
) -> None:
    """Lower `registered` to `z` in a rectangle, ends included."""
    if right - left <= 1 and bottom - top <= 1:
        # Nearly always. Its corners, though often the same pixel, cost less than loops of
        # unforeseeable length.
        registered[top, left] = min(registered[top, left], z)
        registered[top, right] = min(registered[top, right], z)
        registered[bottom, left] = min(registered[bottom, left], z)
        registered[bottom, right] = min(registered[bottom, right], z)
        return
    for row in range(top, bottom + 1):
        for column in range(left, right + 1):
            registered[row, column] = min(registered[row, column], z)
