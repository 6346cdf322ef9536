"""The second stage: points to what things stand on, told by a pose or by the frame alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.teacher.cloud.planes import Mask
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.up import (
    CAMERA_UP_PRIOR,
    up_from_normals,
    ups_from_normals,
    votes_on_up,
)
from curiosight.teacher.cloud.veils import find_veils
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.slab import NOTHING, on_supports
from curiosight.teacher.supports.supports import (
    KnownTable,
    Scene,
    Support,
    choose_supports,
    share_below,
)
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.supports.tops import Kind

Array = npt.NDArray[Any]
# A camera without poses tilts and rolls by less from one frame to the next.
MAX_TURN = np.radians(12)
# More of the points below the lowest support, and it is no floor.
MAX_SHARE_BELOW = 0.10


@dataclass(frozen=True, slots=True, eq=False)
class Supports:
    """What the things of a frame stand on.

    found: the supports in view, lowest first; none where no point is on one.
    kinds: (h, w) uint8, what a point is on, see `slab.py`. free: (h, w) bool, on none, and of some
        surface; both within the range.
    lids: (h, w) bool each, what is straight above or below the top of something on the floor
        that carries nothing.
    """

    points: Points
    settings: SegmentationSettings
    found: list[Support]
    kinds: Array
    free: Mask
    lids: Sequence[Mask] = ()


def find_footing(
    points: Points,
    survey: Survey,
    settings: SegmentationSettings,
    *,
    up: Array | None = None,
    prior: Array = CAMERA_UP_PRIOR,
) -> Supports:
    """Return the supports in view.

    up: (3,) unit vector in the camera's frame, about, for want of a pose; None = from this frame
        alone.
    prior: (3,) within 45° of which up is then.
    """
    tops = _supports_in(points, survey, settings, up, prior)
    if survey.floor_only:
        # So no table is looked for, but what is one thing may be as wide as it is long.
        tops = tops[:1] + [replace(top, kind=Kind.THING) for top in tops[1:]]
    found = [top for top in tops if top.kind is not Kind.THING]
    lids = [top.extent for top in tops if top.kind is Kind.THING and top.extent is not None]
    if not any(support.plane.inliers.any() for support in found):
        found = []
    in_range = points.depth <= settings.max_range
    kinds = in_range * on_supports(points, found, settings.noise)
    free = in_range & (kinds == NOTHING) & ~find_veils(points)
    return Supports(points, settings, found, kinds, free, lids)


def _supports_in(
    points: Points,
    survey: Survey,
    settings: SegmentationSettings,
    up: Array | None,
    prior: Array,
) -> list[Support]:
    """Return the supports in view, lowest first, and lids; empty when there is none."""
    if points.pose is not None and survey.up_world is not None:
        return _surveyed_supports(points, points.pose, survey, survey.up_world, settings)
    surface = points.normals.reshape(-1, 3), votes_on_up(points, settings.max_range).ravel()
    if up is None:
        return _largest_supports(points, surface, survey.scene, settings, prior)
    turned = up_from_normals(*surface, prior=up, max_angle=MAX_TURN)
    return [] if turned is None else choose_supports(points, turned, settings, scene=survey.scene)


def _surveyed_supports(
    points: Points, pose: Pose, survey: Survey, up_world: Array, settings: SegmentationSettings
) -> list[Support]:
    camera_height = survey.camera_height(pose)
    known_tables = [
        KnownTable(
            camera_height - table.height,
            table.inset_of(points, pose),
            table.core,
            table.kind,
        )
        for table in survey.tables
        if camera_height is not None and table.is_in_view(points, pose, settings.max_range)
    ]
    return choose_supports(
        points,
        pose[:3, :3].T @ up_world,
        settings,
        scene=survey.scene,
        camera_height=camera_height,
        known_tables=known_tables,
    )


def _largest_supports(
    points: Points,
    surface: tuple[Array, Array],
    scene: Scene,
    settings: SegmentationSettings,
    prior: Array,
) -> list[Support]:
    """Return the supports that face where most of the surface does.

    Unless much lies below the lowest then, as when the largest surface is a box's side.
    surface: (n, 3) normals and (n,) area.
    """
    first: list[Support] = []
    for up in ups_from_normals(*surface, prior=prior):
        supports = choose_supports(points, up, settings, scene=scene)
        if supports and share_below(points, supports[0].plane) < MAX_SHARE_BELOW:
            return supports
        first = first or supports
    # Below a table there is much to see; below a floor there is not.
    return first if scene == "table" else []
