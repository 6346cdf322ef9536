"""Decode the messages of bags, by the definitions that rosbags brings along."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError

TF_MESSAGE = "tf2_msgs/msg/TFMessage"
ENCODINGS = ("cdr", "ros1")


def require_rosbags(path: Path) -> None:
    """Raise `DataError` where rosbags, which decodes messages, is not installed."""
    try:
        import rosbags.typesys  # noqa: F401
    except ImportError:
        found = "is a bag of ROS; these need rosbags, which is missing"
        raise DataError(path, found, "pip install 'curiosight[bags]'") from None


@cache
def typestore(encoding: str) -> Any:
    """Return rosbags' store of the usual messages, of ROS 1 or (cdr) of ROS 2.

    The definitions in a bag are not asked: those of the types wanted here never changed, and one
    that is damaged or of a type that nobody knows would keep the whole bag closed.
    """
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    if encoding == "cdr":
        return get_typestore(Stores.ROS2_JAZZY)
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF_MESSAGE))
    return store


def decode(content: bytes, kind: str, encoding: str) -> Any:
    """Decode a message; raises `UnreadableFile` where it is damaged or of another encoding."""
    if encoding not in ENCODINGS:
        raise UnreadableFile(f"messages in {encoding or 'no encoding'} are not those of ROS")
    store = typestore(encoding)
    try:
        if encoding == "cdr":
            return store.deserialize_cdr(content, kind)
        return store.deserialize_ros1(content, kind)
    # What a damaged message makes of the decoder is not foreseeable.
    except Exception as error:
        raise UnreadableFile(f"the {kind.rpartition('/')[2]} cannot be decoded") from error


def encode(message: Any, encoding: str) -> bytes:
    """Return the bytes of a message."""
    store = typestore(encoding)
    write = store.serialize_cdr if encoding == "cdr" else store.serialize_ros1
    return bytes(write(message, message.__msgtype__))
