"""Frames of ray-cast scenes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame, Pose
from curiosight.learner.features import shrink
from room import ROOM, Box, View, kinect, look, render

WALL = Box((0.0, 3.0, 1.25), (12.0, 0.2, 2.5), (190, 190, 170), is_salient=False)
TABLE_TOP = Box((0.0, 0.2, 0.70), (1.20, 0.80, 0.04), (150, 110, 60), is_salient=False)
ON_TABLE = Box((0.15, 0.2, 0.80), (0.16, 0.12, 0.16), (200, 40, 40))
ON_FLOOR = Box((-1.0, 0.6, 0.15), (0.25, 0.25, 0.30), (40, 80, 200))
CAMERA = kinect(640, 480)


def kinect_noise(
    depth: npt.NDArray[np.float32], rng: np.random.Generator, step: float = 0.0028
) -> npt.NDArray[np.float32]:
    """Add the noise of a Kinect's disparity: half a step of inverse depth (1/m)."""
    noisy = 1 / (1 / depth + rng.normal(0, step / 2, depth.shape))
    return np.asarray(noisy, np.float32)


@lru_cache(maxsize=32)
def _view(boxes: tuple[Box, ...], *look_from: float) -> View:
    return render(CAMERA, _pose(*look_from), boxes)


def _pose(heading_deg: float, distance: float, height: float, tilt_deg: float) -> Pose:
    return look(heading_deg, distance=distance, height=height, tilt_deg=tilt_deg)


def see(
    boxes: tuple[Box, ...] = ROOM,
    *,
    heading_deg: float = 0.0,
    distance: float = 1.9,
    height: float = 1.0,
    tilt_deg: float = 25.0,
    with_pose: bool = False,
) -> tuple[Frame, View]:
    """Return a 640x480 frame without noise, and what is where in it."""
    look_from = (heading_deg, distance, height, tilt_deg)
    view = _view(boxes, *look_from)
    return as_frame(view, CAMERA, _pose(*look_from) if with_pose else None), view


def as_frame(view: View, camera: Camera, T_world_camera: Pose | None = None) -> Frame:
    """Return a view as a frame, depth copied."""
    return Frame("view", view.rgb, view.depth.copy(), camera, T_world_camera)


def photograph() -> npt.NDArray[np.uint8]:
    """Return a room with the noise of a sensor, at the working size."""
    rgb = shrink(see()[0].rgb).astype(np.int64)
    noise = np.random.default_rng(0).normal(0, 4, rgb.shape)
    return np.clip(rgb + noise, 0, 255).astype(np.uint8)
