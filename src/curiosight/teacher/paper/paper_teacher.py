"""The paper's own teacher (sec. II-A.2), box by box; the preset `paper` uses it.

    depth ► cloud ► main plane, the floor or a table: not salient
                  ► large planes perpendicular to it, walls: not salient
                  ► the rest ► k-d tree clustering ► too small, too large, at the border: unknown
                                                   ► the other clusters: salient

Each frame stands alone: no poses, no survey, no memory. `teacher.py` is what became of it.
"""

from __future__ import annotations

from math import hypot
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label
from curiosight.teacher.cloud.planes import Mask, Plane, horizontal_axes
from curiosight.teacher.cloud.points import Points, observe_points, spread
from curiosight.teacher.cloud.view import border_mask
from curiosight.teacher.paper.paper_planes import find_main_plane, find_walls
from curiosight.teacher.paper.paper_settings import PaperSettings
from curiosight.teacher.segmented import Segmentation
from curiosight.teacher.supports.supports import Scene
from curiosight.teacher.things.clusters import near_sets
from curiosight.teacher.things.verdicts import Cluster, Verdict

Array = npt.NDArray[Any]
# All is done on every second row and column of the image.
STRIDE = 2
# What a point is in; from FIRST_CLUSTER on, the clusters.
UNAVAILABLE, SURFACE, NO_CLUSTER, FIRST_CLUSTER = range(4)


class PaperTeacher:
    """Segment depth images as the paper does (sec. II-A.2).

    scene: what the main plane is; it chooses the thresholds.
    """

    def __init__(self, scene: Scene = "floor", settings: PaperSettings | None = None) -> None:
        if scene not in ("floor", "table"):
            raise ValueError(f"scene: expected floor or table, got {scene!r}")
        self.scene = scene
        self.settings = settings or PaperSettings()
        self.limits = self.settings.floor if scene == "floor" else self.settings.table

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel of a frame; without depth or a main plane all is unknown."""
        if frame.problem is not None:
            return Segmentation.of_nothing(frame, frame.problem, self.settings.max_range)
        if frame.depth is None or frame.camera is None:
            return Segmentation.of_nothing(frame, "the frame has no depth", self.settings.max_range)
        points = observe_points(frame.depth, frame.camera, stride=STRIDE)
        in_range = points.depth <= self.settings.max_range
        rng = np.random.default_rng(self.settings.seed)
        main_plane = find_main_plane(points, in_range, self.limits, self.settings, rng)
        if main_plane is None:
            return Segmentation.of_nothing(
                frame, f"no {self.scene} is in view", self.settings.max_range
            )
        heights = main_plane.distance(points.xyz)
        # What lies below is not salient either: the floor under a table.
        rest = in_range & (heights >= self.limits.min_height)
        for wall in find_walls(points, main_plane.normal, rest, self.settings, rng):
            rest &= ~wall.inliers
        where = np.flatnonzero(rest & (heights <= self.limits.max_height))
        number, n_voxels = voxel_clusters(
            points.xyz_at(where), leaf=self.limits.leaf, tolerance=self.limits.tolerance
        )
        border_px = self.settings.border_px
        is_border = border_mask(frame.camera, STRIDE, border_px, outline_px=border_px)
        clusters = [
            self._cluster(members, n, points, main_plane, is_border)
            for members, n in zip(_members(where, number), n_voxels.tolist(), strict=True)
        ]
        in_what = np.full(rest.shape, NO_CLUSTER, np.int32)
        in_what[in_range & ~rest] = SURFACE
        in_what.ravel()[where] = FIRST_CLUSTER + number
        return _back_to_image(in_what, clusters, points, frame.depth, self.settings.max_range)

    def _cluster(
        self, members: Array, n_voxels: int, points: Points, main_plane: Plane, is_border: Mask
    ) -> Cluster:
        """Measure and judge a cluster; members: (n,) flat indices on the grid."""
        xyz = points.xyz_at(members)
        right, ahead = horizontal_axes(main_plane.normal)
        height = float(main_plane.distance(xyz).max())
        size = (float(np.ptp(xyz @ right)), float(np.ptp(xyz @ ahead)), height)
        verdict = Verdict.CUT if is_border.take(members).any() else self._judge(xyz, size, n_voxels)
        rows, columns = np.divmod(members, points.depth.shape[1])
        return Cluster(
            verdict=verdict,
            box=(
                STRIDE * int(columns.min()),
                STRIDE * int(rows.min()),
                STRIDE * (int(columns.max()) + 1),
                STRIDE * (int(rows.max()) + 1),
            ),
            n_pixels=STRIDE**2 * len(members),
            size=size,
            distance=float(np.median(xyz[:, 2])),
            support_height=0.0,
        )

    def _judge(self, xyz: Array, size: tuple[float, float, float], n_voxels: int) -> Verdict:
        """Apply the tests of size and range to the (n, 3) points of a cluster."""
        fewest, most = self.limits.voxel_limits
        if n_voxels < fewest or hypot(*size) < self.limits.min_size:
            return Verdict.SMALL
        if n_voxels > most or hypot(*size) > self.limits.max_size:
            return Verdict.LARGE
        if xyz[:, 2].max() > self.settings.max_range - self.settings.border_distance:
            return Verdict.FAR
        return Verdict.OBJECT


def voxel_clusters(xyz: Array, *, leaf: float, tolerance: float) -> tuple[Array, Array]:
    """Number the clusters of (n, 3) points in metres: Euclidean, of voxels.

    Points in one voxel of side `leaf` belong together, and so do voxels whose mean points lie
    within `tolerance` of each other. Return each point's cluster, (n,), from 0, and how many
    voxels each cluster has.
    """
    cells = np.floor(xyz / leaf).astype(np.int64)
    _, voxel, n_points = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(voxel, xyz[:, axis], len(n_points)) for axis in range(3)], axis=1)
    means = sums / n_points[:, None]
    cluster_of_voxel = near_sets(means, tolerance)
    return cluster_of_voxel[voxel], np.bincount(cluster_of_voxel)


def _members(where: Array, number: Array) -> list[Array]:
    """Return the points of each cluster; number: (n,) of the points at the (n,) places `where`."""
    order = np.argsort(number, kind="stable")
    if not len(order):
        return []
    return np.split(where[order], np.flatnonzero(np.diff(number[order])) + 1)


def _back_to_image(
    in_what: Array, clusters: list[Cluster], points: Points, depth: Array, max_range: float
) -> Segmentation:
    """Return labels and clusters per pixel; in_what: (h, w) int32 of the grid's points."""
    label_of = [Label.UNAVAILABLE, Label.NOT_SALIENT, Label.UNKNOWN]
    for cluster in clusters:
        is_object = cluster.verdict is Verdict.OBJECT
        label_of.append(Label.SALIENT if is_object else Label.UNKNOWN)
    number = np.maximum(in_what - FIRST_CLUSTER + 1, 0)
    labels, _, cluster_of_pixel = spread(
        (number << 16) | np.array(label_of, np.int32).take(in_what),
        points.depth,
        depth,
        STRIDE,
        max_depth=max_range,
        beyond=Label.UNAVAILABLE,
    )
    return Segmentation(labels, cluster_of_pixel, tuple(clusters))
