"""Read `camera.json`: the intrinsics, depth unit and label values of a recording."""

from __future__ import annotations

import difflib
import json
import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.depth_files import DepthForm
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text
from curiosight.frame import MOUNTS, Camera, Label, Mount

FILE_NAME = "camera.json"
SIZES = ("width", "height")
NUMBERS = ("fx", "fy", "cx", "cy", "depth_scale")
REQUIRED = SIZES + NUMBERS
KEYS = (*REQUIRED, "labels", "depth_window", "mount")
LABEL_KEYS = ("ignore", "support", "objects_from")
REMEDY = f"give {', '.join(REQUIRED)} (depth_scale in metres per unit, 0.001 for millimetres)"
# A unit of 10 cm is coarser than any depth camera: such a number is units per metre.
MAX_DEPTH_SCALE = 0.1


@dataclass(frozen=True, slots=True)
class LabelValues:
    """What the values of an annotated image mean; those not named are ignored."""

    support: frozenset[int]
    objects_from: int
    ignore: frozenset[int] = frozenset()

    def to_ground_truth(self, values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
        """Return (H, W) uint8: 255 salient, 0 not salient, 125 ignored."""
        truth = np.full(values.shape, Label.UNKNOWN, np.uint8)
        truth[values >= self.objects_from] = Label.SALIENT
        truth[np.isin(values, list(self.support))] = Label.NOT_SALIENT
        truth[np.isin(values, list(self.ignore))] = Label.UNKNOWN
        return truth


GROUND_TRUTH_VALUES = LabelValues(support=frozenset({0}), objects_from=255)


@dataclass(frozen=True, slots=True)
class CameraFile:
    """What `camera.json`, or a file of others, says; `labels` is None where it says none.

    depth_scale: metres per unit; None = not said. is_assumed: the camera is not said either.
    is_y_up: fy was negative: the y axis of the camera that the poses speak of points up. The
    camera here has its fy positive.
    mount: how the camera is held; None = not said.
    """

    camera: Camera
    depth_scale: float | None
    labels: LabelValues | None = None
    is_assumed: bool = False
    is_y_up: bool = False
    mount: Mount | None = None

    def depth_form(self, usual: DepthForm) -> DepthForm:
        """Return how depth is to be read. usual: where the file does not say it."""
        return usual if self.depth_scale is None else DepthForm(self.depth_scale)


def read_camera_file(folder: Path, *, may_be_y_up: bool = False) -> CameraFile | None:
    """Read `camera.json` in a folder; None if there is none, `DataError` if it is no good.

    may_be_y_up: fy may be negative, as in ICL-NUIM, and whoever asks sees to the poses.
    """
    path = folder / FILE_NAME
    if not path.is_file():
        return None
    try:
        content = json.loads(read_text(path, "utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        raise DataError(path, f"is not valid JSON ({error})", "correct or replace it") from None
    if not isinstance(content, dict):
        raise DataError(path, f"holds a {type(content).__name__}, not an object", REMEDY)
    _reject_unknown(path, content, KEYS)
    missing = [key for key in REQUIRED if key not in content]
    if missing:
        raise DataError(path, f"lacks {', '.join(missing)}", REMEDY)
    for key in SIZES:
        _check_whole(path, key, content[key], minimum=1)
    for key in NUMBERS:
        is_turned = key == "fy" and may_be_y_up and _is_negative(content[key])
        is_signed = is_turned or key in ("cx", "cy")
        _check_number(path, key, content[key], is_positive=not is_signed)
    if content["depth_scale"] > MAX_DEPTH_SCALE:
        raise _wrong(path, "depth_scale", "metres per unit, at most 0.1", content["depth_scale"])
    return CameraFile(
        _camera(path, content),
        float(content["depth_scale"]),
        _labels(path, content.get("labels")),
        is_y_up=content["fy"] < 0,
        mount=_mount(path, content.get("mount")),
    )


def _camera(path: Path, content: dict[str, Any]) -> Camera:
    window = _depth_window(path, content.get("depth_window"))
    fx, fy, cx, cy = (float(content[key]) for key in ("fx", "fy", "cx", "cy"))
    width, height = content["width"], content["height"]
    try:
        return Camera(width, height, fx, abs(fy), cx, cy, depth_window=window)
    except ValueError as error:
        raise DataError(path, f"is no camera ({error})", "correct these numbers") from None


def scaled_camera(camera: Camera, size: tuple[int, int]) -> Camera:
    """Return the intrinsics for another image size (width, height) of the same field of view.

    The depth window shrinks to whole pixels; in an image of a few pixels it is given up.
    """
    width, height = size
    if size == (camera.width, camera.height):
        return camera
    ratio_u, ratio_v = width / camera.width, height / camera.height
    window = camera.depth_window
    if window is not None:
        window = (
            math.ceil(window[0] * ratio_u),
            math.ceil(window[1] * ratio_v),
            math.floor(window[2] * ratio_u),
            math.floor(window[3] * ratio_v),
        )
        if window[0] >= window[2] or window[1] >= window[3]:
            window = None
    return Camera(
        width,
        height,
        camera.fx * ratio_u,
        camera.fy * ratio_v,
        (camera.cx + 0.5) * ratio_u - 0.5,
        (camera.cy + 0.5) * ratio_v - 0.5,
        depth_window=window,
    )


def _depth_window(path: Path, window: Any) -> tuple[int, int, int, int] | None:
    if window is None:
        return None
    if not isinstance(window, list) or len(window) != 4:
        raise _wrong(path, "depth_window", "[u_min, v_min, u_max, v_max] in pixels", window)
    for edge in window:
        _check_whole(path, "depth_window", edge, minimum=0)
    u_min, v_min, u_max, v_max = window
    return u_min, v_min, u_max, v_max


def _mount(path: Path, mount: Any) -> Mount | None:
    if mount is None:
        return None
    for known in MOUNTS:
        if mount == known:
            return known
    raise _wrong(path, "mount", f"one of {', '.join(MOUNTS)}: where up points in the image", mount)


def _labels(path: Path, labels: Any) -> LabelValues | None:
    if labels is None:
        return None
    if not isinstance(labels, dict) or "objects_from" not in labels:
        expected = '{"ignore": [0], "support": [1], "objects_from": 2}'
        raise _wrong(path, "labels", f"an object such as {expected}", labels)
    _reject_unknown(path, labels, LABEL_KEYS)
    _check_whole(path, "labels.objects_from", labels["objects_from"], minimum=0)
    sets = {}
    for key in ("ignore", "support"):
        values = labels.get(key, [])
        if not isinstance(values, list):
            raise _wrong(path, f"labels.{key}", "a list of whole numbers", values)
        for value in values:
            _check_whole(path, f"labels.{key}", value, minimum=0)
        sets[key] = frozenset(values)
    return LabelValues(sets["support"], labels["objects_from"], sets["ignore"])


def _reject_unknown(path: Path, content: dict[str, Any], known: Iterable[str]) -> None:
    for key in content:
        if key not in known:
            near = difflib.get_close_matches(key, list(known), n=1)
            meant = f'use "{near[0]}"? ' if near else ""
            raise DataError(
                path, f'has the unknown key "{key}"', f"{meant}Known: {', '.join(known)}"
            )


def _check_whole(path: Path, key: str, value: Any, *, minimum: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < minimum:
        raise _wrong(path, key, f"a whole number of at least {minimum}", value)


def _is_negative(value: Any) -> bool:
    return isinstance(value, int | float) and -sys.float_info.max <= value < 0


def _check_number(path: Path, key: str, value: Any, *, is_positive: bool) -> None:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    # Compared rather than converted: JSON has whole numbers that no float can hold.
    is_number = is_number and abs(value) <= sys.float_info.max
    if not is_number or (is_positive and value <= 0):
        raise _wrong(path, key, "a positive number" if is_positive else "a number", value)


def _wrong(path: Path, key: str, expected: str, value: Any) -> DataError:
    return DataError(path, f"{key} is {json.dumps(value)}", f"expected {expected}")
