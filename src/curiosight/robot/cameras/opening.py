"""Open the camera that a source names."""

from __future__ import annotations

from collections.abc import Callable

from curiosight.robot.cameras.camera import CameraFeed, Device
from curiosight.robot.cameras.colour_camera import ColourCamera
from curiosight.robot.cameras.oak import open_oak
from curiosight.robot.cameras.realsense import open_realsense

OPENERS: dict[str, Callable[[str], Device]] = {
    "realsense": open_realsense,
    "oak": open_oak,
    "camera": lambda which: ColourCamera(which or "0"),
}


def open_camera(source: str) -> CameraFeed:
    """Open realsense:[SERIAL], oak:[ID] or camera:NUMBER, or what is played in its place.

    Raises `CameraError` where it is not there, or what drives it is not installed.
    """
    kind, _, which = source.partition(":")
    if kind not in OPENERS:
        raise ValueError(f"source: expected one of {', '.join(OPENERS)}, got {kind!r}")
    return CameraFeed(OPENERS[kind](which))
