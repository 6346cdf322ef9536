"""Choose the topics that make frames: named by the user, or guessed by type, content and name."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from curiosight.datasets.bags.bag import Bag, Topic
from curiosight.datasets.bags.camera_info import CAMERA_INFO
from curiosight.datasets.bags.images import (
    COLOURS,
    COMPRESSED,
    DEPTHS,
    GREYS,
    IMAGE,
    IMAGE_TYPES,
    encoding_of,
)
from curiosight.datasets.bags.message_types import TF_MESSAGE
from curiosight.datasets.bags.transforms import POSE_TYPES, frame_of
from curiosight.errors import DataError

ROLES = ("color", "depth", "info", "pose")
TYPES = {
    "color": IMAGE_TYPES,
    "depth": IMAGE_TYPES,
    "info": (CAMERA_INFO,),
    "pose": POSE_TYPES,
}
EXAMPLE = "color=/camera/color/image_raw,depth=/camera/depth/image_raw"
COLOUR_WORDS = re.compile(r"colou?r|rgb")
DEPTH_WORDS = re.compile(r"depth|disparity")
REGISTERED_WORDS = re.compile(r"aligned|registered|to_(colou?r|rgb)")
OTHER_WORDS = re.compile(
    r"infra|(^|[/_])ir\d?($|[/_])|mask|debug|label|saliency|segment|annot|theora"
)
MAX_LISTED = 12


@dataclass(frozen=True, eq=False)
class Choice:
    """The topics of a recording. pose: None = as tf tells, if it does."""

    colour: Topic
    depth: Topic | None = None
    info: Topic | None = None
    depth_info: Topic | None = None
    pose: Topic | None = None
    is_pose_named: bool = False


def parse_topics(text: str) -> dict[str, str]:
    """Return the topics that a user names, by role; ValueError where the text is no such list.

    >>> parse_topics("color=/a, depth=/b")
    {'color': '/a', 'depth': '/b'}
    """
    named: dict[str, str] = {}
    for part in filter(None, (word.strip() for word in text.split(","))):
        role, is_given, topic = (word.strip() for word in part.partition("="))
        role = "color" if role == "colour" else role
        if role not in ROLES or not is_given or not topic or role in named:
            raise ValueError(
                f"topics: expected such as {EXAMPLE}[,info=/c][,pose=/d], got {text!r}"
            )
        named[role] = topic
    return named


def choose_topics(bag: Bag, text: str) -> Choice:
    """Return the topics to read; raises `DataError` where one is not there or of another type."""
    named = {role: _named(bag, role, name) for role, name in parse_topics(text).items()}
    images = {
        topic.name: encoding_of(message)
        for topic in bag.topics.values()
        if topic.type in IMAGE_TYPES and (message := topic.first()) is not None
    }
    depth = named.get("depth") or _best(bag, images, _depth_score)
    colour = named.get("color") or _best(bag, images, _colour_score)
    if colour is None:
        what, remedy = "holds no colour images", f"name them: --topics {EXAMPLE}"
        if not bag.is_of_ros():
            what, remedy = "holds no messages of ROS", "give a bag that does; logs are not read"
        what += "".join(f" ({remark})" for remark in bag.remarks)
        raise DataError(bag.path, f"{what}, but {listed(bag)}", remedy)
    if "depth" not in named and depth is not None and depth.name == colour.name:
        depth = None
    info = named.get("info") or _info_of(bag, colour)
    depth_info = None if depth is None else _info_of(bag, depth)
    if depth and depth_info and not _n_shared(depth_info.name, depth.name):
        # Told by the frame alone, which is colour's as well where depth is registered.
        depth_info = info if frame_of(depth) == frame_of(colour) else depth_info
    pose = named.get("pose") or _pose(bag)
    return Choice(colour, depth, info, depth_info, pose, is_pose_named="pose" in named)


def listed(bag: Bag) -> str:
    """Return the topics of a bag with their types, for a line."""
    names = [f"{topic.name} ({topic.type.replace('/msg/', '/')})" for topic in bag.topics.values()]
    more = len(names) - MAX_LISTED
    return ", ".join(names[:MAX_LISTED]) + (f" and {more} more" if more > 0 else "")


def _named(bag: Bag, role: str, name: str) -> Topic:
    topic = bag.topics.get(name) or bag.topics.get(f"/{name}")
    if topic is None:
        raise DataError(bag.path, f"has no messages on {name}", f"there are {listed(bag)}")
    if topic.type not in TYPES[role]:
        expected = " or ".join(kind.replace("/msg/", "/") for kind in TYPES[role])
        found = f"{role}={name} is of {topic.type.replace('/msg/', '/') or 'no type'}"
        raise DataError(bag.path, found, f"expected {expected}; there are {listed(bag)}")
    if topic.type in IMAGE_TYPES:
        _check_encoding(bag, role, topic)
    return topic


def _check_encoding(bag: Bag, role: str, topic: Topic) -> None:
    """Raise `DataError` where the images of a topic that was named cannot be what they are for."""
    message = topic.first()
    if message is None:
        remedy = f"there are {listed(bag)}"
        raise DataError(bag.path, f"{role}={topic.name} cannot be decoded", remedy)
    encoding = encoding_of(message)
    is_depth = encoding == "depth" or (topic.type == IMAGE and encoding in DEPTHS)
    is_colour = encoding != "depth" and (topic.type == COMPRESSED or encoding in COLOURS)
    # Eight bits for depth have an error of their own.
    if is_colour if role == "color" else is_depth or encoding in GREYS:
        return
    what = "colour" if role == "color" else "depth"
    found = f"{role}={topic.name} is encoded as {encoding}, which is no {what} that is read"
    raise DataError(bag.path, found, f"there are {listed(bag)}")


def _best(bag: Bag, images: dict[str, str], score: Any) -> Topic | None:
    """Return the topic of the highest score, of equal ones that with the most messages."""
    scores = {name: score(bag.topics[name], encoding) for name, encoding in images.items()}
    fit = [name for name, value in scores.items() if value is not None]
    best = max(fit, key=lambda name: (scores[name], len(bag.topics[name])), default=None)
    return None if best is None else bag.topics[best]


def _colour_score(topic: Topic, encoding: str) -> int | None:
    """Return how much a topic looks like colour; None if it cannot be."""
    name = topic.name.lower()
    if encoding == "depth":
        return None
    if topic.type == IMAGE and (encoding not in COLOURS or encoding == "mono16"):
        return None
    score = 4 * bool(COLOUR_WORDS.search(name)) - 8 * bool(OTHER_WORDS.search(name))
    # Depth painted in colours, unless the device or its programs are called so.
    score -= 8 * bool(DEPTH_WORDS.search(name.rsplit("/", 1)[0].rsplit("/", 1)[-1]))
    score -= 8 * bool(DEPTH_WORDS.search(name.rsplit("/", 1)[-1]))
    # Without loss before with; what the lens bent is straightened in the rectified.
    score += 2 * ("rect" in name) + (topic.type == IMAGE) - 4 * (encoding in GREYS)
    return score


def _depth_score(topic: Topic, encoding: str) -> int | None:
    """Return how much a topic looks like depth; None if it cannot be."""
    name = topic.name.lower()
    if encoding != "depth" and encoding not in DEPTHS:
        return None
    is_called_so = bool(DEPTH_WORDS.search(name))
    if OTHER_WORDS.search(name) or (encoding == "mono16" and not is_called_so):
        return None
    score = 4 * bool(REGISTERED_WORDS.search(name)) + 2 * is_called_so
    return score + (topic.type == IMAGE)


def _info_of(bag: Bag, image: Topic) -> Topic | None:
    """Return the CameraInfo whose name shares most with an image's; of these, that of its frame."""
    frame = frame_of(image)
    infos = [topic for topic in bag.topics.values() if topic.type == CAMERA_INFO]
    likeness = {
        topic.name: (_n_shared(topic.name, image.name), frame_of(topic) == frame, len(topic))
        for topic in infos
    }
    best = max(infos, key=lambda topic: likeness[topic.name], default=None)
    if best is None or (len(infos) > 1 and not any(likeness[best.name][:2])):
        return None
    return best


def _n_shared(one: str, other: str) -> int:
    count = 0
    for a, b in zip(one.strip("/").split("/"), other.strip("/").split("/"), strict=False):
        if a != b:
            break
        count += 1
    return count


def _pose(bag: Bag) -> Topic | None:
    """Return what tells poses where tf does not: odometry, or the poses of something."""
    kinds = [kind for kind in POSE_TYPES if kind != TF_MESSAGE]
    told = [topic for topic in bag.topics.values() if topic.type in kinds]
    return min(told, key=lambda topic: (kinds.index(topic.type), -len(topic)), default=None)
