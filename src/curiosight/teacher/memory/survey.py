"""What the frames of a recording tell together: which way is up, and where the floor is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import MOUNTS, Frame, Pose
from curiosight.teacher.cloud.outline import find_outline
from curiosight.teacher.cloud.planes import Plane, noise_band
from curiosight.teacher.cloud.points import Points
from curiosight.teacher.cloud.repeats import Repeats, find_repeats
from curiosight.teacher.cloud.up import CAMERA_UP_PRIOR, settled, up_from_normals, votes_on_up
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.memory.gravity import Gravity, Held, find_gravity, observe, surfaces_of
from curiosight.teacher.memory.places import positions_of, shrunk, without_outliers
from curiosight.teacher.memory.tables import find_tables
from curiosight.teacher.resizing import in_own_size
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.supports import PLANE_BAND, Scene, find_planes, share_below
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.supports.table_map import MARGIN, Table
from curiosight.teacher.turning import rotation_of, turn_frame, turns_upright
from curiosight.teacher.walls.wall_map import join_walls, moved
from curiosight.teacher.walls.walls import find_walls

Array = npt.NDArray[Any]
SCENES = ("auto", "floor", "table")
UPS = ("auto", *MOUNTS)
# Share of a frame's largest plane that another has, to tell the sensor's noise too.
MIN_TELLING = 0.1


def survey_recording(
    frames: Iterable[Frame],
    settings: SegmentationSettings | None = None,
    *,
    scene: str = "auto",
    up: Held = "auto",
) -> Survey:
    """Look at some frames of a recording and find what they share.

    scene: "table" = things stand on a table, the lowest support in view. "floor" = a robot's:
        nothing but the floor is a support, and what carries things is one object with them.
        "auto" tells a floor from a table, which the camera sees below, or nothing beyond; over a
        floor it decides of each level surface whether it carries things. With poses the floor's
        height is found too, so that it stays known where tables hide it.
    up: to which side of the image up points; "towards" the camera where it looks straight
        down, "away" from it where it looks straight up; "auto" = find out.
    """
    if scene not in SCENES:
        raise ValueError(f"scene: expected one of {', '.join(SCENES)}, got {scene!r}")
    if up not in UPS:
        raise ValueError(f"up: expected one of {', '.join(UPS)}, got {up!r}")
    settings, demanded = settings or SegmentationSettings(), scene
    usable, repeats = _in_own_size(one for one in frames if _can_teach(one))
    kept = without_outliers(usable)
    gravity = find_gravity([shrunk(frame) for frame in kept], settings, up)
    observed = [_observe(frame, gravity) for frame in kept]
    posed = [(points, pose) for points, pose in observed if pose is not None]
    noise = _noise_on_planes(observed, gravity, settings)
    settings = settings.for_sensor(noise)
    is_one_way = len({_turns(frame, gravity) for frame in kept}) == 1
    outline = find_outline(points for points, _ in observed) if is_one_way else None
    floor = None
    up_world = gravity.up_world
    if up_world is not None:
        up_world, heights, areas = _world_supports(posed, up_world, settings)
        floor = _lowest_peak(heights, areas)
        if scene == "auto" and floor is not None and heights.max() - floor > 0.3:
            scene = "floor"
    gravity = replace(gravity, up_world=up_world)
    if scene == "auto":
        scene = _scene_of(observed, gravity, settings)
    known = Survey(
        "table" if scene == "table" else "floor",
        up_world,
        noise=noise,
        up_camera=gravity.up_camera,
        doubt=gravity.doubt,
        outline=outline,
        repeats=repeats,
        floor_only=demanded == "floor",
    )
    if scene == "table" or up_world is None or floor is None:
        return known
    places = positions_of(kept)
    surveyed = np.stack([places.min(axis=0), places.max(axis=0)])
    tables = find_tables(posed, up_world, floor, settings)
    walls = _walls(posed, up_world, floor, tables, settings)
    return replace(known, floor_height=floor, tables=tables, walls=walls, surveyed=surveyed)


def _can_teach(frame: Frame) -> bool:
    has_depth = frame.depth is not None and bool(np.isfinite(frame.depth).any())
    return has_depth and frame.problem is None


def _in_own_size(frames: Iterable[Frame]) -> tuple[list[Frame], Repeats | None]:
    """Return frames as their depth's own size shows them, and how most of them repeat it.

    In a frame that shows little this cannot be seen.
    """
    small: list[Frame] = []
    found: list[Repeats] = []
    for frame in frames:
        assert frame.depth is not None
        repeats = find_repeats(frame.depth)
        found.append(repeats)
        small.append(shrunk(in_own_size(frame, repeats), 640))
    are_repeated = [repeats.shape != repeats.full_shape for repeats in found]
    is_usual = 2 * sum(are_repeated) > len(found)
    return small, found[are_repeated.index(is_usual)] if found else None


def _turns(frame: Frame, gravity: Gravity) -> int:
    """Return the quarter turns that put a frame upright."""
    up, pose = gravity.up_camera, frame.T_world_camera
    if pose is not None and gravity.up_world is not None:
        up = pose[:3, :3].T @ gravity.up_world
    return 0 if up is None else turns_upright(up)


def _observe(frame: Frame, gravity: Gravity) -> tuple[Points, Pose | None]:
    """Return the points of a frame that is turned upright, and its pose then."""
    upright = turn_frame(frame, _turns(frame, gravity))
    return observe(shrunk(upright)), upright.T_world_camera


def _world_supports(
    posed: list[tuple[Points, Pose]], up: Array, settings: SegmentationSettings
) -> tuple[Array, Array, Array]:
    """Refine the world's up by the supports' own normals, twice.

    Return it with the height and the visible area of every support of every frame.
    """
    heights: list[float] = []
    areas: list[float] = []
    # So often that it does not matter where it began.
    up = settled(*surfaces_of(posed, settings.max_range), up, 8 * [5])
    for _ in range(3):
        heights, areas, normals = [], [], []
        for points, T_world_camera in posed:
            rotation, centre = T_world_camera[:3, :3], T_world_camera[:3, 3]
            for plane in find_planes(points, rotation.T @ up, settings):
                heights.append(float(up @ centre) - plane.offset)
                areas.append(float(points.area[plane.inliers].sum()))
                normals.append(rotation @ plane.normal)
        if not normals:
            break
        mean = np.average(normals, axis=0, weights=areas)
        up = mean / np.linalg.norm(mean)
    return up, np.array(heights), np.array(areas)


def _walls(
    posed: list[tuple[Points, Pose]],
    up: Array,
    floor: float,
    tables: tuple[Table, ...],
    settings: SegmentationSettings,
) -> tuple[Wall, ...]:
    found = []
    for points, T_world_camera in posed:
        rotation, centre = T_world_camera[:3, :3], T_world_camera[:3, 3]
        heights = points.xyz @ (rotation.T @ up).astype(np.float32) + float(up @ centre) - floor
        over_tables = np.zeros(heights.shape, np.bool_)
        for table in tables:
            is_there = table.inset_of(points, T_world_camera) > -MARGIN
            over_tables |= is_there & (heights > table.height)
        walls = find_walls(
            points,
            rotation.T @ up,
            free=(points.depth < settings.max_range) & (heights > 0.05),
            over_tables=over_tables,
            band=noise_band(points.depth, PLANE_BAND, settings.noise),
            border=np.zeros(heights.shape, np.bool_),
            min_diagonal=settings.min_wall_diagonal,
        )
        found += [moved(wall, rotation, centre) for wall in walls]
    return join_walls(found)


def _lowest_peak(heights: Array, areas: Array, *, step: float = 0.05) -> float | None:
    """Return the lowest height at which the frames together show a fair area; None = none."""
    if len(heights) < 2:
        return None
    low = float(heights.min())
    histogram = np.bincount(((heights - low) / step).astype(np.int64), areas)
    smooth = np.convolve(histogram, np.ones(3), "same")
    first = int(np.flatnonzero(smooth > 0.04 * areas.sum())[0])
    near = np.abs(heights - (low + (first + 0.5) * step)) < 1.6 * step
    if np.count_nonzero(near) < 2:
        return None
    return float(np.average(heights[near], weights=areas[near]))


def _scene_of(
    observed: list[tuple[Points, Pose | None]],
    gravity: Gravity,
    settings: SegmentationSettings,
) -> Scene:
    """Return what the lowest support is in most frames."""
    votes = []
    for points, pose in observed:
        planes = _planes_in(points, pose, gravity, settings)
        if planes:
            votes.append(_looks_like_table(points, max(planes, key=lambda plane: plane.offset)))
    return "table" if votes and np.mean(votes) > 0.5 else "floor"


def _noise_on_planes(
    observed: list[tuple[Points, Pose | None]],
    gravity: Gravity,
    settings: SegmentationSettings,
    *,
    n_deviations: float = 4.0,
) -> float | None:
    """Return so many robust standard deviations of inverse depth, 1/m, on supports; None = none.

    Over a whole plane they hold what bends it too, not only what differs between neighbours.
    """
    deviations: list[float] = []
    for points, pose in observed:
        planes = _planes_in(points, pose, gravity, settings)
        sizes = [np.count_nonzero(plane.inliers) for plane in planes]
        for plane, size in zip(planes, sizes, strict=True):
            # Lids of a few points, of several heights, tell more of themselves than of the sensor.
            if size >= MIN_TELLING * max(sizes):
                xyz = points.xyz[plane.inliers]
                deviation = np.median(np.abs(plane.distance(xyz)) / xyz[:, 2] ** 2)
                deviations.append(1.4826 * float(deviation))
    return n_deviations * float(np.median(deviations)) if deviations else None


def _planes_in(
    points: Points, pose: Pose | None, gravity: Gravity, settings: SegmentationSettings
) -> list[Plane]:
    """Return the horizontal planes of a frame, with or without a pose that tells what that is."""
    up: Array | None
    if pose is not None and gravity.up_world is not None:
        up = pose[:3, :3].T @ gravity.up_world
    else:
        prior = CAMERA_UP_PRIOR
        if gravity.up_camera is not None:
            prior = rotation_of(turns_upright(gravity.up_camera)) @ gravity.up_camera
        votes = votes_on_up(points, settings.max_range)
        up = up_from_normals(points.normals[votes > 0], votes[votes > 0], prior=prior)
    return find_planes(points, up, settings) if up is not None else []


def _looks_like_table(points: Points, lowest: Plane) -> bool:
    """Tell a table by what lies below its plane, or by ending near with nothing beyond."""
    seen = np.isfinite(points.depth)
    depth = points.depth[seen]
    reach = np.percentile(points.depth[lowest.inliers], 95)
    ends_near = reach < 2.0 and np.percentile(depth, 95) < 1.15 * reach
    return share_below(points, lowest) > 0.03 or bool(ends_near)
