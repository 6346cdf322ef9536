"""Check that a dataset keeps the contract of `Dataset`: ours and users' own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath, PureWindowsPath

import numpy as np

from curiosight.datasets.dataset import Dataset
from curiosight.frame import Camera, Frame, Pose, is_rigid

MEMBERS = (
    *("name", "ids", "poses", "camera", "has_depth", "remarks"),
    *("__len__", "__getitem__", "has_ground_truth", "ground_truth"),
)
PLAUSIBLE_DEPTH = (0.05, 50.0)
TRUTH_VALUES = (0, 125, 255)
# Several scans may be of several phones; what is farther off is another size of images.
FOCUS_BREATHING = 0.3


def check_dataset(dataset: Dataset, *, n_frames: int = 5) -> None:
    """Raise `ValueError` that names the first breach of the contract, if there is any.

    Looks at all names and poses, and at `n_frames` frames spread over the recording.
    """
    for member in MEMBERS:
        _require(hasattr(dataset, member), member, "a member of the dataset", "none")
    _require(len(dataset) > 0, "len", "at least one frame", "0")
    _check_ids(dataset)
    _check_poses(dataset)
    if dataset.has_depth:
        _require(dataset.camera is not None, "camera", "intrinsics beside depth", "None")
    indices = np.unique(np.linspace(0, len(dataset) - 1, n_frames).round().astype(int)).tolist()
    frames = [dataset[index] for index in indices]
    for index, frame in zip(indices, frames, strict=True):
        _check_frame(dataset, index, frame)
        _check_ground_truth(dataset, index, frame)
    if dataset.has_depth:
        check_depth_unit(frames)
    _check_repeats(dataset, indices[0], frames[0])


def _require(is_kept: bool, what: str, expected: str, got: object) -> None:
    if not is_kept:
        raise ValueError(f"{what}: expected {expected}, got {got}")


def _check_ids(dataset: Dataset) -> None:
    ids = dataset.ids
    _require(len(ids) == len(dataset), "ids", f"{len(dataset)}, one a frame", len(ids))
    seen: set[str] = set()
    for id in ids:
        _require(isinstance(id, str) and id != "", "ids", "a name for every frame", repr(id))
        _require(id not in seen, "ids", "unique names", f"{id!r} twice")
        seen.add(id)
        posix, windows = PurePosixPath(id), PureWindowsPath(id)
        is_inside = not (posix.is_absolute() or windows.anchor or ".." in posix.parts)
        is_plain = "\\" not in id and posix.as_posix() == id and id.isprintable()
        _require(is_inside and is_plain, "ids", "safe relative file names", repr(id))


def _check_poses(dataset: Dataset) -> None:
    poses = dataset.poses
    _require(len(poses) == len(dataset), "poses", f"{len(dataset)}, one a frame", len(poses))
    for id, pose in zip(dataset.ids, poses, strict=True):
        is_good = pose is None or is_rigid(np.asarray(pose, np.float64))
        _require(is_good, f"poses of {id}", "None or a rigid (4, 4) matrix", pose)


def _check_frame(dataset: Dataset, index: int, frame: Frame) -> None:
    id = dataset.ids[index]
    _require(isinstance(frame, Frame), f"frame {id}", "a Frame", type(frame).__name__)
    _require(frame.id == id, f"frame {id}", "the id listed in `ids`", repr(frame.id))
    is_same = _same_pose(frame.T_world_camera, dataset.poses[index])
    _require(is_same, f"pose of {id}", "the one listed in `poses`", frame.T_world_camera)
    has_depth = frame.depth is not None
    _require(
        has_depth == dataset.has_depth,
        f"depth of {id}",
        f"{'an array' if dataset.has_depth else 'None'}, as `has_depth` says",
        "an array" if has_depth else "None",
    )
    if dataset.camera is not None:
        size = (dataset.camera.height, dataset.camera.width)
        got = frame.rgb.shape[:2]
        _require(got == size, f"rgb of {id}", f"{size} (H, W) as `camera` says", got)
        # Phones focus, so that each image has a camera of its own; its field of view is the same.
        is_like = frame.camera is not None and _is_like(frame.camera, dataset.camera)
        _require(is_like, f"camera of {id}", "the dataset's, or nearly", frame.camera)
    check_readings(frame)


def check_readings(frame: Frame) -> None:
    """Raise `ValueError` where depth says "no reading" with anything but NaN."""
    if frame.depth is None:
        return
    readings = frame.depth[~np.isnan(frame.depth)]
    is_metric = bool(np.isfinite(readings).all() and (readings > 0).all())
    expected = "positive metres, NaN where there is no reading"
    _require(is_metric, f"depth of {frame.id}", expected, "zero, negative or infinite values")


def check_depth_unit(frames: Sequence[Frame]) -> None:
    """Raise `ValueError` where the frames' depth cannot be in metres."""
    readings = [
        frame.depth[np.isfinite(frame.depth)] for frame in frames if frame.depth is not None
    ]
    pooled = np.concatenate(readings) if readings else np.empty(0)
    if pooled.size == 0:
        return
    median = float(np.median(pooled))
    low, high = PLAUSIBLE_DEPTH
    expected = f"metres, with a median between {low} and {high}"
    _require(low <= median <= high, "depth", expected, f"{median:g}: is it in millimetres?")


def _check_ground_truth(dataset: Dataset, index: int, frame: Frame) -> None:
    what = f"ground truth of {dataset.ids[index]}"
    truth = dataset.ground_truth(index)
    is_promised = bool(dataset.has_ground_truth(index))
    expected = "as `has_ground_truth` says"
    _require(is_promised == (truth is not None), what, expected, "otherwise")
    if truth is None:
        return
    size = frame.rgb.shape[:2]
    is_image = truth.shape == size and truth.dtype == np.uint8
    _require(is_image, what, f"{size} uint8", f"{truth.shape} {truth.dtype}")
    strange = np.setdiff1d(truth, TRUTH_VALUES)
    _require(strange.size == 0, what, "values 0, 125 and 255 only", strange[:5])


def _check_repeats(dataset: Dataset, index: int, first: Frame) -> None:
    second = dataset[index]
    is_same = np.array_equal(first.rgb, second.rgb)
    if first.depth is not None and second.depth is not None:
        is_same = is_same and np.array_equal(first.depth, second.depth, equal_nan=True)
    _require(is_same, f"frame {first.id}", "the same at every reading", "another image")


def _is_like(camera: Camera, other: Camera) -> bool:
    """Tell whether two cameras have images of one size and nearly the same field of view."""
    if (camera.width, camera.height) != (other.width, other.height):
        return False
    focal = max(camera.fx / other.fx, other.fx / camera.fx, camera.fy / other.fy)
    focal = max(focal, other.fy / camera.fy)
    shift = max(abs(camera.cx - other.cx) / camera.width, abs(camera.cy - other.cy) / camera.height)
    return focal < 1 + FOCUS_BREATHING and shift < FOCUS_BREATHING


def _same_pose(a: Pose | None, b: Pose | None) -> bool:
    if a is None or b is None:
        return a is None and b is None
    return bool(np.array_equal(a, b))
