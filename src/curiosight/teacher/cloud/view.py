"""The first stage: a frame's depth to points, and where its view ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from math import ceil

import numpy as np

from curiosight.frame import Camera, Depth, Pose
from curiosight.teacher.cloud.outline import Side, cut_by, find_outline
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points, observe_points, scale_of
from curiosight.teacher.settings import SegmentationSettings

# Registration shifts the outline of the depth sensor's view by up to so many pixels of a 640x480
# image.
OUTLINE_PX = 4


def observe_view(
    depth: Depth,
    camera: Camera,
    pose: Pose | None,
    settings: SegmentationSettings,
    outline: Sequence[Side] | None = None,
) -> Points:
    """Return the points of a view, with its border and its pose.

    outline: sides of the depth sensor's view, see `find_outline`; None = as this view alone
        shows them.
    """
    points = observe_points(depth, camera, stride=settings.stride_at(scale_of(camera)))
    border_px, outline_px = (ceil(points.scale * px) for px in (settings.border_px, OUTLINE_PX))
    border = border_mask(camera, points.stride, border_px, outline_px)
    if camera.depth_window is None:
        border = border | cut_by(find_outline([points]) if outline is None else outline, points)
    return replace(points, border=border, pose=pose)


@lru_cache(maxsize=8)
def border_mask(camera: Camera, stride: int, border_px: int, outline_px: int = 4) -> Mask:
    """(h, w) bool on the grid: the image's frame, and what the depth sensor's view leaves out.

    The view is the sensor's whole rectangle (`Camera.depth_window`), less `outline_px`, within
    which registration can shift it: holes and shadows inside it are no border. Read-only: the
    frames of a camera share it.
    """
    rows, columns = np.arange(0, camera.height, stride), np.arange(0, camera.width, stride)
    window = camera.depth_window or (0, 0, camera.width, camera.height)
    u_min, v_min = (max(border_px, low + outline_px) for low in window[:2])
    u_max = min(camera.width - border_px, window[2] - outline_px)
    v_max = min(camera.height - border_px, window[3] - outline_px)
    is_inside = ((rows >= v_min) & (rows < v_max))[:, None]
    border: Mask = ~(is_inside & (columns >= u_min) & (columns < u_max))
    border.flags.writeable = False
    return border
