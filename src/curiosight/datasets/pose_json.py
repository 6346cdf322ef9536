"""Read poses from JSON: lists of matrices, matrices by name, NeRF's frames, Open3D's cameras."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.datasets.pose_text import MATRIX_SIZES, PoseRow, pose_of_matrix
from curiosight.errors.inputs import read_text
from curiosight.frame import Pose

MAX_BYTES = 100_000_000
MATRIX_KEYS = ("pose", "matrix", "camera_to_world", "cam2world", "c2w", "T_world_camera")
# NeRF's cameras look backward; Open3D writes world to camera.
NERF_KEY, OPEN3D_KEY = "transform_matrix", "extrinsic"
NERF_AXES = np.diag([1.0, -1.0, -1.0, 1.0])
NAME_KEYS = ("file_path", "file_name", "file", "image", "name", "timestamp", "frame_id", "id")


def read_json_poses(path: Path) -> list[PoseRow] | None:
    """Return the poses of a JSON file, in order, camera to world; None where it holds none.

    Matrices of 16 or 12 numbers, flat or nested, stand in a list, by the names of images, or in
    an object for each image. Those that NeRF's programs call `transform_matrix` have their axes
    turned to ours, and what Open3D calls `extrinsic` is inverted.
    """
    try:
        content = json.loads(read_text(path, "utf-8-sig", MAX_BYTES))
    except (OSError, ValueError, RecursionError):
        return None
    rows = list(_rows(content, None))
    is_told = any(row.pose is not None for row in rows)
    return rows if is_told else None


def _rows(content: Any, key: str | None, depth: int = 0) -> Iterator[PoseRow]:
    """Yield the poses inside; key: what the place is called that they stand at."""
    if depth > 3:
        return
    numbers = _numbers(content)
    if numbers is not None:
        yield PoseRow(key, pose_of_matrix(numbers))
    elif isinstance(content, list):
        for value in content:
            yield from _rows(value, None, depth + 1)
    elif isinstance(content, dict):
        row = _of_object(content, key)
        if row is not None:
            yield row
            return
        for name, value in content.items():
            yield from _rows(value, name, depth + 1)


def _of_object(content: dict[str, Any], key: str | None) -> PoseRow | None:
    """Return the pose of an object that holds one under a usual name."""
    found = ((k, _numbers(content.get(k))) for k in (*MATRIX_KEYS, NERF_KEY, OPEN3D_KEY))
    kind, numbers = next(((k, n) for k, n in found if n is not None), ("", None))
    if numbers is None:
        return None
    name = next((str(content[k]) for k in NAME_KEYS if k in content), key)
    pose: Pose | None = pose_of_matrix(numbers)
    if pose is not None and kind == NERF_KEY:
        pose = pose @ NERF_AXES
    if pose is not None and kind == OPEN3D_KEY:
        pose = np.linalg.inv(pose).astype(np.float64)
    return PoseRow(name, pose)


def _numbers(content: Any) -> list[float] | None:
    """Return the numbers of a matrix of 4x4 or 3x4, flat or in rows; None for anything else."""
    if not isinstance(content, list):
        return None
    rows = content if content and isinstance(content[0], list) else [content]
    if not all(isinstance(row, list) for row in rows):
        return None
    values = [value for row in rows for value in row]
    is_matrix = len(values) in MATRIX_SIZES and len(rows) in (1, 3, 4)
    if not is_matrix or not all(isinstance(v, int | float) for v in values):
        return None
    return [float(value) for value in values]
