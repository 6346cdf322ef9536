"""Turn a frame upright by quarter turns, and what was found in it back.

Much of what is said about an image goes by its rows: feet end downwards, a table's top is seen in
few rows. A camera on its side or upside down is looked at as if it were held upright.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame
from curiosight.teacher.cloud.planes import Plane
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.segmented import Segmentation
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.things.verdicts import Cluster

Array = npt.NDArray[Any]
# From the camera's axes to those of the camera that sees the image turned once: x to the right
# is y upwards then.
_ONCE = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


class _Segments(Protocol):
    def segment(self, frame: Frame) -> Segmentation: ...


def turns_upright(up: Array) -> int:
    """Return how many quarter turns, against the clock, let `up` point up in the image.

    up: (3,) in the camera's frame. None are made where it points along the view.
    """
    x, y = float(up[0]), float(up[1])
    if np.hypot(x, y) < 1e-6 or -y >= abs(x) - 1e-9:
        return 0
    if y > abs(x) + 1e-9:
        return 2
    return 1 if x > 0 else 3


def rotation_of(n_turns: int) -> Array:
    """Return (3, 3) from the camera's axes to those of the camera of the turned image."""
    return np.linalg.matrix_power(_ONCE, n_turns % 4)


def turn_frame(frame: Frame, n_turns: int) -> Frame:
    """Return what a camera turned about its axis would have seen, with depth and camera."""
    if n_turns % 4 == 0 or frame.depth is None or frame.camera is None:
        return frame
    pose = frame.T_world_camera
    if pose is not None:
        pose = pose.copy()
        pose[:3, :3] = pose[:3, :3] @ rotation_of(n_turns).T
    return replace(
        frame,
        rgb=np.rot90(frame.rgb, n_turns),
        depth=np.ascontiguousarray(np.rot90(frame.depth, n_turns)),
        camera=_turn_camera(frame.camera, n_turns % 4),
        T_world_camera=pose,
    )


def _turn_camera(camera: Camera, n_turns: int) -> Camera:
    for _ in range(n_turns):
        window = camera.depth_window
        if window is not None:
            u_min, v_min, u_max, v_max = window
            window = v_min, camera.width - u_max, v_max, camera.width - u_min
        camera = Camera(
            camera.height,
            camera.width,
            camera.fy,
            camera.fx,
            camera.cy,
            camera.width - 1 - camera.cx,
            window,
        )
    return camera


def turn_segmentation(found: Segmentation, n_turns: int) -> Segmentation:
    """Return what was found as if the image had been turned afterwards."""
    if n_turns % 4 == 0:
        return found
    size = found.labels.shape[1], found.labels.shape[0]
    return replace(
        found.with_images(lambda image: np.ascontiguousarray(np.rot90(image, n_turns))),
        clusters=tuple(_turn_cluster(one, size, n_turns % 4) for one in found.clusters),
        supports=tuple(_turn_support(one, n_turns) for one in found.supports),
        walls=tuple(_turn_wall(one, n_turns) for one in found.walls),
        n_turns=(found.n_turns - n_turns) % 4,
    )


def _turn_cluster(cluster: Cluster, size: tuple[int, int], n_turns: int) -> Cluster:
    """size: width and height of the image before."""
    (u_min, v_min, u_max, v_max), (width, height) = cluster.box, size
    for _ in range(n_turns):
        u_min, v_min, u_max, v_max = v_min, width - u_max, v_max, width - u_min
        width, height = height, width
    return replace(cluster, box=(u_min, v_min, u_max, v_max))


def _turn_support(support: Support, n_turns: int) -> Support:
    plane = support.plane
    normal = rotation_of(n_turns) @ plane.normal
    masks = support.extent, support.core, support.skirt
    extent, core, skirt = (None if mask is None else np.rot90(mask, n_turns) for mask in masks)
    return replace(
        support,
        plane=Plane(normal, plane.offset, np.rot90(plane.inliers, n_turns)),
        heights=np.rot90(support.heights, n_turns),
        extent=extent,
        core=core,
        skirt=skirt,
    )


def _turn_wall(wall: Wall, n_turns: int) -> Wall:
    rotation = rotation_of(n_turns)
    return replace(
        wall,
        normal=rotation @ wall.normal,
        inliers=np.rot90(wall.inliers, n_turns),
        axes=rotation @ wall.axes,
    )


class TurnedTeacher:
    """A teacher of upright images, for a camera that is held on its side or upside down.

    n_turns: quarter turns, against the clock, after which its images are upright.
    """

    def __init__(self, teacher: _Segments, n_turns: int) -> None:
        self.teacher = teacher
        self.n_turns = n_turns

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel as the teacher does in the upright image."""
        if frame.depth is None or frame.camera is None:
            return self.teacher.segment(frame)
        found = self.teacher.segment(turn_frame(frame, self.n_turns))
        return turn_segmentation(found, -self.n_turns)
