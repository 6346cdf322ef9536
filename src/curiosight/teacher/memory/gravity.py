"""Which way is up in a recording, however its camera is held.

A floor and a wall look alike to depth: each is a plane with nothing behind it. What tells them
apart is what stands on them. So every direction that may be up is tried: under the right one most
of what is in view is floor, table, wall, or a thing that stands; under a wrong one things hang in
the air.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label, Mount, Pose
from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.cloud.up import (
    CAMERA_UP_PRIOR,
    directions_of,
    up_from_normals,
    votes_on_up,
)
from curiosight.teacher.settings import SegmentationSettings
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.teacher import Teacher
from curiosight.teacher.turning import rotation_of

Array = npt.NDArray[Any]
Held = Mount | Literal["auto"]
# About where up is in the camera's frame, if it points so in the image: to one of its sides, or
# towards the camera, which then looks straight down, or away from it.
UP_OF_MOUNT: dict[Mount, Array] = {
    "up": CAMERA_UP_PRIOR,
    "right": rotation_of(1).T @ CAMERA_UP_PRIOR,
    "down": rotation_of(2).T @ CAMERA_UP_PRIOR,
    "left": rotation_of(3).T @ CAMERA_UP_PRIOR,
    "towards": np.array([0.0, 0.0, -1.0]),
    "away": np.array([0.0, 0.0, 1.0]),
}
DOUBT = (
    "it is not clear which way is up: a wall ahead, or a floor or table from straight above "
    "(--up says it)"
)
# Of the surface points of a frame, so many speak for all.
STRIDE = 8
# So many frames are tried.
N_TRIED = 8
# Of a frame's readings; where floors explain less, or nothing stands, tables are tried too.
WELL_EXPLAINED = 0.6
# Most cameras are held upright: by so much more another way must explain what is in view.
UPRIGHT_BONUS = 0.25
# Cameras that see walls ahead are far more frequent than those that look straight down.
MAX_EXPLAINED_OTHERWISE = 0.6
# What stands is less than what it stands on, and tells more.
STANDING_WEIGHT = 3.0
# A picture on a wall is like a box on a table seen from above. Nearer than this, metres, a camera
# is over a table; and straight above is within this angle.
MAX_OVERHEAD, MAX_FROM_STRAIGHT = 1.3, np.radians(30)
# Share of a frame's readings that stand on something, for that to be seen; and of the frames.
MIN_STANDING, MIN_SHOWING = 0.003, 0.25


@dataclass(frozen=True, slots=True)
class Gravity:
    """Which way is up: `up_world`, `up_camera` and `doubt` as in `Survey`."""

    up_world: Array | None = None
    up_camera: Array | None = None
    doubt: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """What a direction explains: (n,) shares of each frame's readings within the range.

    known: floor, table, wall or object. standing: object.
    """

    gravity: Gravity
    known: Array
    standing: Array

    @property
    def score(self) -> float:
        """What stands counts more: it is what tells up from aside."""
        return float(np.mean(self.known) + STANDING_WEIGHT * np.mean(self.standing))

    @property
    def shows_things(self) -> bool:
        return float(np.mean(self.standing > MIN_STANDING)) >= MIN_SHOWING


def find_gravity(
    frames: Sequence[Frame], settings: SegmentationSettings, mount: Held = "auto"
) -> Gravity:
    """Return which way is up in the world where at least three frames have poses, else in view.

    frames: small ones do. mount: where up points in the image; "auto" = find out.
    """
    posed = [frame for frame in frames if frame.T_world_camera is not None]
    if len(posed) >= 3:
        return _in_world(posed, settings, mount)
    if mount != "auto":
        return Gravity(up_camera=UP_OF_MOUNT[mount])
    return _in_camera(frames, settings)


def _in_camera(frames: Sequence[Frame], settings: SegmentationSettings) -> Gravity:
    """Return the mount that explains most of what is in view."""
    some = _some(frames)
    if not some:
        return Gravity()
    unposed = [replace(frame, T_world_camera=None) for frame in some]
    trials = {
        name: _try(Gravity(up_camera=up), unposed, settings)
        for name, up in UP_OF_MOUNT.items()
        if name != "away"
    }
    overhead, upright = trials.pop("towards"), trials["up"]
    held = max(
        trials.values(),
        key=lambda trial: (1 + UPRIGHT_BONUS * (trial is upright)) * trial.score,
    )
    best = overhead if held.score < MAX_EXPLAINED_OTHERWISE * overhead.score else held
    if best is upright or best.score == 0:
        return Gravity()
    is_clear = best.shows_things and (best is not overhead or _is_near(some))
    return best.gravity if is_clear else Gravity(doubt=DOUBT)


def _in_world(posed: Sequence[Frame], settings: SegmentationSettings, mount: Held) -> Gravity:
    """Return the direction that many surfaces face and that explains most of what is in view."""
    observed = [(observe(one), one.T_world_camera) for one in posed]
    known = [(points, pose) for points, pose in observed if pose is not None]
    normals, votes = surfaces_of(known, settings.max_range)
    if mount != "auto":
        return Gravity(up_world=_near_mount(posed, normals, votes, UP_OF_MOUNT[mount]))
    some = _some(posed)
    best, most = None, 0.0
    for up in directions_of(normals, votes):
        trial = _try(Gravity(up_world=up), some, settings)
        score = (1 + UPRIGHT_BONUS * _share_upright(up, posed)) * trial.score
        if score > most:
            best, most = trial, score
    if best is None or best.gravity.up_world is None:
        return Gravity()
    up = best.gravity.up_world
    is_overhead = _share_held(up, posed, UP_OF_MOUNT["towards"], MAX_FROM_STRAIGHT) > 0.5
    is_clear = best.shows_things and (not is_overhead or _is_near(some))
    return best.gravity if is_clear or _share_upright(up, posed) > 0.5 else Gravity(doubt=DOUBT)


def _share_upright(up_world: Array, posed: Iterable[Frame]) -> float:
    """Return the share of frames whose camera is held upright if that is up."""
    return _share_held(up_world, posed, CAMERA_UP_PRIOR, np.radians(45))


def _share_held(up_world: Array, posed: Iterable[Frame], prior: Array, max_angle: float) -> float:
    """Return the share of frames in which up is within an angle of (3,) `prior`."""
    poses = [frame.T_world_camera for frame in posed if frame.T_world_camera is not None]
    ups = np.array([pose[:3, :3].T @ up_world for pose in poses])
    return float(np.mean(ups @ prior > np.cos(max_angle)))


def _is_near(frames: Iterable[Frame]) -> bool:
    """Tell whether frames show what is as near as a table is to an arm."""
    depths = [np.nanmedian(frame.depth) for frame in frames if frame.depth is not None]
    return float(np.median(depths)) < MAX_OVERHEAD


def _near_mount(posed: Iterable[Frame], normals: Array, votes: Array, prior: Array) -> Array | None:
    """Return what the surfaces face, about where cameras held so have up; None = they differ."""
    poses = [frame.T_world_camera for frame in posed if frame.T_world_camera is not None]
    mean = np.mean([pose[:3, :3] @ prior for pose in poses], axis=0)
    length = float(np.linalg.norm(mean))
    return None if length < 0.3 else up_from_normals(normals, votes, prior=mean / length)


def surfaces_of(observed: Iterable[tuple[Points, Pose]], max_range: float) -> tuple[Array, Array]:
    """Return (n, 3) float32 normals in the world, of some of the points, and (n,) their votes."""
    normals, votes = [], []
    for points, T_world_camera in observed:
        weights = votes_on_up(points, max_range).ravel()
        where = np.flatnonzero(weights)[::STRIDE]
        turn = T_world_camera[:3, :3].T.astype(np.float32)
        normals.append(points.normals_at(where) @ turn)
        votes.append(weights.take(where))
    return np.concatenate(normals), np.concatenate(votes)


def observe(frame: Frame) -> Points:
    """Return the points of a frame that has depth, all of them."""
    assert frame.depth is not None
    assert frame.camera is not None
    return observe_points(frame.depth, frame.camera, stride=1)


def _some(frames: Sequence[Frame]) -> list[Frame]:
    places = np.unique(np.linspace(0, len(frames) - 1, min(len(frames), N_TRIED)).astype(int))
    return [frames[place] for place in places]


def _try(gravity: Gravity, frames: Iterable[Frame], settings: SegmentationSettings) -> _Trial:
    """Return what is explained if that is up, by the better of floor and table."""
    coarse = replace(settings, stride=2 * settings.stride)
    survey = Survey("floor", up_world=gravity.up_world, up_camera=gravity.up_camera)
    as_floor = Teacher(survey, coarse)
    as_table = Teacher(replace(survey, scene="table"), coarse)
    shares = []
    for frame in frames:
        explained = _explained(as_floor, frame, settings.max_range)
        if explained[0] < WELL_EXPLAINED or explained[1] < MIN_STANDING:
            others = _explained(as_table, frame, settings.max_range)
            explained = tuple(np.maximum(explained, others))
        shares.append(explained)
    return _Trial(gravity, *np.array(shares).T)


def _explained(teacher: Teacher, frame: Frame, max_range: float) -> tuple[float, float]:
    assert frame.depth is not None
    labels = teacher.segment(frame).labels[frame.depth < max_range]
    n_standing = np.count_nonzero(labels == Label.SALIENT)
    n_known = n_standing + np.count_nonzero(labels == Label.NOT_SALIENT)
    return n_known / max(1, len(labels)), n_standing / max(1, len(labels))
