"""The cameras of a bag: of colour, of depth beside it, and the unit of depth."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from curiosight.datasets.bags.bag import Bag, Topic
from curiosight.datasets.bags.camera_info import is_distorted, to_camera
from curiosight.datasets.bags.choice import REGISTERED_WORDS, Choice
from curiosight.datasets.bags.realsense import stream_extrinsics
from curiosight.datasets.bags.transforms import Transforms, frame_of
from curiosight.datasets.cameras.calibration import KINECT, KINECTS, usual_camera
from curiosight.datasets.cameras.camera_file import CameraFile, read_camera_file, scaled_camera
from curiosight.datasets.cameras.depth_camera import DepthCamera
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.sizes import has_shape_of
from curiosight.frame import MOUNTS, Camera

STRING, FLOATS = "std_msgs/msg/String", ("std_msgs/msg/Float32", "std_msgs/msg/Float64")
RECTIFIED = re.compile(r"(^|[/_])rect(ified)?($|[/_])")
UNIT_TOPIC = re.compile(r"/option/depth[ _]units/value$", re.IGNORECASE)
# What CameraInfo has no place for, as our own exporter writes it.
EXTRAS_TOPIC = "/curiosight/camera"
N_SAMPLED = 100
MAX_OFF_PX = 0.5
MAX_OFF_METRES = 1e-6


@dataclass(frozen=True, slots=True)
class BagCamera(CameraFile):
    """Intrinsics of colour; of_frames: those of each image, empty where they never change."""

    of_frames: tuple[Camera | None, ...] = ()


def bag_camera(
    bag: Bag,
    choice: Choice,
    size: tuple[int, int],
    stamps_ns: Sequence[int],
    remarks: list[str],
) -> BagCamera:
    """Return the colour camera of images of (width, height), and remark on where it is from.

    A camera.json of ours in the folder, or beside the file, wins over CameraInfo.
    """
    own = read_camera_file(bag.path if bag.path.is_dir() else bag.path.parent)
    if own is not None:
        remarks.append("camera of camera.json")
        return BagCamera(own.camera, own.depth_scale, own.labels, mount=own.mount)
    is_rectified = bool(RECTIFIED.search(choice.colour.name))
    info = choice.info.first() if choice.info is not None else None
    camera = None if info is None else to_camera(info, size, is_rectified=is_rectified)
    if camera is None or choice.info is None:
        what = "CameraInfo holds no intrinsics" if info is not None else "no CameraInfo"
        remarks.append(f"{what}: {KINECTS}")
        return BagCamera(usual_camera(KINECT, size), None, is_assumed=True)
    if is_distorted(info) and not is_rectified:
        remarks.append("the distortion of its lens is not straightened")
    extras = _extras(bag)
    mount = extras.get("mount")
    with suppress(KeyError, TypeError, ValueError):  # a window that is none of this image
        u_min, v_min, u_max, v_max = map(int, extras["depth_window"])
        camera = replace(camera, depth_window=(u_min, v_min, u_max, v_max))
    of_frames = _of_frames(choice.info, size, stamps_ns, is_rectified=is_rectified)
    return BagCamera(camera, None, mount=mount if mount in MOUNTS else None, of_frames=of_frames)


def depth_camera_of(
    bag: Bag,
    choice: Choice,
    camera: Camera,
    depth_size: tuple[int, int],
    transforms: Transforms,
    remarks: list[str],
) -> DepthCamera | None:
    """Return the camera of depth that is not registered to colour; None where it is.

    Told by the topic's name, by the frames of both, or as RealSense tells it, and by CameraInfo.
    Where it cannot be told, depth is taken to be registered, and that is said.
    """
    depth = choice.depth
    if depth is None or REGISTERED_WORDS.search(depth.name.lower()) or not all(depth_size):
        return None
    frames = frame_of(choice.colour), frame_of(depth)
    info = choice.depth_info.first() if choice.depth_info is not None else None
    is_rectified = bool(RECTIFIED.search(depth.name))
    own = None if info is None else to_camera(info, depth_size, is_rectified=is_rectified)
    T_colour_depth = np.eye(4) if frames[0] == frames[1] else transforms.between(*frames)
    who = f"depth ({frames[1]}) is registered to colour ({frames[0]})"
    streams = stream_extrinsics(bag, choice.colour, depth)
    if streams is not None:  # frames are called alike in its old recordings
        T_colour_depth, topic = streams
        who = f"depth is registered to colour, by {topic}"
    if T_colour_depth is None or own is None:
        if frames[0] != frames[1]:
            why = "tf does not join them" if own is not None else "no CameraInfo is depth's"
            what = f"depth is of {frames[1]} and colour of {frames[0]}, and {why}"
            remarks.append(f"{what}: taken as registered (--depth-camera FILE says otherwise)")
        return None
    is_there = np.abs(T_colour_depth - np.eye(4)).max() < MAX_OFF_METRES
    if is_there and _is_same(own, camera):
        return None
    remarks.append(who)
    return DepthCamera(own, T_colour_depth)


def told_unit(bag: Bag, remarks: list[str]) -> DepthForm:
    """Return how whole numbers of depth are read: millimetres, or as RealSense notes its unit."""
    for topic in bag.topics.values():
        if not UNIT_TOPIC.search(topic.name) or topic.type not in (STRING, *FLOATS):
            continue
        message = topic.first()
        try:
            unit = float(message.data) if message is not None else 0.0
        except ValueError:
            continue
        if 0 < unit < 0.1:
            unit = round(unit, 9)  # it may have been a float of 32 bits
            if unit != DepthForm().scale:
                remarks.append(f"depth is in units of {unit:.6g} m, by {topic.name}")
            return DepthForm(unit)
    return DepthForm()


def _extras(bag: Bag) -> dict[str, Any]:
    topic = bag.topics.get(EXTRAS_TOPIC)
    message = topic.first() if topic is not None and topic.type == STRING else None
    try:
        content = json.loads(message.data) if message is not None else {}
    except ValueError:
        return {}
    return content if isinstance(content, dict) else {}


def _of_frames(
    info: Topic, size: tuple[int, int], stamps_ns: Sequence[int], *, is_rectified: bool
) -> tuple[Camera | None, ...]:
    """Return the camera of each image, by the nearest CameraInfo; nothing if it never changes."""
    sampled = np.unique(np.linspace(0, len(info) - 1, N_SAMPLED).round().astype(int))
    if len({_read(info, int(number), size, is_rectified) for number in sampled}) < 2:
        return ()
    stamps = info.stamped_ns
    order = np.argsort(stamps, kind="stable")
    after = np.searchsorted(stamps[order], stamps_ns).clip(max=len(order) - 1)
    before = (after - 1).clip(min=0)
    wanted = np.asarray(stamps_ns, np.int64)
    is_before = np.abs(stamps[order[before]] - wanted) < np.abs(stamps[order[after]] - wanted)
    nearest = order[np.where(is_before, before, after)]
    known = {n: _read(info, n, size, is_rectified) for n in dict.fromkeys(nearest.tolist())}
    return tuple(known[number] for number in nearest.tolist())


def _read(info: Topic, number: int, size: tuple[int, int], is_rectified: bool) -> Camera | None:
    try:
        return to_camera(info.message(number), size, is_rectified=is_rectified)
    except UnreadableFile:
        return None


def _is_same(depth: Camera, colour: Camera) -> bool:
    """Tell whether two cameras show the same, up to the size of their images."""
    size = colour.width, colour.height
    if not has_shape_of((depth.width, depth.height), size):
        return False
    one = scaled_camera(depth, size)
    names = ("fx", "fy", "cx", "cy")
    return all(abs(getattr(one, name) - getattr(colour, name)) < MAX_OFF_PX for name in names)
