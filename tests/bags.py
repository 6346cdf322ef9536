"""Write tiny bags with rosbags, message by message, for tests that read them back."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from scipy.spatial.transform import Rotation

from curiosight.datasets.bags.message_types import encode, typestore
from curiosight.frame import Camera, Pose

COLOUR, DEPTH = "/camera/color/image_raw", "/camera/depth/image_raw"
INFO, DEPTH_INFO = "/camera/color/camera_info", "/camera/depth/camera_info"
OPTICAL = "camera_color_optical_frame"
START_NS = 1_305_031_229_528_748_000
STEP_NS = 100_000_000
Array = npt.NDArray[Any]
# Topic, nanoseconds at which it was recorded, and the message.
Line = tuple[str, int, Any]


class Messages:
    """Make messages as ROS 1 ("ros1") or ROS 2 ("cdr") has them."""

    def __init__(self, encoding: str = "cdr") -> None:
        self.encoding = encoding

    def new(self, kind: str, **fields: Any) -> Any:
        package, name = kind.split("/")
        return typestore(self.encoding).types[f"{package}/msg/{name}"](**fields)

    def header(self, stamp_ns: int, frame: str = OPTICAL) -> Any:
        stamp = self.new("builtin_interfaces/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
        number = {"seq": 7} if self.encoding == "ros1" else {}
        return self.new("std_msgs/Header", **number, stamp=stamp, frame_id=frame)

    def image(
        self,
        pixels: Array,
        encoding: str,
        stamp_ns: int = START_NS,
        *,
        frame: str = OPTICAL,
        padding: int = 0,
        is_bigendian: bool = False,
    ) -> Any:
        """Make an image; padding: bytes of 255 after each row."""
        order = ">" if is_bigendian else "<"
        rows = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder(order))
        rows = rows.view(np.uint8).reshape(len(pixels), -1)
        rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=255)
        return self.new(
            "sensor_msgs/Image",
            header=self.header(stamp_ns, frame),
            height=len(pixels),
            width=pixels.shape[1],
            encoding=encoding,
            is_bigendian=int(is_bigendian),
            step=rows.shape[1],
            data=rows.ravel(),
        )

    def compressed(
        self, content: bytes, text: str, stamp_ns: int = START_NS, *, frame: str = OPTICAL
    ) -> Any:
        return self.new(
            "sensor_msgs/CompressedImage",
            header=self.header(stamp_ns, frame),
            format=text,
            data=np.frombuffer(content, np.uint8),
        )

    def info(
        self, camera: Camera, stamp_ns: int = START_NS, *, frame: str = OPTICAL, **changes: Any
    ) -> Any:
        """Make a CameraInfo; changes: K, P, D, binning (u, v), roi (u, v, width, height)."""
        K = [camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1]
        P = [*K[:3], 0, *K[3:6], 0, *K[6:], 0]
        fields = {"D": [0] * 5, "K": K, "R": np.eye(3).ravel(), "P": P}
        fields |= {name: changes[name] for name in fields if name in changes}
        if self.encoding == "cdr":
            fields = {name.lower(): values for name, values in fields.items()}
        x, y, width, height = changes.get("roi", (0, 0, 0, 0))
        binning = changes.get("binning", (0, 0))
        part = {"x_offset": x, "y_offset": y, "width": width, "height": height}
        return self.new(
            "sensor_msgs/CameraInfo",
            header=self.header(stamp_ns, frame),
            height=camera.height,
            width=camera.width,
            distortion_model="plumb_bob",
            **{name: np.array(values, np.float64) for name, values in fields.items()},
            binning_x=binning[0],
            binning_y=binning[1],
            roi=self.new("sensor_msgs/RegionOfInterest", **part, do_rectify=False),
        )

    def tf(self, *links: tuple[str, str, Pose, int]) -> Any:
        """Make a TFMessage of parent, child, T_parent_child and nanoseconds."""
        return self.new(
            "tf2_msgs/TFMessage",
            transforms=[
                self.new(
                    "geometry_msgs/TransformStamped",
                    header=self.header(stamp_ns, parent),
                    child_frame_id=child,
                    transform=self.new(
                        "geometry_msgs/Transform",
                        translation=self.vector("Vector3", pose),
                        rotation=self.quaternion(pose),
                    ),
                )
                for parent, child, pose, stamp_ns in links
            ],
        )

    def odometry(self, parent: str, child: str, pose: Pose, stamp_ns: int) -> Any:
        zero = self.new("geometry_msgs/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.new("geometry_msgs/Twist", linear=zero, angular=zero)
        nothing = np.zeros(36)
        told = self.pose(pose)
        return self.new(
            "nav_msgs/Odometry",
            header=self.header(stamp_ns, parent),
            child_frame_id=child,
            pose=self.new("geometry_msgs/PoseWithCovariance", pose=told, covariance=nothing),
            twist=self.new("geometry_msgs/TwistWithCovariance", twist=twist, covariance=nothing),
        )

    def pose_stamped(self, parent: str, pose: Pose, stamp_ns: int) -> Any:
        header = self.header(stamp_ns, parent)
        return self.new("geometry_msgs/PoseStamped", header=header, pose=self.pose(pose))

    def pose(self, pose: Pose) -> Any:
        point = self.vector("Point", pose)
        return self.new("geometry_msgs/Pose", position=point, orientation=self.quaternion(pose))

    def vector(self, kind: str, pose: Pose) -> Any:
        x, y, z = map(float, pose[:3, 3])
        return self.new(f"geometry_msgs/{kind}", x=x, y=y, z=z)

    def quaternion(self, pose: Pose) -> Any:
        x, y, z, w = map(float, Rotation.from_matrix(pose[:3, :3]).as_quat())
        return self.new("geometry_msgs/Quaternion", x=x, y=y, z=z, w=w)


def write_bag(path: Path, lines: Sequence[Line], kind: str = "mcap", prepare: Any = None) -> Path:
    """Write a bag and return its path; kind: ros1, sqlite (a folder) or mcap (a folder).

    prepare: is called with the writer before it opens, to set compression, say.
    """
    encoding = "ros1" if kind == "ros1" else "cdr"
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    is_ros1 = kind == "ros1"
    writer: Any = (
        Ros1Writer(path) if is_ros1 else Ros2Writer(path, version=9, storage_plugin=plugin)
    )
    if prepare is not None:
        prepare(writer)
    connections: dict[str, Any] = {}
    with writer:
        for topic, logged_ns, message in lines:
            if topic not in connections:
                connections[topic] = writer.add_connection(
                    topic, message.__msgtype__, typestore=typestore(encoding)
                )
            writer.write(connections[topic], logged_ns, encode(message, encoding))
    return path


def write_plain_mcap(path: Path, lines: Sequence[Line], *, is_chunked: bool = False) -> Path:
    """Write an MCAP without any index, in the order of the lines; in one chunk, or in none."""
    channels: dict[str, int] = {}
    body = b""
    for number, (topic, logged_ns, message) in enumerate(lines):
        if topic not in channels:
            channels[topic] = id = len(channels) + 1
            name = message.__msgtype__.encode()
            body += _record(3, struct.pack("<H", id) + _text(name) + _text(b"ros2msg") + _text(b""))
            head = struct.pack("<HH", id, id) + _text(topic.encode()) + _text(b"cdr")
            body += _record(4, head + struct.pack("<I", 0))
        head = struct.pack("<HIQQ", channels[topic], number, logged_ns, logged_ns)
        body += _record(5, head + encode(message, "cdr"))
    if is_chunked:
        head = struct.pack("<QQQI", 0, 2**62, len(body), 0) + _text(b"")
        body = _record(6, head + struct.pack("<Q", len(body)) + body)
    magic = b"\x89MCAP0\r\n"
    start = _record(1, _text(b"ros2") + _text(b"by hand"))
    end = _record(15, struct.pack("<I", 0)) + _record(2, struct.pack("<QQI", 0, 0, 0))
    path.write_bytes(magic + start + body + end + magic)
    return path


def look_alike(
    make: Messages,
    n_frames: int = 2,
    *,
    camera: Camera | None = None,
    n_without_depth: int = 0,
) -> list[Line]:
    """Return the lines of a small recording: colour n is all n, depth n is (n + 1) metres."""
    camera = camera or Camera(16, 12, 14.0, 14.0, 7.5, 5.5)
    shape = camera.height, camera.width
    lines: list[Line] = []
    for number in range(n_frames):
        stamp_ns = START_NS + number * STEP_NS
        rgb = np.full((*shape, 3), number, np.uint8)
        depth = np.full(shape, 1000 * (number + 1), np.uint16)
        lines.append((INFO, stamp_ns, make.info(camera, stamp_ns)))
        lines.append((COLOUR, stamp_ns, make.image(rgb, "rgb8", stamp_ns)))
        if number >= n_without_depth:
            lines.append((DEPTH, stamp_ns, make.image(depth, "16UC1", stamp_ns)))
    return lines


def png(image: Array) -> bytes:
    """Return a PNG of what OpenCV would write."""
    return bytes(cv2.imencode(".png", image)[1])


def rvl(depth: npt.NDArray[np.uint16]) -> bytes:
    """Compress depth as its inventor's paper says: slow, for small images."""
    nibbles: list[int] = []

    def put(value: int) -> None:
        while True:
            part, value = value & 7, value >> 3
            nibbles.append(part | (8 if value else 0))
            if not value:
                return

    flat = depth.ravel().astype(int).tolist()
    at = previous = 0
    while at < len(flat):
        begin = at
        while at < len(flat) and flat[at] == 0:
            at += 1
        put(at - begin)
        begin = at
        while at < len(flat) and flat[at] != 0:
            at += 1
        put(at - begin)
        for value in flat[begin:at]:
            delta = value - previous
            put(2 * delta if delta >= 0 else -2 * delta - 1)
            previous = value
    nibbles += [0] * (-len(nibbles) % 8)
    words = [
        sum(nibble << (28 - 4 * place) for place, nibble in enumerate(nibbles[start : start + 8]))
        for start in range(0, len(nibbles), 8)
    ]
    return struct.pack("<II", depth.shape[1], depth.shape[0]) + struct.pack(
        f"<{len(words)}I", *words
    )


def _record(kind: int, content: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(content)) + content


def _text(content: bytes) -> bytes:
    return struct.pack("<I", len(content)) + content
