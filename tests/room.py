"""A small room that is ray-cast exactly: a floor, a wall, coloured boxes. World axes: z up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose

Array = npt.NDArray[np.float64]
FLOOR_COLOUR = (120, 110, 95)
FAR_METRES = 12.0
# So many rays are cast at once that what is known of them stays in the cache.
BAND_PIXELS = 1 << 14


@dataclass(frozen=True)
class Box:
    """An axis-aligned box; the salient ones are objects, the others walls."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    colour: tuple[int, int, int]
    is_salient: bool = True


ROOM = (
    Box((0.0, 0.0, 0.15), (0.30, 0.30, 0.30), (200, 40, 40)),
    Box((0.7, 0.2, 0.20), (0.25, 0.25, 0.40), (40, 80, 200)),
    Box((-0.7, 0.3, 0.125), (0.35, 0.25, 0.25), (40, 170, 60)),
    Box((0.0, 3.0, 1.25), (12.0, 0.2, 2.5), (190, 190, 170), is_salient=False),
)


@dataclass(frozen=True)
class View:
    """What a camera sees.

    rgb (H, W, 3) uint8; depth (H, W) float32 metres along z, NaN = nothing within 12 m;
    surface (H, W) int: 0 floor, k the k-th box (from 1), -1 nothing; ground_truth (H, W) uint8.
    """

    rgb: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.float32]
    surface: npt.NDArray[np.int64]
    ground_truth: npt.NDArray[np.uint8]


def kinect(width: int = 160, height: int = 120) -> Camera:
    """Return a Kinect's usual intrinsics, scaled to an image size."""
    ratio = width / 640
    return Camera(width, height, 525.0 * ratio, 525.0 * ratio, (width - 1) / 2, (height - 1) / 2)


def look(
    heading_deg: float = 0.0,
    *,
    distance: float = 1.9,
    height: float = 1.0,
    tilt_deg: float = 25.0,
) -> Pose:
    """Return the camera-to-world pose that looks over the room's middle from `distance` away."""
    heading, tilt = np.deg2rad(heading_deg), np.deg2rad(tilt_deg)
    forward = np.array(
        [np.sin(heading) * np.cos(tilt), np.cos(heading) * np.cos(tilt), -np.sin(tilt)]
    )
    right = np.array([np.cos(heading), -np.sin(heading), 0.0])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = [-distance * np.sin(heading), -distance * np.cos(heading), height]
    return pose


def poses_around(n_views: int) -> list[Pose]:
    """Return views from an arc of 60 degrees around the boxes."""
    return [look(heading) for heading in np.linspace(-30, 30, n_views)]


def render(camera: Camera, T_world_camera: Pose, boxes: tuple[Box, ...] = ROOM) -> View:
    """Cast one ray through the middle of each pixel, a few rows at a time: big images fit, too."""
    bands = range(0, camera.height, max(1, BAND_PIXELS // camera.width))
    seen = [
        _render_rows(np.arange(camera.height)[first:][: bands.step], camera, T_world_camera, boxes)
        for first in bands
    ]
    depth, surface, rgb = (np.concatenate(parts) for parts in zip(*seen, strict=True))
    is_salient = np.array([False, *(box.is_salient for box in boxes), False])
    truth = np.where(is_salient[surface], 255, 0).astype(np.uint8)
    return View(rgb=rgb, depth=depth, surface=surface, ground_truth=truth)


def _render_rows(
    rows: npt.NDArray[np.int64], camera: Camera, T_world_camera: Pose, boxes: tuple[Box, ...]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int64], npt.NDArray[np.uint8]]:
    """Return depth, surface and colour of some rows."""
    v, u = np.meshgrid(rows, np.arange(camera.width), indexing="ij")
    rays = np.dstack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)])
    directions = rays @ T_world_camera[:3, :3].T
    origin = T_world_camera[:3, 3]
    with np.errstate(divide="ignore"):
        depth = np.where(directions[..., 2] < 0, -origin[2] / directions[..., 2], np.inf)
    surface = np.zeros(depth.shape, np.int64)
    for number, box in enumerate(boxes, start=1):
        distance = _hit(origin, directions, box)
        is_nearer = distance < depth
        depth[is_nearer], surface[is_nearer] = distance[is_nearer], number
    is_nothing = ~(depth < FAR_METRES)
    depth[is_nothing], surface[is_nothing] = np.nan, -1
    rgb = _colours(surface, origin + directions * depth[..., None], boxes)
    return depth.astype(np.float32), surface, rgb


def _hit(origin: Array, directions: Array, box: Box) -> Array:
    """Return the depth at which each ray enters the box (slab test), infinity where it misses."""
    centre, half = np.array(box.centre), np.array(box.size) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        near_side = (centre - half - origin) / directions
        far_side = (centre + half - origin) / directions
    nearer, farther = np.fmin(near_side, far_side), np.fmax(near_side, far_side)
    entry = np.maximum(np.maximum(nearer[..., 0], nearer[..., 1]), nearer[..., 2])
    leave = np.minimum(np.minimum(farther[..., 0], farther[..., 1]), farther[..., 2])
    return np.where((entry <= leave) & (entry > 0), entry, np.inf)


def _colours(
    surface: npt.NDArray[np.int64], points: Array, boxes: tuple[Box, ...]
) -> npt.NDArray[np.uint8]:
    """Colour surfaces, with a chequered floor and stripes of height on boxes as texture."""
    palette = np.array([FLOOR_COLOUR, *(box.colour for box in boxes), (0, 0, 0)], np.float64)
    cells = np.floor(np.where(surface[..., None] < 0, 0, points) / [0.25, 0.25, 0.08]).astype(int)
    is_dark = np.where(surface == 0, cells[..., 0] + cells[..., 1], cells[..., 2]) & 1
    shaded = np.stack([palette, palette * 0.88]).astype(np.uint8)
    return shaded[is_dark, surface]
