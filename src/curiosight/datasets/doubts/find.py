"""Look at some frames of a recording and say what contradicts what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from curiosight.datasets.dataset import Dataset
from curiosight.datasets.depth_bits import ROTATION
from curiosight.datasets.depth_files import rotate_right
from curiosight.datasets.doubts.doubt import Doubt
from curiosight.datasets.doubts.motion import (
    MIN_SHARE_MET,
    Numbers,
    Reading,
    Verdict,
    judge_motion,
)
from curiosight.datasets.doubts.outlines import find_misplacement
from curiosight.datasets.doubts.unit import (
    KINECT_STEP,
    DepthFacts,
    likelier_factor,
    likelihood,
    measured_range,
)
from curiosight.datasets.doubts.values import (
    StoredDepth,
    disparity_step,
    has_rotated_bits,
    stored_depth,
)
from curiosight.frame import Camera, Depth, Frame, Pose, is_rigid
from curiosight.frame.rotations import matrix_of, quaternion_of

# Frames that are opened together differ from their first by these shares of the trajectory's
# extent or by these angles; the nearest in time is taken.
EXTENT_SHARES, ANGLES_DEG = (0.06, 0.15), (6.0, 15.0)
MIN_READINGS = 1000
FEW_FRAMES = 4
# Where motion says that units of depth and position differ, how much worse (as a log-likelihood)
# depth may look for it to be at fault nevertheless.
UNIT_BEFORE_POSITIONS = 4.0
# Of the principal point to the image's middle, 1 = at the edge; a crop may move it a little.
MAX_OFF_CENTRE = 0.5
# Of what one frame sees, where another sees it: rotations of another order explain less.
MAX_SHARE_GIVEN = 0.6
W_FIRST_HEADER = '"# stamp tx ty tz qw qx qy qz"'
AXIS_NAMES = (("right", "left"), ("down", "up"), ("forward", "backward"))


def find_doubts(dataset: Dataset, *, n_frames: int = 12) -> list[Doubt]:
    """Return what contradicts camera, unit, bits, poses or registration of a recording.

    Nothing where none shows. Opens up to `n_frames` frames. One cause gives one doubt: where the
    unit is wrong, the poses that it contradicts are not doubted as well.
    """
    if n_frames < 1:
        raise ValueError(f"n_frames: expected at least 1, got {n_frames}")
    if not dataset.has_depth:
        return []
    return [*_camera_doubts(dataset.camera), *_frame_doubts(dataset, n_frames)]


def _camera_doubts(camera: Camera | None) -> list[Doubt]:
    """Return a doubt about intrinsics whose principal point is far from the image's middle."""
    if camera is None:
        return []
    off = abs(2 * camera.cx / camera.width - 1), abs(2 * camera.cy / camera.height - 1)
    if max(off) <= MAX_OFF_CENTRE:
        return []
    text = (
        f"the principal point ({camera.cx:.6g}, {camera.cy:.6g}) is far from the middle of the "
        f"{camera.width}x{camera.height} images: the intrinsics may be for another size"
    )
    return [Doubt("camera", text, "camera.json")]


def _frame_doubts(dataset: Dataset, n_frames: int) -> list[Doubt]:
    """Return what contradicts unit, bits or poses in some frames."""
    frames = [dataset[index] for index in choose_frames(dataset.poses, n_frames)]
    frames = [frame for frame in frames if _n_readings(frame) >= MIN_READINGS]
    if not frames:
        return []
    depths = [frame.depth for frame in frames if frame.depth is not None]
    scale: float | None = getattr(dataset, "depth_scale", None)
    stored = stored_depth([depth[::2] for depth in depths], scale)
    if stored is not None and has_rotated_bits(stored):
        return [_rotated(stored)]
    verdict = judge_motion(frames)
    doubts = _unit_doubts(_facts(depths, stored), verdict, scale)
    if verdict is not None and verdict.best is not None and not verdict.best.is_plain:
        doubts.append(_poses_doubt(verdict, verdict.best))
    doubts = doubts or _left_handed(frames) or _quaternion_doubts(frames, verdict)
    # Depth that is registered while it is read lands beside colour where its unit is wrong.
    is_explained = _is_registered_here(dataset) and any(doubt.code == "unit" for doubt in doubts)
    # Half of many frames are enough to see outlines in.
    frames = frames[:: 1 + (len(frames) > 2 * FEW_FRAMES)]
    return doubts if is_explained else [*doubts, *_registration_doubts(frames)]


def choose_frames(poses: Sequence[Pose | None], n_frames: int) -> list[int]:
    """Return up to `n_frames` indices: groups of three that see the same from different places."""
    posed = [index for index, pose in enumerate(poses) if pose is not None]
    if len(poses) <= n_frames or len(posed) < 3 or n_frames < 3:
        return sorted(set(np.linspace(0, len(poses) - 1, n_frames).round().astype(int).tolist()))
    matrices = np.array([np.asarray(poses[index], np.float64) for index in posed])
    extent = 2 * float(np.linalg.norm(matrices[:, :3, 3].std(axis=0)))
    chosen: set[int] = set()
    for first in np.linspace(0, len(posed) - 1, n_frames // 3).round().astype(int):
        turned = np.einsum("ij,nij->n", matrices[first, :3, :3], matrices[:, :3, :3])
        angles = np.degrees(np.arccos(((turned - 1) / 2).clip(-1, 1)))
        moved = np.linalg.norm(matrices[:, :3, 3] - matrices[first, :3, 3], axis=1)
        later = np.abs(np.arange(len(posed)) - first)
        chosen.add(posed[first])
        for angle, share in zip(ANGLES_DEG, EXTENT_SHARES, strict=True):
            differs = (angles >= angle) | (moved > share * extent)
            differs[first] = False
            if differs.any():
                chosen.add(posed[int(np.where(differs, later, len(posed)).argmin())])
    return sorted(chosen)


def _is_registered_here(dataset: Dataset) -> bool:
    cameras = [getattr(entry, "depth_camera", None) for entry in getattr(dataset, "entries", ())]
    return any(camera is not None for camera in (getattr(dataset, "depth_camera", None), *cameras))


def _n_readings(frame: Frame) -> int:
    return 0 if frame.depth is None else int(np.count_nonzero(frame.depth > 0))


def _facts(depths: Sequence[Depth], stored: StoredDepth | None) -> DepthFacts:
    # One reading in 16 is enough for percentiles.
    readings = np.concatenate([depth[::4, ::4].ravel() for depth in depths])
    nearest, median, farthest = measured_range(readings[readings > 0])
    return DepthFacts(
        nearest,
        median,
        farthest,
        None if stored is None else stored.quantum,
        None if stored is None else disparity_step(stored),
        depths[0].shape[1],
    )


def _rotated(stored: StoredDepth) -> Doubt:
    image = stored.images[0]
    turned = rotate_right(image.astype(np.uint16), ROTATION)
    metres = np.median(turned[image > 0]) * stored.scale
    text = (
        "depth is smooth only after its 16 bits are turned back by three: then its median is "
        f"{metres:.3g} m, not {np.median(image[image > 0]) * stored.scale:.3g} m"
    )
    return Doubt("bits", text, "--fix-units")


def _unit_doubts(facts: DepthFacts, verdict: Verdict | None, scale: float | None) -> list[Doubt]:
    """Return a doubt about the unit of depth or of positions, if there is one."""
    if verdict is None or verdict.best is None:
        if verdict is not None and verdict.knows_unit:
            return []
        factor = likelier_factor(facts)
        return [] if factor is None else [_unit_doubt(facts, factor, scale, "")]
    ratio = verdict.best.ratio
    if ratio == 1:
        return []
    explained = f"; with the poses {_shares(verdict)}"
    # Nobody writes positions in fifths of a metre, but in millimetres.
    bonus = UNIT_BEFORE_POSITIONS if 0.05 < ratio < 20 else 0.0
    if likelihood(facts, ratio) + bonus >= likelihood(facts, 1.0):
        return [_unit_doubt(facts, ratio, scale, explained)]
    text = f"positions are {1 / ratio:g} times what depth says{explained}"
    return [Doubt("poses-unit", text, "--fix-units", 1 / ratio)]


def _unit_doubt(facts: DepthFacts, factor: float, scale: float | None, explained: str) -> Doubt:
    text = (
        f"depth as read is {facts.nearest:.3g} to {facts.farthest:.3g} m, "
        f"its median {facts.median:.3g} m"
    )
    if facts.quantum is not None:
        text += f", in steps of {1000 * facts.quantum:.3g} mm"
    if facts.step is not None:
        text += f" that grow with {facts.step:.2g} z² (a Kinect's: {KINECT_STEP:.2g} z²)"
    text += f"{explained}: {factor:g} times that is far likelier"
    fix = "--fix-units" if scale is None else f"--depth-scale {scale * factor:.6g}"
    return Doubt("unit", text, fix, factor)


def _poses_doubt(verdict: Verdict, best: Reading) -> Doubt:
    axes = ",".join(_axis_names(best.axes))
    is_turned = not bool((best.axes == np.eye(3)).all())
    fixes = ["--invert-poses"] * best.is_inverted + [f"--pose-axes {axes}"] * is_turned
    if is_turned:
        code = "poses-mirrored" if np.linalg.det(best.axes) < 0 else "poses-axes"
        meant = f"camera axes {axes}" + " and world to camera" * best.is_inverted
    else:
        code, meant = "poses-inverted", "world to camera"
    return Doubt(code, f"poses seem to be {meant}: {_shares(verdict)}", " ".join(fixes))


def _quaternion_doubts(frames: Sequence[Frame], given: Verdict | None) -> list[Doubt]:
    """Return a doubt where rotations fit depth only if their quaternions were w, x, y, z."""
    share_given = 0.0 if given is None else given.share_given
    if share_given >= MAX_SHARE_GIVEN or sum(f.T_world_camera is not None for f in frames) < 2:
        return []
    read = judge_motion([_with_w_first(frame) for frame in frames])
    if read is None or not read.knows_unit or read.share_given < MIN_SHARE_MET:
        return []
    text = (
        f"quaternions seem to be w, x, y, z: {100 * read.share_given:.0f} % of what one frame sees "
        f"is where another sees it if so read, {100 * share_given:.0f} % as given; begin the file "
        f"of poses with the line {W_FIRST_HEADER}"
    )
    return [Doubt("poses-quaternion", text, W_FIRST_HEADER)]


def _with_w_first(frame: Frame) -> Frame:
    """Return a frame whose pose is read as if its quaternion stood as w, x, y, z."""
    given = frame.T_world_camera
    if given is None or not is_rigid(given):
        return replace(frame, T_world_camera=None)
    pose = np.asarray(given, np.float64).copy()
    quaternion = quaternion_of(pose[:3, :3])
    pose[:3, :3] = matrix_of(np.roll(quaternion, -1))
    return replace(frame, T_world_camera=pose)


def _shares(verdict: Verdict) -> str:
    return (
        f"{100 * verdict.share_best:.0f} % of what one frame sees is where another sees it "
        f"if so read, {100 * verdict.share_given:.0f} % as given"
    )


def _axis_names(axes: Numbers) -> list[str]:
    """Name the recording's camera axes by ours."""
    columns = np.abs(axes).argmax(axis=1)
    return [AXIS_NAMES[k][int(axes[row, k] < 0)] for row, k in enumerate(columns)]


def _left_handed(frames: Sequence[Frame]) -> list[Doubt]:
    """Return a doubt where poses mirror space although the frames agree with each other."""
    poses = [frame.T_world_camera for frame in frames if frame.T_world_camera is not None]
    determinants = [float(np.linalg.det(pose[:3, :3])) for pose in poses]
    if not determinants or np.median(determinants) > 0:
        return []
    text = f"poses mirror space: the determinant of their rotations is {min(determinants):.3g}"
    return [Doubt("poses-mirrored", text, "--pose-axes right,up,forward")]


def _registration_doubts(frames: Sequence[Frame]) -> list[Doubt]:
    """Return a doubt where outlines in depth lie beside those in colour."""
    found = find_misplacement(frames)
    if found is None:
        return []
    right, down = found.shift_px
    moves = [f"scaled by {found.scale:.2f} about the middle"] * (found.scale != 1)
    moves += [f"moved by {right:.0f}, {down:.0f} pixels (right, down)"] * bool(right or down)
    text = (
        f"depth is not registered to colour: its outlines lie {found.distance_px:.0f} pixels "
        f"beside colour's; {' and '.join(moves)} they agree by {found.best:.2f}, "
        f"as given by {found.given:.2f} (1 perfect, 0 chance)"
    )
    return [Doubt("registration", text, "--depth-camera FILE")]
