"""Read `scene_camera.json` of a BOP scene: intrinsics, unit of depth and pose of each image."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.errors.inputs import read_text
from curiosight.frame import Pose, is_rigid

FILE_NAME = "scene_camera.json"
METRES_PER_MILLIMETRE = 0.001


@dataclass(frozen=True, slots=True, eq=False)
class BopView:
    """What the file says of an image.

    intrinsics: fx, fy, cx, cy in pixels. depth_scale: metres per unit, None = not given.
    T_world_camera: None = not given, or no rigid pose; `problem` tells the latter.
    """

    intrinsics: tuple[float, float, float, float]
    depth_scale: float | None
    T_world_camera: Pose | None
    problem: str | None


def read_scene_camera(path: Path) -> dict[int, BopView]:
    """Map image numbers to what the file says of them; `DataError` if it is no good."""
    try:
        content = json.loads(read_text(path))
    except (OSError, ValueError, RecursionError) as error:
        raise DataError(path, f"is not valid JSON ({error})", "copy the scene again") from None
    if not isinstance(content, dict):
        found = f"holds a {type(content).__name__}, not an object"
        raise DataError(path, found, "copy the scene again")
    views = {}
    for key, values in content.items():
        if not key.isdecimal() or not isinstance(values, dict):
            remedy = 'expected a number and an object, such as "0": {"cam_K": [...]}'
            raise DataError(path, f'image "{key}" is no image of BOP', remedy)
        views[int(key)] = _view(path, key, values)
    return views


def _view(path: Path, key: str, values: dict[str, Any]) -> BopView:
    K = _numbers(path, key, values, "cam_K", 9)
    if K is None:
        raise DataError(path, f'image "{key}" has no cam_K', "give its 9 numbers, row by row")
    if not (K[0] > 0 and K[4] > 0):
        raise DataError(path, f'cam_K of image "{key}" is no camera', "correct its focal lengths")
    scale = _numbers(path, key, values, "depth_scale", 1)
    if scale is not None and not scale[0] > 0:
        found = f'depth_scale of image "{key}" is {scale[0]:g}'
        raise DataError(path, found, "expected millimetres per unit, above 0")
    pose, problem = _T_world_camera(
        _numbers(path, key, values, "cam_R_w2c", 9), _numbers(path, key, values, "cam_t_w2c", 3)
    )
    return BopView(
        intrinsics=(float(K[0]), float(K[4]), float(K[2]), float(K[5])),
        depth_scale=None if scale is None else float(scale[0]) * METRES_PER_MILLIMETRE,
        T_world_camera=pose,
        problem=problem,
    )


def _T_world_camera(  # noqa: N802
    rotation: npt.NDArray[np.float64] | None, translation: npt.NDArray[np.float64] | None
) -> tuple[Pose | None, str | None]:
    """Invert world to camera, in millimetres; return the pose, or the problem."""
    if rotation is None or translation is None:
        return None, None
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = rotation.reshape(3, 3).T
    T_world_camera[:3, 3] = -T_world_camera[:3, :3] @ translation * METRES_PER_MILLIMETRE
    if not is_rigid(T_world_camera):
        return None, f"its cam_R_w2c and cam_t_w2c in {FILE_NAME} are not a rigid pose"
    return T_world_camera, None


def _numbers(
    path: Path, key: str, values: dict[str, Any], name: str, n_numbers: int
) -> npt.NDArray[np.float64] | None:
    """Return the finite numbers under a name; None where the name is missing."""
    if name not in values:
        return None
    try:
        numbers = np.asarray(values[name], np.float64).ravel()
    except (TypeError, ValueError, OverflowError):
        numbers = np.empty(0)
    if len(numbers) != n_numbers or not np.isfinite(numbers).all():
        expected = "a number" if n_numbers == 1 else f"{n_numbers} numbers"
        raise DataError(path, f'{name} of image "{key}" is malformed', f"expected {expected}")
    return numbers
