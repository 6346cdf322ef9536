"""The teacher: from one depth image, what is salient, what is not, and what is unknown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame, Label
from curiosight.segmentation.objects import Cluster, Verdict, find_clusters
from curiosight.segmentation.planes import Mask, Plane, noise_band
from curiosight.segmentation.points import Points, observe_points
from curiosight.segmentation.settings import FLOOR
from curiosight.segmentation.supports import Support, above_footprint, choose_supports
from curiosight.segmentation.survey import Survey
from curiosight.segmentation.up import CAMERA_UP_PRIOR, up_from_normals
from curiosight.segmentation.walls import find_walls

Array = npt.NDArray[Any]
MAX_TILT_FROM_SURVEY = np.radians(6)


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """What the teacher says of one frame.

    labels: (H, W) uint8, the codes of `Label`.
    cluster_of_pixel: (H, W) uint16, 1 + the place in `clusters`; 0 = none.
    supports, walls: in the camera's frame, lowest support first.
    problem: why nothing could be said; None = nothing is wrong.
    """

    labels: npt.NDArray[np.uint8]
    cluster_of_pixel: npt.NDArray[np.uint16]
    clusters: tuple[Cluster, ...] = ()
    supports: tuple[Support, ...] = ()
    walls: tuple[Plane, ...] = ()
    problem: str | None = None

    @property
    def objects(self) -> tuple[Cluster, ...]:
        """The clusters that passed every test, in the order of their instance numbers."""
        return tuple(c for c in self.clusters if c.verdict is Verdict.OBJECT)

    def instances(self) -> npt.NDArray[np.uint16]:
        """(H, W) number of each pixel's object, from 1; 0 = none."""
        number = np.zeros(len(self.clusters) + 1, np.uint16)
        is_object = np.array([False] + [c.verdict is Verdict.OBJECT for c in self.clusters])
        number[is_object] = np.arange(1, 1 + is_object.sum())
        return number[self.cluster_of_pixel]


class Teacher:
    """Segment depth images of one recording (sec. II-A.2).

    survey: what was found about the recording as a whole, see `survey_recording`.
    """

    def __init__(self, survey: Survey | None = None) -> None:
        self.survey = survey or Survey()

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel of a frame; without depth or a support all is unknown."""
        if frame.depth is None or frame.camera is None:
            shape = frame.rgb.shape[:2]
            return _nothing(np.full(shape, np.nan, np.float32), "the frame has no depth")
        if not np.isfinite(frame.depth).any():
            return _nothing(frame.depth, frame.problem or "the depth image has no reading")
        points = observe_points(frame.depth, frame.camera)
        up = self._up(points, frame)
        if up is None:
            return _nothing(frame.depth, "no horizontal surface is in view")
        supports = choose_supports(
            points,
            up,
            scene=self.survey.scene,
            camera_height=self.survey.camera_height(frame.T_world_camera),
            noise=FLOOR.noise,
        )
        if not any(support.plane.inliers.any() for support in supports):
            return _nothing(frame.depth, "no support plane is in view")
        return _label(frame.depth, frame.camera, points, supports)

    def _up(self, points: Points, frame: Frame) -> Array | None:
        """Return up in the camera's frame: from the pose where it tells, else from surfaces."""
        if self.survey.up_world is not None and frame.T_world_camera is not None:
            up: Array = frame.T_world_camera[:3, :3].T @ self.survey.up_world
            return up
        keep = points.area > 0
        return up_from_normals(points.normals[keep], points.area[keep], prior=CAMERA_UP_PRIOR)


def _nothing(depth: Array, problem: str) -> Segmentation:
    labels = np.where(np.isnan(depth), Label.UNAVAILABLE, Label.UNKNOWN).astype(np.uint8)
    return Segmentation(labels, np.zeros(depth.shape, np.uint16), problem=problem)


def _label(depth: Array, camera: Camera, points: Points, supports: list[Support]) -> Segmentation:
    in_range = points.depth <= FLOOR.max_range
    # The largest support in view is the best measured vertical.
    up = max(supports, key=lambda s: np.count_nonzero(s.plane.inliers)).plane.normal
    is_support = in_range & _on_supports(points, supports)
    border = border_mask(camera, points.stride, FLOOR.border_px)
    walls = find_walls(
        points,
        up,
        free=in_range & ~is_support,
        band=noise_band(points, 0.008, FLOOR.noise),
        border=border,
        min_diagonal=FLOOR.min_wall_diagonal,
        min_cut_diagonal=FLOOR.min_cut_wall_diagonal,
    )
    is_wall = in_range & _on_walls(points, walls)
    labels = np.full(points.depth.shape, Label.UNKNOWN, np.uint8)
    labels[is_support | is_wall] = Label.NOT_SALIENT
    free = in_range & ~is_support & ~is_wall
    number, clusters = _cluster_all(points, free, supports, walls, border)
    is_object = np.array([False] + [c.verdict is Verdict.OBJECT for c in clusters])
    labels[is_object[number]] = Label.SALIENT
    labels[~in_range] = Label.UNAVAILABLE
    full_labels = _enlarge(labels, points.stride, depth.shape)
    full_labels[np.isnan(depth)] = Label.UNAVAILABLE
    full_number = _enlarge(number.astype(np.uint16), points.stride, depth.shape)
    full_number[np.isnan(depth)] = 0
    return Segmentation(full_labels, full_number, tuple(clusters), tuple(supports), tuple(walls))


def _on_supports(points: Points, supports: list[Support]) -> Mask:
    """(h, w) bool: within the slab of a support, and not facing elsewhere."""
    found = np.zeros(points.depth.shape, np.bool_)
    for support in supports:
        normal = support.plane.normal.astype(np.float32)
        slab = noise_band(points, support.settings.slab, support.settings.noise)
        # An unknown normal compares false: near an edge the height alone decides.
        faces_elsewhere = np.abs(points.normals @ normal) < 0.7
        found |= (np.abs(support.heights(points)) < slab) & ~faces_elsewhere
    return found


def _on_walls(points: Points, walls: list[Plane]) -> Mask:
    found = np.zeros(points.depth.shape, np.bool_)
    for wall in walls:
        band = noise_band(points, 0.04, 2 * FLOOR.noise)
        faces_elsewhere = np.abs(points.normals @ wall.normal.astype(np.float32)) < 0.7
        found |= (np.abs(wall.distance(points.xyz)) < band) & ~faces_elsewhere
    return found


def _cluster_all(
    points: Points, free: Mask, supports: list[Support], walls: list[Plane], border: Mask
) -> tuple[Array, list[Cluster]]:
    """Cluster what is on each table, the highest first, then the rest over the lowest support.

    What is under a table stays out: its legs and apron are no objects, and would tie chairs
    together.
    """
    lowest = supports[0]
    number = np.zeros(free.shape, np.int32)
    clusters: list[Cluster] = []
    free = free.copy()
    for support in reversed(supports):
        heights = support.heights(points)
        slab = noise_band(points, support.settings.slab, support.settings.noise)
        # Free points inside the slab face elsewhere: the foot of what stands there.
        over = free & (heights > -slab) & (heights < support.settings.max_height)
        if support.is_table:
            inside = above_footprint(points, support.plane)
            on_table = over & inside
            free &= ~(inside & (heights > -1.2))
            if support is lowest:
                on_table = over & (inside | free)
            over = on_table
        free &= ~over
        numbers, found = find_clusters(points, over, support, walls, border, lowest)
        number += np.where(numbers > 0, numbers + len(clusters), 0)
        clusters += found
    return number, clusters


def border_mask(camera: Camera, stride: int, border_px: int) -> Mask:
    """(h, w) bool on the grid: the image's frame, and what lies outside the depth sensor's view.

    The view's outline is the one of its whole rectangle (`Camera.depth_window`): holes and
    shadows inside it are no border.
    """
    u_min, v_min, u_max, v_max = camera.depth_window or (0, 0, camera.width, camera.height)
    u_min, v_min = max(u_min, 0), max(v_min, 0)
    u_max, v_max = min(u_max, camera.width), min(v_max, camera.height)
    border = np.ones((camera.height, camera.width), np.bool_)
    border[v_min + border_px : v_max - border_px, u_min + border_px : u_max - border_px] = False
    return border[::stride, ::stride]


def _enlarge(grid: Array, stride: int, shape: tuple[int, ...]) -> Array:
    """Repeat each cell `stride` times in both directions, cut to `shape`."""
    height, width = shape
    return np.repeat(np.repeat(grid, stride, axis=0), stride, axis=1)[:height, :width].copy()
