"""The teacher: from one depth image, what is salient, what is not, and what is unknown."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Frame, Label
from curiosight.teacher.background import border_mask, on_supports, on_walls, under_tables
from curiosight.teacher.cloud.outline import cut_by, find_outline
from curiosight.teacher.cloud.planes import Mask, noise_band
from curiosight.teacher.cloud.points import Points, observe_points, spread
from curiosight.teacher.cloud.up import CAMERA_UP_PRIOR
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.confidence import measure_confidence
from curiosight.teacher.segmented import (
    CODE_OF,
    FLOOR,
    FOUND_AS,
    UNDER_TABLE,
    WALL,
    Segmentation,
)
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.footing import find_footing
from curiosight.teacher.supports.supports import (
    PLANE_BAND,
    Support,
)
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.things.hollows import find_hollows
from curiosight.teacher.things.objects import find_objects
from curiosight.teacher.things.things import Surroundings
from curiosight.teacher.things.verdicts import Cluster, Verdict
from curiosight.teacher.turning import rotation_of, turn_frame, turn_segmentation, turns_upright
from curiosight.teacher.walls.wall_map import moved, recognise
from curiosight.teacher.walls.walls import find_walls

Array = npt.NDArray[Any]


class Teacher:
    """Segment depth images of one recording (sec. II-A.2).

    survey: what was found about the recording as a whole, see `survey_recording`.
    """

    def __init__(
        self, survey: Survey | None = None, settings: SegmentationSettings | None = None
    ) -> None:
        self.survey = survey or Survey()
        self.settings = (settings or SegmentationSettings()).for_sensor(self.survey.noise)

    def segment(self, frame: Frame, *, up: Array | None = None) -> Segmentation:
        """Label every pixel of a frame; without depth or a support all is unknown.

        Supports and walls are not salient; of the rest, grouped, what is neither too small nor
        too large nor cut by the image's border is salient. A frame with a problem teaches
        nothing: what it shows may not be what is there.

        up: (3,) unit vector in the camera's frame, about, where no pose tells it; None = from
            this frame alone.
        """
        problem = _problem_of(frame)
        if problem is not None or frame.depth is None or frame.camera is None:
            return Segmentation.of_nothing(frame, problem, self.settings.max_range)
        n_turns, prior = self._held(frame, up)
        if up is not None:
            up = rotation_of(n_turns) @ up
        found = self._segment_upright(turn_frame(frame, n_turns), up, prior)
        return turn_segmentation(replace(found, n_turns=0), -n_turns)

    def _held(self, frame: Frame, up: Array | None) -> tuple[int, Array]:
        """Return the quarter turns that put a frame upright, and about where up is then."""
        survey, pose = self.survey, frame.T_world_camera
        prior = CAMERA_UP_PRIOR if survey.up_camera is None else survey.up_camera
        if pose is not None and survey.up_world is not None:
            up = pose[:3, :3].T @ survey.up_world
        n_turns = turns_upright(prior if up is None else up)
        return n_turns, rotation_of(n_turns) @ prior

    def _segment_upright(self, frame: Frame, up: Array | None, prior: Array) -> Segmentation:
        assert frame.depth is not None
        assert frame.camera is not None
        stride = self.settings.stride_at(frame.camera.width)
        points = observe_points(frame.depth, frame.camera, stride=stride)
        supports = find_footing(
            points, frame.T_world_camera, self.survey, self.settings, up=up, prior=prior
        )
        if not any(support.plane.inliers.any() for support in supports):
            return Segmentation.of_nothing(
                frame, self.survey.doubt or "no support plane is in view", self.settings.max_range
            )
        in_range = points.depth <= self.settings.max_range
        border = self._border(points, frame.camera)
        is_support = in_range & on_supports(points, supports, self.settings.noise)
        walls, is_wall = self._walls(points, supports, in_range & ~is_support, border, frame)
        around = Surroundings(points, supports, walls, border, self.settings)
        number, clusters = find_objects(in_range & ~is_support & ~is_wall, around)
        hollows = _hollows(number, clusters, is_support, points)
        labels = _label_of(clusters).take(number)
        labels[(is_support & (hollows == 0)) | is_wall] = Label.NOT_SALIENT
        doubtful = [support for support in supports if not support.kind.is_background]
        labels[is_support & on_supports(points, doubtful, self.settings.noise)] = Label.UNKNOWN
        found = self._found(points, supports, is_support, is_wall)
        number += hollows
        labels, number, found = _at_full_size(
            labels, number, found, points, frame.depth, self.settings.max_range
        )
        return Segmentation(
            labels, number, tuple(clusters), tuple(supports), tuple(walls), found=found
        )

    def confidence(self, frame: Frame, segmentation: Segmentation) -> npt.NDArray[np.float32]:
        """(H, W) in [0, 1]: how sure the labels of a frame are, see `measure_confidence`."""
        n_turns = segmentation.n_turns
        upright = turn_segmentation(segmentation, n_turns)
        confidence = measure_confidence(turn_frame(frame, n_turns), upright, self.settings)
        return np.ascontiguousarray(np.rot90(confidence, -n_turns))

    def _found(
        self, points: Points, supports: list[Support], is_support: Mask, is_wall: Mask
    ) -> Array:
        """(h, w) uint8, what `Segmentation.found` says, on the grid."""
        found = np.zeros(points.depth.shape, np.uint8)
        tables = [support for support in supports if support.is_table]
        found[under_tables(points, tables)] = CODE_OF[UNDER_TABLE]
        found[is_support] = CODE_OF[FLOOR]
        for kind, what in FOUND_AS.items():
            some = [table for table in tables if table.kind is kind]
            if some:
                found[is_support & on_supports(points, some, self.settings.noise)] = CODE_OF[what]
        found[is_wall] = CODE_OF[WALL]
        return found

    def _border(self, points: Points, camera: Camera) -> Mask:
        """(h, w) bool: where the image ends, or the view of its depth sensor."""
        border = border_mask(camera, points.stride, self.settings.border_px)
        if camera.depth_window is not None:
            return border
        outline = self.survey.outline
        return border | cut_by(find_outline([points]) if outline is None else outline, points)

    def _walls(
        self, points: Points, supports: list[Support], free: Mask, border: Mask, frame: Frame
    ) -> tuple[list[Wall], Mask]:
        """Return the recording's walls and those new in this frame, and (h, w) what is on them."""
        pose, noise = frame.T_world_camera, self.settings.noise
        known: list[Wall] = []
        if pose is not None:
            rotation = pose[:3, :3].T
            known = [moved(wall, rotation, -rotation @ pose[:3, 3]) for wall in self.survey.walls]
            known = [wall for wall in known if wall.offset > 0]  # the camera is before it
        band = noise_band(points.depth, PLANE_BAND, noise)
        known = recognise(points, known, free=free, band=band)
        is_known = on_walls(points, known, free, noise)
        over_tables = np.zeros(free.shape, np.bool_)
        for support in supports[1:]:
            if support.extent is not None:
                over_tables |= support.extent & (support.heights > 0)
        new = find_walls(
            points,
            # The largest support in view is the best measured vertical.
            max(supports, key=lambda s: np.count_nonzero(s.plane.inliers)).plane.normal,
            free=free & ~is_known,
            over_tables=over_tables,
            band=band,
            border=border,
            min_diagonal=self.settings.min_wall_diagonal,
            min_cut_diagonal=self.settings.min_cut_wall_diagonal,
        )
        return known + new, is_known | on_walls(points, new, free & ~is_known, noise)


def _hollows(number: Array, clusters: list[Cluster], is_support: Mask, points: Points) -> Array:
    """(h, w) int32 number of the object that a point of a support is inside of, 0 = none."""
    boxes = []
    for place, cluster in enumerate(clusters, start=1):
        if cluster.verdict is Verdict.OBJECT:
            u_min, v_min, u_max, v_max = (end // points.stride for end in cluster.box)
            boxes.append((place, (u_min, v_min, u_max, v_max)))
    return find_hollows(number, boxes, is_support, points)


def _label_of(clusters: list[Cluster]) -> npt.NDArray[np.uint8]:
    """Return the label of what is in no cluster, and of each cluster."""
    are_objects = [cluster.verdict is Verdict.OBJECT for cluster in clusters]
    return np.where([False, *are_objects], Label.SALIENT, Label.UNKNOWN).astype(np.uint8)


def _problem_of(frame: Frame) -> str | None:
    """Return why a frame cannot be segmented; None where it can."""
    if frame.problem is not None:
        return frame.problem
    if frame.depth is None or frame.camera is None:
        return "the frame has no depth"
    # One reading is enough, and mostly found in a few rows.
    has_reading = np.isfinite(frame.depth[::16]).any() or np.isfinite(frame.depth).any()
    return None if has_reading else "the depth image has no reading"


def _at_full_size(
    labels: Array, number: Array, found: Array, points: Points, depth: Array, max_range: float
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint8]]:
    """Return labels, numbers of clusters and what was found per pixel; far ones are unavailable."""
    full = spread(
        (number << 16) | (found.astype(np.int32) << 8) | labels,
        points.depth,
        depth,
        points.stride,
        max_depth=max_range,
        beyond=Label.UNAVAILABLE,
    )
    full_number = np.empty(full.shape, np.uint16)
    np.right_shift(full, 16, out=full_number, casting="unsafe")
    return full.astype(np.uint8), full_number, (full >> 8).astype(np.uint8)
