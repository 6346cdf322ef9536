"""The camera of a recording: its own camera.json, a file of others, or what is usual."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from curiosight.datasets.cameras.camera_file import (
    FILE_NAME,
    KEYS,
    REQUIRED,
    CameraFile,
    read_camera_file,
    scaled_camera,
)
from curiosight.datasets.cameras.camera_text import read_leaves
from curiosight.datasets.cameras.find_camera import find_camera
from curiosight.datasets.cameras.intrinsics import FoundCamera, read_intrinsics
from curiosight.datasets.cameras.key_names import FOREIGN_KEYS
from curiosight.datasets.sizes import Size, has_shape_of
from curiosight.frame import Camera

TYPING_ERROR = 0.8  # likeness of two keys above which one is the other, mistyped
# Of a principal point to the image's middle.
MAX_OFF_CENTRE = 0.25
USUAL_SIZES = (
    *((640, 480), (1280, 720), (1920, 1080), (1920, 1440), (1280, 960), (848, 480), (1440, 1080)),
    *((960, 720), (1296, 968), (320, 240), (512, 424), (256, 192), (1024, 768), (960, 540)),
)
# Of sizes that a recording's images may have been brought from.
RATIOS = (2.0, 0.5, 3.0, 1 / 3, 4.0, 0.25, 1.5, 2 / 3)
KINECT = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)


KINECTS = "the usual intrinsics of a Kinect are assumed"


def find_calibration(
    path: Path,
    size: Size,
    remarks: list[str],
    usual: Camera = KINECT,
    *,
    whose: str = KINECTS,
    avoid: Sequence[str] = (),
) -> CameraFile:
    """Return the camera of a recording and its unit of depth, and remark on where they are from.

    size: (width, height) of the colour images. usual: what the layout is known for, where no
    file says it; whose: these are, in words. avoid: names of files that hold no camera.
    Raises `DataError` where `camera.json` is no good.
    """
    if (path / FILE_NAME).is_file() and not _is_of_others(path / FILE_NAME):
        own = read_camera_file(path, may_be_y_up=True)
        assert own is not None
        return own
    found = find_camera(path, avoid=avoid)
    if found is None:
        remarks.append(f"no camera.json: {whose}")
        return CameraFile(usual_camera(usual, size), None, is_assumed=True)
    camera = replace(found, size=_size_of(found, size)).camera(size)
    remarks.append(
        f"camera of {_shown(found.path, path)}: fx {camera.fx:.6g}, fy {camera.fy:.6g}, "
        f"cx {camera.cx:.6g}, cy {camera.cy:.6g}"
    )
    return CameraFile(camera, found.depth_scale, is_y_up=found.fy < 0)


def _is_of_others(path: Path) -> bool:
    """Tell whether a camera.json is in another program's form, and not ours mistyped."""
    if read_intrinsics(path) is None:
        return False
    keys = {place.partition("/")[0] for place, _ in read_leaves(path) or []}
    if keys.issuperset(REQUIRED):
        return False
    unknown = [key for key in keys if key not in KEYS]
    mistyped = [
        key
        for key in unknown
        if key not in FOREIGN_KEYS and difflib.get_close_matches(key, KEYS, 1, TYPING_ERROR)
    ]
    return not mistyped and (bool(unknown) or "depth_scale" not in keys)


def usual_camera(usual: Camera, size: Size) -> Camera:
    """Return the intrinsics that are usual, for images of (width, height).

    A camera that is no more than guessed has square pixels, whatever shape its images have.
    """
    if usual != KINECT or has_shape_of((usual.width, usual.height), size):
        return scaled_camera(usual, size)
    width, height = size
    focal = usual.fx * math.sqrt(width * height / (usual.width * usual.height))
    return Camera(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def _size_of(found: FoundCamera, size: Size) -> Size:
    """Return the size of images that intrinsics are for: its principal point is amid them.

    Where a file gives the size as a pair, that may be height and width.
    """
    if found.size is not None:
        turned = found.size[::-1]
        is_turned = has_shape_of(turned, size) and not has_shape_of(found.size, size)
        is_amid = _off_centre(found, turned) < min(MAX_OFF_CENTRE, _off_centre(found, found.size))
        return turned if is_turned and is_amid else found.size
    multiples = [(round(size[0] * ratio), round(size[1] * ratio)) for ratio in RATIOS]
    for other in (size, *USUAL_SIZES, *multiples):
        if _off_centre(found, other) < MAX_OFF_CENTRE and has_shape_of(other, size):
            return other
    return size


def _off_centre(found: FoundCamera, size: Size) -> float:
    """Return how far the principal point is from the middle, 1 = at the edge."""
    return max(abs(2 * found.cx / size[0] - 1), abs(2 * found.cy / size[1] - 1))


def _shown(path: Path, folder: Path) -> str:
    """Return a file's path as seen from the recording."""
    for base, prefix in ((folder, ""), (folder.resolve(), ""), (folder.resolve().parent, "../")):
        if path.is_relative_to(base):
            return prefix + path.relative_to(base).as_posix()
    return str(path)
