"""What the frames of a recording tell together: which way is up, and where the floor is."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Pose
from curiosight.teacher.cloud.outline import find_outline
from curiosight.teacher.cloud.planes import Plane, noise_band
from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.up import CAMERA_UP_PRIOR, up_from_normals, world_up
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.supports import PLANE_BAND, Scene, find_planes, share_below
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.supports.table_map import MARGIN, Table, level_surface, map_tables
from curiosight.teacher.walls.wall_map import join_walls, moved
from curiosight.teacher.walls.walls import find_walls

Array = npt.NDArray[Any]
SCENES = ("auto", "floor", "table")


def survey_recording(
    frames: Iterable[Frame],
    settings: SegmentationSettings | None = None,
    *,
    scene: str = "auto",
) -> Survey:
    """Look at some frames of a recording and find what they share.

    scene: "auto" calls the lowest support a table where the camera sees below it, or nothing
        beyond it. With poses the floor's height is found too, so that it stays known where
        tables hide it.
    """
    if scene not in SCENES:
        raise ValueError(f"scene: expected one of {', '.join(SCENES)}, got {scene!r}")
    settings = settings or SegmentationSettings()
    observed = [(_observe(frame), frame.T_world_camera) for frame in frames if _can_teach(frame)]
    posed = [(points, pose) for points, pose in observed if pose is not None]
    up = world_up(posed) if len(posed) >= 3 else None
    noise = _noise_on_planes(observed, up, settings)
    settings = settings.for_sensor(noise)
    outline = find_outline(points for points, _ in observed) if observed else None
    floor = None
    if up is not None:
        up, heights, areas = _world_supports(posed, up, settings)
        floor = _lowest_peak(heights, areas)
        if scene == "auto" and floor is not None and heights.max() - floor > 0.3:
            scene = "floor"
    if scene == "auto":
        scene = _scene_of(observed, up, settings)
    if scene == "table" or up is None or floor is None:
        return Survey("table" if scene == "table" else "floor", up, noise=noise, outline=outline)
    tables = _tables(posed, up, floor, settings)
    walls = _walls(posed, up, floor, tables, settings)
    return Survey("floor", up, floor, tables, walls, noise, outline)


def _can_teach(frame: Frame) -> bool:
    has_depth = frame.depth is not None and bool(np.isfinite(frame.depth).any())
    return has_depth and frame.problem is None


def _observe(frame: Frame) -> Points:
    assert frame.depth is not None
    assert frame.camera is not None
    # Large images are looked at on the grid of one with 640 columns.
    return observe_points(frame.depth, frame.camera, stride=max(2, frame.camera.width // 320))


def _world_supports(
    posed: list[tuple[Points, Pose]], up: Array, settings: SegmentationSettings
) -> tuple[Array, Array, Array]:
    """Refine the world's up by the supports' own normals, twice.

    Return it with the height and the visible area of every support of every frame.
    """
    heights: list[float] = []
    areas: list[float] = []
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


def _tables(
    posed: list[tuple[Points, Pose]], up: Array, floor: float, settings: SegmentationSettings
) -> tuple[Table, ...]:
    level: list[Array] = []
    seen: list[Array] = []
    for points, T_world_camera in posed:
        rotation, centre = T_world_camera[:3, :3], T_world_camera[:3, 3]
        surface = level_surface(points, rotation.T @ up, settings.noise)
        for found, xyz in ((level, surface), (seen, points.xyz.reshape(-1, 3))):
            found.append(xyz[xyz[:, 2] < settings.max_range] @ rotation.T + centre)
    return map_tables(
        np.concatenate(level),
        np.concatenate(seen),
        up,
        floor,
        min_area=settings.min_table_area,
        min_diagonal=settings.min_table_diagonal,
    )


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
    up_world: Array | None,
    settings: SegmentationSettings,
) -> Scene:
    """Return what the lowest support is in most frames."""
    votes = []
    for points, pose in observed:
        planes = _planes_in(points, pose, up_world, settings)
        if planes:
            votes.append(_looks_like_table(points, max(planes, key=lambda plane: plane.offset)))
    return "table" if votes and np.mean(votes) > 0.5 else "floor"


def _noise_on_planes(
    observed: list[tuple[Points, Pose | None]],
    up_world: Array | None,
    settings: SegmentationSettings,
    *,
    n_deviations: float = 4.0,
) -> float | None:
    """Return so many robust standard deviations of inverse depth, 1/m, on supports; None = none.

    Over a whole plane they hold what bends it too, not only what differs between neighbours.
    """
    deviations = []
    for points, pose in observed:
        for plane in _planes_in(points, pose, up_world, settings):
            xyz = points.xyz[plane.inliers]
            deviations.append(1.4826 * np.median(np.abs(plane.distance(xyz)) / xyz[:, 2] ** 2))
    return n_deviations * float(np.median(deviations)) if deviations else None


def _planes_in(
    points: Points, pose: Pose | None, up_world: Array | None, settings: SegmentationSettings
) -> list[Plane]:
    """Return the horizontal planes of a frame, with or without a pose that tells what that is."""
    up: Array | None
    if pose is not None and up_world is not None:
        up = pose[:3, :3].T @ up_world
    else:
        keep = points.area > 0
        up = up_from_normals(points.normals[keep], points.area[keep], prior=CAMERA_UP_PRIOR)
    return find_planes(points, up, settings) if up is not None else []


def _looks_like_table(points: Points, lowest: Plane) -> bool:
    """Tell a table by what lies below its plane, or by ending near with nothing beyond."""
    seen = np.isfinite(points.depth)
    depth = points.depth[seen]
    reach = np.percentile(points.depth[lowest.inliers], 95)
    ends_near = reach < 2.0 and np.percentile(depth, 95) < 1.15 * reach
    return share_below(points, lowest) > 0.03 or bool(ends_near)
