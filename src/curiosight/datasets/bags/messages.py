"""Where the messages of a topic lie in a file, without their content."""

from __future__ import annotations

import struct
from array import array
from dataclasses import dataclass, field

HEAD_BYTES = 20  # of a message, which say when its header was stamped
NS_PER_SECOND = 1_000_000_000
OLD_NAMES = {"tf/msg/tfMessage": "tf2_msgs/msg/TFMessage"}
# What begins with a std_msgs/Header and is of use here.
STAMPED = frozenset(
    {
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/CameraInfo",
        "nav_msgs/msg/Odometry",
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "geometry_msgs/msg/TransformStamped",
    }
)


def _column() -> array[int]:
    return array("q")


@dataclass(slots=True)
class Messages:
    """The messages of one topic in one file, in the file's order; columns are of one length.

    encoding: "cdr", "ros1", or another's, which is not decoded here.
    chunks: number of the compressed chunk that a message lies in, -1 = in the file itself.
    offsets, lengths: of its bytes there, or its row and length in a database.
    logged_ns: when it was recorded. stamped_ns: by its own header; as logged for other types.
    """

    topic: str
    type: str
    encoding: str
    chunks: array[int] = field(default_factory=_column)
    offsets: array[int] = field(default_factory=_column)
    lengths: array[int] = field(default_factory=_column)
    logged_ns: array[int] = field(default_factory=_column)
    stamped_ns: array[int] = field(default_factory=_column)

    def __len__(self) -> int:
        return len(self.offsets)

    @property
    def is_stamped(self) -> bool:
        """Tell whether its messages begin with a header whose stamp is wanted."""
        return self.type in STAMPED and self.encoding in ("cdr", "ros1")

    def add(self, chunk: int, offset: int, length: int, logged_ns: int, head: bytes) -> None:
        """Add a message. head: its first bytes, at least `HEAD_BYTES` if it has so many."""
        self.chunks.append(chunk)
        self.offsets.append(offset)
        self.lengths.append(length)
        logged_ns = min(logged_ns, 2**63 - 1)
        self.logged_ns.append(logged_ns)
        stamp = header_stamp(head, self.encoding) if self.is_stamped else None
        self.stamped_ns.append(logged_ns if stamp is None else stamp)


def type_name(name: str) -> str:
    """Return a message's type as ROS 2 writes it.

    >>> type_name("sensor_msgs/Image"), type_name("tf/tfMessage")
    ('sensor_msgs/msg/Image', 'tf2_msgs/msg/TFMessage')
    """
    package, _, rest = name.partition("/")
    name = f"{package}/msg/{rest}" if rest and "/" not in rest else name
    return OLD_NAMES.get(name, name)


def header_stamp(head: bytes, encoding: str) -> int | None:
    """Return the nanoseconds of the std_msgs/Header that a message begins with; None if cut."""
    if len(head) < 12:
        return None
    # In ROS 1 a sequence number stands first; in CDR four bytes, the second tells the order.
    order = ">" if encoding == "cdr" and not head[1] & 1 else "<"
    seconds, nanoseconds = struct.unpack_from(f"{order}iI", head, 4)
    return int(seconds) * NS_PER_SECOND + int(nanoseconds)
