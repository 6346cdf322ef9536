"""The teacher: from one depth image, what is salient, what is not, and what is unknown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame
from curiosight.teacher.cloud.repeats import Repeats
from curiosight.teacher.cloud.up import CAMERA_UP_PRIOR
from curiosight.teacher.cloud.view import observe_view
from curiosight.teacher.confidence import measure_confidence
from curiosight.teacher.labelling import label_pixels
from curiosight.teacher.mask_edges import follow_masks
from curiosight.teacher.resizing import (
    found_in_own_size,
    in_full_size,
    in_own_size,
    picked,
    repeats_in,
)
from curiosight.teacher.segmented import Segmentation
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.footing import find_footing
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.things.objects import find_objects
from curiosight.teacher.turning import rotation_of, turn_frame, turn_segmentation, turns_upright
from curiosight.teacher.walls.surroundings import find_surroundings

Array = npt.NDArray[Any]


class Teacher:
    """Segment depth images of one recording (sec. II-A.2).

    survey: what was found about the recording as a whole, see `survey_recording`.
    masks: of a frame's instances, (H, W) int32, 0 = none, which tell where objects end; or why
        there are none. None = depth alone tells.
    """

    def __init__(
        self,
        survey: Survey | None = None,
        settings: SegmentationSettings | None = None,
        *,
        masks: Callable[[Frame], npt.NDArray[np.int32] | str] | None = None,
    ) -> None:
        self.survey = survey or Survey()
        self.masks = masks
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
        repeats = self.repeats_in(frame)
        n_turns, prior = self._held(frame, up)
        if up is not None:
            up = rotation_of(n_turns) @ up
        masks = self.masks(frame) if self.masks else None
        regions = None if masks is None or isinstance(masks, str) else masks
        found = self._segment_upright(
            turn_frame(in_own_size(frame, repeats), n_turns),
            up,
            prior,
            None if regions is None else np.rot90(picked(regions, repeats), n_turns),
        )
        lacks = masks if isinstance(masks, str) else None
        found = turn_segmentation(replace(found, n_turns=0, lacks=lacks), -n_turns)
        found = in_full_size(found, repeats)
        # All pixels are looked at, since masks may be finer than depth.
        return found if regions is None else follow_masks(found, regions, frame.depth)

    def repeats_in(self, frame: Frame) -> Repeats | None:
        """Return how a frame's depth repeats its readings; None where it does not."""
        return repeats_in(frame, self.survey.repeats)

    def _held(self, frame: Frame, up: Array | None) -> tuple[int, Array]:
        """Return the quarter turns that put a frame upright, and about where up is then."""
        survey, pose = self.survey, frame.T_world_camera
        prior = CAMERA_UP_PRIOR if survey.up_camera is None else survey.up_camera
        if pose is not None and survey.up_world is not None:
            up = pose[:3, :3].T @ survey.up_world
        n_turns = turns_upright(prior if up is None else up)
        return n_turns, rotation_of(n_turns) @ prior

    def _segment_upright(
        self, frame: Frame, up: Array | None, prior: Array, regions: Array | None
    ) -> Segmentation:
        """Go down the stairs: each stage takes what the one before has found, and no more."""
        assert frame.depth is not None
        assert frame.camera is not None
        survey, settings = self.survey, self.settings
        points = observe_view(
            frame.depth, frame.camera, frame.T_world_camera, settings, survey.outline
        )
        supports = find_footing(points, survey, settings, up=up, prior=prior)
        if not supports.found:
            problem = survey.doubt or "no support plane is in view"
            return Segmentation.of_nothing(frame, problem, settings.max_range)
        surroundings = find_surroundings(supports, survey.walls)
        stride = points.stride
        things = find_objects(
            surroundings, None if regions is None else regions[::stride, ::stride]
        )
        return label_pixels(things, frame.depth)

    def confidence(self, frame: Frame, segmentation: Segmentation) -> npt.NDArray[np.float32]:
        """(H, W) in [0, 1]: how sure the labels of a frame are, see `measure_confidence`."""
        n_turns, repeats = segmentation.n_turns, self.repeats_in(frame)
        upright = turn_segmentation(found_in_own_size(segmentation, repeats), n_turns)
        frame = turn_frame(in_own_size(frame, repeats), n_turns)
        confidence = measure_confidence(frame, upright, self.settings)
        confidence = np.ascontiguousarray(np.rot90(confidence, -n_turns))
        return confidence if repeats is None else repeats.repeat(confidence)


def _problem_of(frame: Frame) -> str | None:
    """Return why a frame cannot be segmented; None where it can."""
    if frame.problem is not None:
        return frame.problem
    if frame.depth is None or frame.camera is None:
        return "the frame has no depth"
    # One reading is enough, and mostly found in a few rows.
    has_reading = np.isfinite(frame.depth[::64]).any() or np.isfinite(frame.depth).any()
    return None if has_reading else "the depth image has no reading"
