"""Read the camera files of others: JSON, YAML, MATLAB, text; whatever their numbers are called."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_text import Leaves, read_leaves
from curiosight.datasets.cameras.key_names import (
    FOCAL_KEYS,
    MATRIX_KEYS,
    POSE_KEYS,
    SCALE_KEYS,
    SIZE_KEYS,
)
from curiosight.errors import DataError
from curiosight.frame import Camera, Pose, is_rigid

COLOUR = re.compile(r"colou?r|rgb")
DEPTH = re.compile(r"depth|(^|[_./-])ir($|[_./-])")
MAX_FOCAL_PX = 20_000.0
# Matrices have rows and columns too, but fewer.
MIN_SIDE = 16


@dataclass(frozen=True, slots=True)
class FoundCamera:
    """Intrinsics that a file of others holds.

    size: (width, height) that they are for; None = the file does not say.
    depth_scale: metres per unit; None = the file does not say.
    is_named: a name or the form of a matrix tells what the numbers are.
    """

    path: Path
    fx: float
    fy: float
    cx: float
    cy: float
    size: tuple[int, int] | None = None
    depth_scale: float | None = None
    is_named: bool = True

    def camera(self, size: tuple[int, int]) -> Camera:
        """Return the camera; size: (width, height) where the file does not say it.

        Raises `DataError` where the numbers are no camera.
        """
        width, height = self.size or size
        try:
            return Camera(width, height, self.fx, abs(self.fy), self.cx, self.cy)
        except ValueError as error:
            raise DataError(self.path, f"is no camera ({error})", "correct its numbers") from None


def read_intrinsics(path: Path, *, of_depth: bool = False) -> FoundCamera | None:
    """Return the intrinsics that a file holds, or None.

    of_depth: where it holds two cameras, those of the depth camera rather than the colour's.
    """
    leaves = read_leaves(path)
    numbers = _intrinsic_numbers(leaves, of_depth) if leaves else None
    if leaves is None or numbers is None:
        return None
    scale = next((_metres(n[0], leaves) for n in _values(leaves, SCALE_KEYS) if len(n) == 1), None)
    if scale is None:
        # So short a name may mean anything, but for a number that only depth is scaled by.
        factors = (n[0] for n in _values(leaves, ("scale",)) if len(n) == 1 and n[0] >= 100)
        scale = next((1 / factor for factor in factors), None)
    fx, fy, cx, cy, size = numbers
    is_list = [(place, len(n)) for place, n in leaves if n[:1] == [fx]] in ([("", 4)], [("", 8)])
    return FoundCamera(path, fx, fy, cx, cy, size, scale, is_named=not is_list)


def read_camera_and_pose(path: Path, size: tuple[int, int] | None) -> tuple[Camera, Pose | None]:
    """Return a depth camera and its `T_colour_depth`, None where the file does not say it.

    size: (width, height) where the file does not say it. Raises `DataError` for no camera.
    """
    if not path.is_file():
        raise DataError(path, "is no file", "name the file of the depth camera")
    found = read_intrinsics(path, of_depth=True)
    if found is None:
        raise DataError(path, "holds no intrinsics", 'give "fx", "fy", "cx", "cy" or a matrix "K"')
    if found.size is None and size is None:
        raise DataError(path, "does not say for what size of images", 'give "width", "height"')
    return found.camera(size or (1, 1)), _pose(path, read_leaves(path) or [])


def _intrinsic_numbers(
    leaves: Leaves, of_depth: bool
) -> tuple[float, float, float, float, tuple[int, int] | None] | None:
    """Return fx, fy, cx, cy and the size; of several cameras the one that is asked for."""
    wanted, other = (DEPTH, COLOUR) if of_depth else (COLOUR, DEPTH)

    def distance(place: str) -> int:
        return 0 if wanted.search(place) else 2 if other.search(place) else 1

    found = []
    for place in dict.fromkeys(place for place, _ in leaves):
        inside = [(key, numbers) for where, numbers in leaves if (key := _inside(place, where))]
        pixels = _pixels_of_matrix(place, leaves) or _pixels_of_keys(inside)
        if pixels is not None:
            found.append((distance(place), pixels, place))
    if not found:
        return None
    _, pixels, place = min(found, key=lambda entry: entry[0])
    return (*pixels, _size_near(place, leaves))


def _inside(place: str, where: str) -> str | None:
    """Return the last part of a leaf's place where it is beside `place`."""
    parent = place.rpartition("/")[0]
    head, _, key = where.rpartition("/")
    return key if head == parent else None


def _pixels_of_matrix(place: str, leaves: Leaves) -> tuple[float, float, float, float] | None:
    key = place.rpartition("/")[2]
    if key == "data":
        key = place.split("/")[-2] if "/" in place else key
    is_named = key in MATRIX_KEYS or "intrin" in key or "camera matrix" in key
    numbers = next(n for where, n in leaves if where == place)
    if key and not is_named:
        return None
    return pixels_of_numbers(numbers, is_bare=not key)


def pixels_of_numbers(
    numbers: Sequence[float], *, is_bare: bool = False
) -> tuple[float, float, float, float] | None:
    """Return fx, fy, cx, cy of a matrix in rows or columns, or of a list; None if it is neither.

    is_bare: nothing else says that the numbers are of a camera.
    """
    values = np.asarray(numbers, np.float64)
    if len(values) in (12, 16):
        values = values.reshape(-1, 4)[:3, :3].ravel()
    if len(values) == 9:
        matrix = values.reshape(3, 3)
        if matrix[0, 2] == matrix[1, 2] == 0:
            matrix = matrix.T
        if matrix[2, 2] == 1 and not matrix[2, :2].any() and matrix[1, 0] == 0:
            return _checked(matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])
    has_size = len(values) == 6 and (values[:2] == values[:2].round()).all() and values[0] >= 32
    if has_size:
        return _checked(*values[2:6])
    if len(values) in (4, 8, 9) or (len(values) == 5 and not is_bare):
        return _checked(*values[:4])
    return None


def _checked(
    fx: float, fy: float, cx: float, cy: float
) -> tuple[float, float, float, float] | None:
    """Return intrinsics in pixels; None where these can be none (fy < 0: y axis upward)."""
    is_focal = 20 < fx < MAX_FOCAL_PX and 0.5 < abs(fy) / fx < 2
    is_inside = -fx < cx < 4 * fx and -fx < cy < 4 * fx and cx != 0
    return (float(fx), float(fy), float(cx), float(cy)) if is_focal and is_inside else None


def _pixels_of_keys(inside: Leaves) -> tuple[float, float, float, float] | None:
    named = dict(reversed(inside))
    pixels = []
    for keys in FOCAL_KEYS.values():
        value = next((named[key] for key in keys if key in named and len(named[key]) == 1), None)
        pixels.append(None if value is None else value[0])
    if pixels[1] is None:
        pixels[1] = pixels[0]
    for place, centre in ((2, "principal_point"), (0, "focal_length")):
        if pixels[place] is None and len(named.get(centre, ())) == 2:
            pixels[place], pixels[place + 1] = named[centre]
    fx, fy, cx, cy = pixels
    if fx is None or fy is None or cx is None or cy is None:
        return None
    return _checked(fx, fy, cx, cy)


def _size_near(place: str, leaves: Leaves) -> tuple[int, int] | None:
    """Return the (width, height) that stands beside the intrinsics, or anywhere."""
    bare = next((n for where, n in leaves if where == place and len(n) == 6), None)
    if bare is not None:
        return int(bare[0]), int(bare[1])
    beside = [(where, n) for where, n in leaves if _inside(place, where)]
    above = [(where, n) for where, n in leaves if _inside(place.rpartition("/")[0], where)]
    for near in (beside, above, leaves):
        size = [next((n[0] for n in _values(near, keys) if len(n) == 1), 0.0) for keys in SIZE_KEYS]
        pairs = [n for n in _values(near, ("resolution", "size", "image_size")) if len(n) == 2]
        for width, height in (size, *pairs):
            if min(width, height) >= MIN_SIDE:
                return int(width), int(height)
    return None


def _values(leaves: Leaves, keys: Sequence[str]) -> Iterator[list[float]]:
    for key in keys:
        yield from (n for where, n in leaves if where.rpartition("/")[2].lstrip("_") == key)


def _metres(value: float, leaves: Leaves) -> float | None:
    """Return metres per unit of what a file calls the scale of depth, in any convention.

    More than 100 are units per metre. Where a whole camera of BOP stands beside it, and for
    anything that is neither, it brings to millimetres.
    """
    if not 0 < value < 1e6:
        return None
    if value >= 100:
        return 1 / value
    is_bop = any(where.rpartition("/")[2] == "cam_k" for where, _ in leaves)
    return value if value <= 0.01 and not is_bop else value * 0.001


def _pose(path: Path, leaves: Leaves) -> Pose | None:
    """Return the 4x4 of a file's extrinsics, or one made of its rotation and translation."""
    named = dict(reversed([(where.rpartition("/")[2], n) for where, n in leaves]))
    numbers = next((named[k] for k in POSE_KEYS if len(named.get(k, ())) in (12, 16)), None)
    pose = np.eye(4)
    if numbers is not None:
        pose[: len(numbers) // 4] = np.reshape(numbers, (-1, 4))
    elif len(named.get("rotation", ())) == 9 and len(named.get("translation", ())) == 3:
        pose[:3, :3], pose[:3, 3] = np.reshape(named["rotation"], (3, 3)), named["translation"]
    else:
        return None
    if not is_rigid(pose):
        raise DataError(path, "T_colour_depth is not a rigid pose", "correct its 16 numbers")
    if np.abs(pose[:3, 3]).max() > 10:
        pose[:3, 3] /= 1000  # no depth camera stands ten metres from its colour camera
    return pose
