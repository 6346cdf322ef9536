"""The teacher: from one depth image, what is salient, what is not, and what is unknown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame, Label, Pose
from curiosight.segmentation.objects import Cluster, Surroundings, Verdict, find_clusters
from curiosight.segmentation.planes import Mask, Plane, noise_band
from curiosight.segmentation.points import Points, cell_of_pixel, observe_points
from curiosight.segmentation.settings import SegmentationSettings
from curiosight.segmentation.supports import (
    PLANE_BAND,
    KnownTable,
    Support,
    choose_supports,
    settle,
    share_below,
)
from curiosight.segmentation.survey import Survey
from curiosight.segmentation.up import ups_from_normals
from curiosight.segmentation.walls import Wall, find_walls, known_walls

Array = npt.NDArray[Any]
# More of the points below the lowest support, and it is no floor.
MAX_SHARE_BELOW = 0.10


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

    @classmethod
    def of_labels(cls, labels: npt.NDArray[np.uint8], problem: str | None = None) -> Self:
        """Return a segmentation that says nothing but labels: for a detector of one's own."""
        return cls(labels, np.zeros(labels.shape, np.uint16), problem=problem)

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

    def __init__(
        self, survey: Survey | None = None, settings: SegmentationSettings | None = None
    ) -> None:
        self.survey = survey or Survey()
        self.settings = settings or SegmentationSettings()

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel of a frame; without depth or a support all is unknown.

        A frame with a problem teaches nothing: what it shows may not be what is there.
        """
        max_range = self.settings.max_range
        if frame.depth is None or frame.camera is None:
            shape = frame.rgb.shape[:2]
            nowhere = np.full(shape, np.nan, np.float32)
            return _nothing(nowhere, max_range, frame.problem or "the frame has no depth")
        if frame.problem is not None:
            return _nothing(frame.depth, max_range, frame.problem)
        if not np.isfinite(frame.depth).any():
            return _nothing(frame.depth, max_range, "the depth image has no reading")
        points = observe_points(frame.depth, frame.camera)
        supports = self._supports(points, frame)
        if not any(support.plane.inliers.any() for support in supports):
            return _nothing(frame.depth, max_range, "no support plane is in view")
        known = self._known_walls(frame.T_world_camera)
        return _label(frame.depth, frame.camera, points, supports, known, self.settings)

    def _supports(self, points: Points, frame: Frame) -> list[Support]:
        """Return the supports in view, lowest first; empty when there is none.

        Where no pose tells which way is up, surfaces do: what most of them face, unless much
        lies below the lowest support then, as when the largest surface is a box's side.
        """
        pose, scene = frame.T_world_camera, self.survey.scene
        if self.survey.up_world is not None and pose is not None:
            return choose_supports(
                points,
                pose[:3, :3].T @ self.survey.up_world,
                self.settings,
                scene=scene,
                camera_height=self.survey.camera_height(pose),
                known_tables=self._known_tables(points, pose),
            )
        keep = points.area > 0
        first: list[Support] = []
        for up in ups_from_normals(points.normals[keep], points.area[keep]):
            supports = choose_supports(points, up, self.settings, scene=scene)
            if supports and share_below(points, supports[0].plane) < MAX_SHARE_BELOW:
                return supports
            first = first or supports
        # Below a table there is much to see; below a floor there is not.
        return first if scene == "table" else []


    def _known_tables(self, points: Points, pose: Pose) -> list[KnownTable]:
        camera_height = self.survey.camera_height(pose)
        if camera_height is None:
            return []
        return [
            KnownTable(camera_height - t.height, t.inset(points.xyz, pose), t.is_seat)
            for t in self.survey.tables
        ]


    def _known_walls(self, pose: Pose | None) -> list[Wall]:
        if pose is None:
            return []
        rotation = pose[:3, :3].T
        return [wall.moved(rotation, -rotation @ pose[:3, 3]) for wall in self.survey.walls]


def _nothing(depth: Array, max_range: float, problem: str) -> Segmentation:
    labels = np.where(depth <= max_range, Label.UNKNOWN, Label.UNAVAILABLE).astype(np.uint8)
    return Segmentation.of_labels(labels, problem)


def _label(
    depth: Array,
    camera: Camera,
    points: Points,
    supports: list[Support],
    known: list[Wall],
    settings: SegmentationSettings,
) -> Segmentation:
    in_range = points.depth <= settings.max_range
    # The largest support in view is the best measured vertical.
    up = max(supports, key=lambda s: np.count_nonzero(s.plane.inliers)).plane.normal
    is_support = in_range & _on_supports(points, supports, settings.noise)
    border = border_mask(camera, points.stride, settings.border_px)
    band = noise_band(points, PLANE_BAND, settings.noise)
    free = in_range & ~is_support
    walls = known_walls(points, known, free=free, band=band)
    walls += find_walls(
        points,
        up,
        free=free & ~_on_walls(points, walls, settings.noise),
        over_tables=_over_tables(points, supports),
        band=band,
        border=border,
        min_diagonal=settings.min_wall_diagonal,
        min_cut_diagonal=settings.min_cut_wall_diagonal,
    )
    is_wall = in_range & _on_walls(points, walls, settings.noise)
    labels = np.full(points.depth.shape, Label.UNKNOWN, np.uint8)
    labels[is_support | is_wall] = Label.NOT_SALIENT
    seats = [s.extent for s in supports if s.is_seat and s.extent is not None]
    upholstery = np.any(seats, axis=0) if seats else np.zeros(points.depth.shape, np.bool_)
    around = Surroundings(points, supports, walls, border, upholstery, settings)
    number, clusters = _cluster_all(in_range & ~is_support & ~is_wall, around)
    is_object = np.array([False] + [c.verdict is Verdict.OBJECT for c in clusters])
    labels[is_object[number]] = Label.SALIENT
    labels[~in_range] = Label.UNAVAILABLE
    cells = cell_of_pixel(np.ascontiguousarray(points.depth), depth, points.stride)
    full_labels, full_number = labels.take(cells), number.astype(np.uint16).take(cells)
    is_out = ~(depth <= settings.max_range)
    full_labels[is_out] = Label.UNAVAILABLE
    full_number[is_out] = 0
    return Segmentation(full_labels, full_number, tuple(clusters), tuple(supports), tuple(walls))


def _on_supports(points: Points, supports: list[Support], noise: float) -> Mask:
    """(h, w) bool: within the slab of a support, and not facing elsewhere."""
    found = np.zeros(points.depth.shape, np.bool_)
    for support in supports:
        normal = support.plane.normal.astype(np.float32)
        slab = noise_band(points, support.settings.slab, noise)
        # An unknown normal compares false: near an edge the height alone decides.
        faces_elsewhere = np.abs(points.normals @ normal) < 0.7
        on = (np.abs(support.heights(points)) < slab) & ~faces_elsewhere
        if support.extent is not None and support is not supports[0]:
            on &= support.extent
        found |= on
    return found


def _over_tables(points: Points, supports: list[Support]) -> Mask:
    found = np.zeros(points.depth.shape, np.bool_)
    for support in supports[1:]:
        if support.extent is not None:
            found |= support.extent & (support.heights(points) > 0)
    return found


def _on_walls(points: Points, walls: list[Wall], noise: float) -> Mask:
    """(h, w) bool: within a wall's band, straight before it, and not facing elsewhere."""
    found = np.zeros(points.depth.shape, np.bool_)
    band = noise_band(points, 0.04, 2 * noise)
    for wall in walls:
        if wall.inliers.any():
            near = np.abs(wall.distance(points.xyz)) < band
            near &= ~(np.abs(points.normals @ wall.normal.astype(np.float32)) < 0.7)
            found |= near & wall.is_beside(points.xyz)
    return found


def _cluster_all(free: Mask, around: Surroundings) -> tuple[Array, list[Cluster]]:
    """Cluster what is on each table, the highest first, then the rest over the lowest support.

    What is under a table stays out: its legs and apron are no objects, and would tie chairs
    together.
    """
    points, lowest = around.points, around.supports[0]
    number = np.zeros(free.shape, np.int32)
    clusters: list[Cluster] = []
    free = free.copy()
    for support in reversed(around.supports):
        heights = support.heights(points)
        slab = noise_band(points, support.settings.slab, around.settings.noise)
        # What is free inside the slab faces elsewhere: the foot of something, or a crease.
        over = free & (heights > slab / 2) & (heights < support.settings.max_height)
        if support.is_seat:
            continue
        if support.extent is not None:
            extent = settle(free, support, points, around.settings.noise)
            on_table = over & extent
            under = extent if support.sure is None else extent & (support.sure | (heights > -slab))
            free &= ~(under & (heights > -1.2))
            if support is lowest:
                on_table = over & (extent | free)
            over = on_table
        free &= ~over
        numbers, found = find_clusters(over, support, around)
        number += np.where(numbers > 0, numbers + len(clusters), 0)
        clusters += found
    return number, clusters


def border_mask(camera: Camera, stride: int, border_px: int, outline_px: int = 4) -> Mask:
    """(h, w) bool on the grid: the image's frame, and what the depth sensor's view leaves out.

    The view is the sensor's whole rectangle (`Camera.depth_window`), less `outline_px`, within
    which registration can shift it: holes and shadows inside it are no border.
    """
    rows, columns = np.arange(0, camera.height, stride), np.arange(0, camera.width, stride)
    window = camera.depth_window or (0, 0, camera.width, camera.height)
    u_min, v_min = (max(border_px, low + outline_px) for low in window[:2])
    u_max = min(camera.width - border_px, window[2] - outline_px)
    v_max = min(camera.height - border_px, window[3] - outline_px)
    is_inside = ((rows >= v_min) & (rows < v_max))[:, None]
    border: Mask = ~(is_inside & (columns >= u_min) & (columns < u_max))
    return border
