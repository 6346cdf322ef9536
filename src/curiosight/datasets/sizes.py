"""Sizes of a recording's images: found, checked, and brought to that of the colour images."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy.typing as npt

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.decoding import UnreadableFile, read_rgb
from curiosight.datasets.depth_files import EightBitDepth, Raw, read_raw_depth
from curiosight.errors import DataError
from curiosight.frame import Camera, Rgb

Size = tuple[int, int]
# Of the quotient of width and height: sizes such as 341x256 are rounded.
SAME_SHAPE = 0.01


def has_shape_of(size: Size, other: Size) -> bool:
    """Tell whether two (width, height) have the same shape: they may show the same view."""
    return math.isclose(size[0] * other[1], size[1] * other[0], rel_tol=SAME_SHAPE)


def fit_to(image: npt.NDArray[Any], size: Size) -> npt.NDArray[Any]:
    """Bring an (h, w) image to (width, height); each pixel is one of those that were there."""
    if image.shape[1::-1] == size:
        return image
    fitted: npt.NDArray[Any] = cv2.resize(image, size, interpolation=cv2.INTER_NEAREST_EXACT)
    return fitted


def fit_camera(path: Path, camera: Camera, size: Size) -> Camera:
    """Return the intrinsics for images of (width, height); `DataError` if of another shape."""
    own = camera.width, camera.height
    if own == size:
        return camera
    if not has_shape_of(own, size):
        found = (
            f"its intrinsics are for {own[0]}x{own[1]} images, "
            f"but the images are {size[0]}x{size[1]}"
        )
        raise DataError(path, found, "correct the camera file")
    return scaled_camera(camera, size)


def image_size(path: Path, images: Sequence[Path], read: Callable[[Path], Rgb] = read_rgb) -> Size:
    """Return (width, height) of the first colour image that can be read; `DataError` if none."""
    if not images:
        raise DataError(path, "holds no colour images", "check that the recording is complete")
    size = first_size(images, read)
    if size is None:
        found = f"none of the {len(images)} colour images can be read"
        raise DataError(path, found, "copy the recording again")
    return size


def first_size(paths: Iterable[Path], read: Callable[[Path], npt.NDArray[Any]]) -> Size | None:
    """Return (width, height) of the first image that can be read; None if none can."""
    for path in paths:
        try:
            shape = read(path).shape
        except UnreadableFile:
            continue
        return shape[1], shape[0]
    return None


def first_depth(images: Iterable[Path], read: Callable[[Path], Raw] = read_raw_depth) -> Raw | None:
    """Return the first depth image that can be read, as it is stored; None if none can.

    Raises `DataError` where depth has 8 bits a pixel and no image has the 16 it needs.
    """
    eight_bit = None
    for path in images:
        try:
            return read(path)
        except EightBitDepth:
            eight_bit = eight_bit or path
        except UnreadableFile:
            continue
    if eight_bit:
        remedy = "export 16-bit PNG: distances cannot be recovered from 8 bits"
        raise DataError(eight_bit, "is depth of 8 bits a pixel, like all of it here", remedy)
    return None


def check_frame_size(path: Path, shape: Sequence[int], size: Size) -> None:
    """Raise `UnreadableFile` where an image is not (width, height) as the others are."""
    if (shape[1], shape[0]) != size:
        raise UnreadableFile(
            f"{path.name} is {shape[1]}x{shape[0]}, not {size[0]}x{size[1]} as the recording"
        )
