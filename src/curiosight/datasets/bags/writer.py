"""Write a recording as a bag of ROS 1 or ROS 2, without ROS."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from curiosight.datasets.bags.bag import beside_bag, is_bag
from curiosight.datasets.bags.bag_camera import EXTRAS_TOPIC, STRING
from curiosight.datasets.bags.camera_info import CAMERA_INFO
from curiosight.datasets.bags.images import IMAGE
from curiosight.datasets.bags.message_types import (
    TF_MESSAGE,
    encode,
    require_rosbags,
    typestore,
)
from curiosight.datasets.bags.messages import NS_PER_SECOND
from curiosight.datasets.dataset import Dataset
from curiosight.datasets.depth_files import MILLIMETRES
from curiosight.datasets.prefetch import Prefetch
from curiosight.errors import DataError
from curiosight.errors.files import writing
from curiosight.frame import Camera, Depth, Frame, Pose
from curiosight.frame.rotations import quaternion_of

BagLayout = Literal["ros1", "rosbag2", "mcap"]
BAG_LAYOUTS: tuple[BagLayout, ...] = get_args(BagLayout)
# By its ending a file is told to be a bag, so one without it could not be read again.
ENDINGS: dict[BagLayout, str] = {"ros1": ".bag", "mcap": ".mcap"}
COLOUR_TOPIC = "/camera/color/image_raw"
INFO_TOPIC = "/camera/color/camera_info"
DEPTH_TOPIC = "/camera/aligned_depth_to_color/image_raw"
DEPTH_INFO_TOPIC = "/camera/aligned_depth_to_color/camera_info"
TF_TOPIC = "/tf"
WORLD, OPTICAL = "map", "camera_color_optical_frame"
FIRST_STAMP_NS = NS_PER_SECOND  # of sources without stamps; many take 0 for none
FRAME_NS = NS_PER_SECOND // 30
MAX_STAMP_NS = (2**31 - 1) * NS_PER_SECOND


class BagWriter:
    """Write the frames of a recording into a bag, one by one.

    layout: "ros1" writes a .bag, "rosbag2" a folder with an SQLite database, "mcap" a bare .mcap.
    path: appears with `finish`, whole; until then it grows in a folder beside it. A file has the
    ending of its kind.
    Depth is 16UC1 in millimetres where these hold it exactly, else 32FC1 in metres. Poses are on
    /tf, from map to the colour camera. Frames keep their stamps where these rise; else each comes
    a thirtieth of a second after the one before. Raises `ValueError` for another ending, and
    `DataError` for a path that exists, unless `overwrite` and it is a bag.
    """

    def __init__(
        self,
        dataset: Dataset,
        path: Path,
        layout: BagLayout,
        *,
        indices: Sequence[int] | None = None,
        overwrite: bool = False,
    ) -> None:
        if layout not in BAG_LAYOUTS:
            raise ValueError(f"layout: expected {', '.join(BAG_LAYOUTS)}, got {layout!r}")
        ending = ENDINGS.get(layout, "")
        if not path.name.lower().endswith(ending):
            raise ValueError(f"path: expected a name that ends in {ending}, got {path.name!r}")
        require_rosbags(path)
        _check_free(path, layout, overwrite=overwrite)
        self.path = path
        self.indices = tuple(range(len(dataset)) if indices is None else indices)
        self.n_written = self.n_restamped = 0
        self._dataset = dataset
        self._layout = layout
        self._encoding = "ros1" if layout == "ros1" else "cdr"
        self._parts = path.with_name(f".{path.name}.{os.getpid()}.partial")
        self._writer: Any = None
        self._connections: dict[str, Any] = {}
        self._is_float = False
        self._last_ns = FIRST_STAMP_NS - FRAME_NS

    def __len__(self) -> int:
        return len(self.indices)

    def __iter__(self) -> Iterator[Frame]:
        """Yield each frame once it is written; one that has a problem is not written."""
        try:
            with writing(self.path):
                self._open()
            with Prefetch(self._dataset) as frames:
                for frame in frames.in_order(self.indices):
                    if frame.problem is None:
                        with writing(self.path):
                            self._write(frame)
                    yield frame
        except GeneratorExit:
            raise  # who asks no more may finish
        except BaseException:
            self.abandon()
            raise

    def finish(self) -> int:
        """Close the bag and put it in its place; return how many frames it holds."""
        with writing(self.path):
            self._writer.close()
            self._writer = None
            (made,) = self._parts.iterdir()
            if self._layout == "mcap":
                made = next(made.glob("*.mcap"))
            if self.path.is_dir():  # moved aside first: at no time is there none
                os.replace(self.path, self._parts / "before")
            os.replace(made, self.path)
            shutil.rmtree(self._parts, ignore_errors=True)
        return self.n_written

    def abandon(self) -> None:
        """Leave nothing behind."""
        with suppress(Exception):
            self._writer.close()
        shutil.rmtree(self._parts, ignore_errors=True)

    def _open(self) -> None:
        self._parts.mkdir(parents=True)
        # Databases and MCAP are called as their folder.
        inside = self._parts / (self.path.stem if self._layout == "mcap" else self.path.name)
        if self._layout == "ros1":
            from rosbags.rosbag1 import Writer as Ros1Writer

            self._writer = Ros1Writer(inside)
        else:
            from rosbags.rosbag2 import StoragePlugin, Writer

            plugin = StoragePlugin.MCAP if self._layout == "mcap" else StoragePlugin.SQLITE3
            self._writer = Writer(inside, version=9, storage_plugin=plugin)
        self._writer.open()

    def _write(self, frame: Frame) -> None:
        stamp_ns = frame.stamp_ns
        if stamp_ns is None or not self._last_ns < stamp_ns <= MAX_STAMP_NS:
            self.n_restamped += stamp_ns is not None
            stamp_ns = self._last_ns + FRAME_NS
        if not self.n_written and frame.camera is not None:
            self._write_extras(frame.camera, stamp_ns)
        self._last_ns = stamp_ns
        self.n_written += 1
        if frame.T_world_camera is not None:
            self._put(TF_TOPIC, self._transform(frame.T_world_camera, stamp_ns), stamp_ns)
        if frame.camera is not None:
            self._put(INFO_TOPIC, self._info(frame.camera, stamp_ns), stamp_ns)
        self._put(COLOUR_TOPIC, self._image(frame.rgb, "rgb8", stamp_ns), stamp_ns)
        if frame.depth is not None and frame.camera is not None:
            self._put(DEPTH_INFO_TOPIC, self._info(frame.camera, stamp_ns), stamp_ns)
            self._put(DEPTH_TOPIC, self._depth(frame.depth, stamp_ns), stamp_ns)

    def _write_extras(self, camera: Camera, stamp_ns: int) -> None:
        """Write what CameraInfo has no place for, where there is any."""
        told = {"depth_window": camera.depth_window, "mount": getattr(self._dataset, "mount", None)}
        told = {key: value for key, value in told.items() if value is not None}
        if told:
            message = self._new(STRING, data=json.dumps(told))
            self._put(EXTRAS_TOPIC, message, stamp_ns)

    def _put(self, topic: str, message: Any, stamp_ns: int) -> None:
        if topic not in self._connections:
            store = typestore(self._encoding)
            self._connections[topic] = self._writer.add_connection(
                topic, message.__msgtype__, typestore=store
            )
        content = encode(message, self._encoding)
        self._writer.write(self._connections[topic], stamp_ns, content)

    def _new(self, kind: str, **fields: Any) -> Any:
        return typestore(self._encoding).types[kind](**fields)

    def _header(self, stamp_ns: int, frame: str = OPTICAL) -> Any:
        seconds, rest = divmod(stamp_ns, NS_PER_SECOND)
        stamp = self._new("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        number = {"seq": self.n_written} if self._encoding == "ros1" else {}
        return self._new("std_msgs/msg/Header", **number, stamp=stamp, frame_id=frame)

    def _image(self, pixels: Any, encoding: str, stamp_ns: int) -> Any:
        content = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("<"))
        return self._new(
            IMAGE,
            header=self._header(stamp_ns),
            height=content.shape[0],
            width=content.shape[1],
            encoding=encoding,
            is_bigendian=0,
            step=content.strides[0],
            data=content.view(np.uint8).ravel(),
        )

    def _depth(self, depth: Depth, stamp_ns: int) -> Any:
        units = np.nan_to_num(np.round(depth / np.float32(MILLIMETRES.scale)))
        whole = np.where(units < 65535, units, 0).astype(np.uint16)
        is_exact = np.array_equal(MILLIMETRES.to_metres(whole), depth, equal_nan=True)
        # One encoding for all of a recording, but for what it cannot hold.
        self._is_float |= not is_exact
        if self._is_float:
            return self._image(depth, "32FC1", stamp_ns)
        return self._image(whole, "16UC1", stamp_ns)

    def _info(self, camera: Camera, stamp_ns: int) -> Any:
        K = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
        P = [*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0]
        matrices = {"D": [0.0] * 5, "K": K, "R": np.eye(3).ravel(), "P": P}
        if self._encoding != "ros1":
            matrices = {name.lower(): values for name, values in matrices.items()}
        roi = dict.fromkeys(("x_offset", "y_offset", "height", "width"), 0)
        return self._new(
            CAMERA_INFO,
            header=self._header(stamp_ns),
            height=camera.height,
            width=camera.width,
            distortion_model="plumb_bob",
            **{name: np.array(values, np.float64) for name, values in matrices.items()},
            binning_x=0,
            binning_y=0,
            roi=self._new("sensor_msgs/msg/RegionOfInterest", **roi, do_rectify=False),
        )

    def _transform(self, pose: Pose, stamp_ns: int) -> Any:
        x, y, z = map(float, pose[:3, 3])
        qx, qy, qz, qw = map(float, quaternion_of(pose[:3, :3]))
        transform = self._new(
            "geometry_msgs/msg/Transform",
            translation=self._new("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
            rotation=self._new("geometry_msgs/msg/Quaternion", x=qx, y=qy, z=qz, w=qw),
        )
        stamped = self._new(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(stamp_ns, WORLD),
            child_frame_id=OPTICAL,
            transform=transform,
        )
        return self._new(TF_MESSAGE, transforms=[stamped])


def _check_free(path: Path, layout: BagLayout, *, overwrite: bool) -> None:
    """Raise `DataError` where a path exists, unless it may be overwritten and is a bag alone."""
    if not path.exists():
        return
    if not overwrite:
        raise DataError(path, "exists", "choose another --out, or add --overwrite")
    if path.is_file():
        if layout not in ENDINGS:  # a folder cannot take the place of a file
            raise DataError(path, "is a file; a bag of rosbag2 is a folder", "choose another --out")
        return
    if not is_bag(path):
        raise DataError(path, "exists and is no bag", "choose another --out")
    others = beside_bag(path)
    if others:
        found = f"holds more than a bag: {min(others)}"
        raise DataError(path, found, "choose another --out, or move that away")
