"""Where the camera was: a chain of transforms from its frame to the world's, interpolated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.bags.bag import Topic
from curiosight.datasets.bags.message_types import TF_MESSAGE
from curiosight.datasets.bags.messages import NS_PER_SECOND
from curiosight.datasets.trajectory import MAX_GAP_NS, Trajectory
from curiosight.frame import Pose

ODOMETRY = "nav_msgs/msg/Odometry"
TRANSFORM = "geometry_msgs/msg/TransformStamped"
POSES = ("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
POSE_TYPES = (TF_MESSAGE, ODOMETRY, TRANSFORM, *POSES)
# A link that is told seldom, as that from map to odometry, may have gaps of its own measure.
USUAL_GAPS = 3
FIXED_FRAMES = frozenset({"map", "odom", "world", "earth"})


@dataclass(slots=True)
class Link:
    """A frame in its parent over time; is_static: once and for all."""

    parent: str
    is_static: bool
    rows: list[tuple[int, tuple[float, ...]]] = field(default_factory=list)

    def trajectory(self) -> Trajectory:
        """Return the link over time, sorted."""
        rows = sorted(self.rows, key=lambda row: row[0])
        numbers = np.array([row[1] for row in rows], np.float64).reshape(-1, 7)
        stamps = np.array([row[0] for row in rows], np.int64)
        return Trajectory(stamps, numbers[:, :3], numbers[:, 3:])

    def at(self, stamps_ns: Sequence[int]) -> list[Pose | None]:
        """Return the link at each stamp, None where it is not known."""
        trajectory = self.trajectory()
        if self.is_static:
            return [trajectory.poses()[-1]] * len(stamps_ns)
        spacing = np.diff(trajectory.stamps_ns)
        usual = int(np.median(spacing)) if len(spacing) else 0
        return trajectory.interpolated(stamps_ns, max_gap_ns=max(MAX_GAP_NS, USUAL_GAPS * usual))


class Transforms:
    """The tree of frames that /tf and /tf_static of a bag tell."""

    def __init__(self, topics: Iterable[Topic]) -> None:
        self._links: dict[tuple[str, str], Link] = {}
        for topic in topics:
            is_static = topic.name.endswith("tf_static")
            for _, message in topic.readable():
                for transform in message.transforms:
                    self._add(transform, is_static=is_static)
        # A frame has one parent; of several the one that is told oftenest.
        by_count = sorted(self._links.items(), key=lambda item: len(item[1].rows))
        self.parents = {child: link for (child, _), link in by_count}

    def chain(self, frame: str) -> list[Link]:
        """Return the links from a frame up to its root."""
        links: list[Link] = []
        seen = {frame}
        while (link := self.parents.get(frame)) is not None and link.parent not in seen:
            links.append(link)
            frame = link.parent
            seen.add(frame)
        return links

    def is_located(self, frame: str) -> bool:
        """Tell whether a frame's place in a world is told: it moves, or is bolted to the map."""
        links = self.chain(frame)
        return self.is_fixed(frame) or any(not link.is_static for link in links)

    def is_fixed(self, frame: str) -> bool:
        """Tell whether a frame's chain ends in a world: no more can be told of where it is."""
        links = self.chain(frame)
        return bool(links) and links[-1].parent in FIXED_FRAMES

    def join(self, child: str, link: Link, frame: str, *, instead: bool) -> bool:
        """Hang a frame into its parent as another topic tells it; tell whether `frame` is on it.

        instead: also where tf tells another parent; the new one is then the root.
        """
        if child not in self.lineage(frame) or (child in self.parents and not instead):
            return False
        self.parents[child] = link
        if instead:
            self.parents.pop(link.parent, None)
        return True

    def poses(self, frame: str, stamps_ns: Sequence[int]) -> list[Pose | None]:
        """Return a frame in its root at each stamp."""
        poses: list[Pose | None] = [np.eye(4)] * len(stamps_ns)
        for link in self.chain(frame):
            poses = [
                None if lower is None or upper is None else upper @ lower
                for upper, lower in zip(link.at(stamps_ns), poses, strict=True)
            ]
        return poses

    def between(self, target: str, source: str) -> Pose | None:
        """Return T_target_source where only static links join the two; None if they do not."""
        lineages = [self.lineage(target), self.lineage(source)]
        common = next((frame for frame in lineages[0] if frame in lineages[1]), None)
        if common is None:
            return None
        up = [self._static_pose(frame, common) for frame in (target, source)]
        if up[0] is None or up[1] is None:
            return None
        T_target_source: Pose = np.linalg.inv(up[0]) @ up[1]
        return T_target_source

    def lineage(self, frame: str) -> list[str]:
        """Return a frame, its parent, and so on up to its root."""
        return [frame, *(link.parent for link in self.chain(frame))]

    def _static_pose(self, frame: str, ancestor: str) -> Pose | None:
        """Return a frame in one above it; None where a link on the way moves."""
        pose: Pose = np.eye(4)
        for link in self.chain(frame):
            if frame == ancestor:
                break
            upper = link.at([0])[0] if link.is_static else None
            if upper is None:
                return None
            pose, frame = upper @ pose, link.parent
        return pose

    def _add(self, transform: Any, *, is_static: bool) -> None:
        child, parent = clean(transform.child_frame_id), clean(transform.header.frame_id)
        link = self._links.setdefault((child, parent), Link(parent, is_static))
        link.is_static &= is_static
        link.rows.append((stamp_of(transform.header), numbers_of(transform.transform)))


def poses_told(topic: Topic) -> tuple[Link, str]:
    """Return what Odometry, PoseStamped or the like tell: a frame in its parent, and its name.

    The name is "" where the messages do not say whose pose it is.
    """
    link, child = Link("", is_static=False), ""
    for _, message in topic.readable():
        link.parent = clean(message.header.frame_id)
        if topic.type == TRANSFORM:
            child, told = clean(message.child_frame_id), message.transform
        else:
            child = clean(getattr(message, "child_frame_id", ""))
            told = message.pose if topic.type == POSES[0] else message.pose.pose
        link.rows.append((stamp_of(message.header), numbers_of(told)))
    return link, child


def frame_of(topic: Topic) -> str:
    """Return the frame that the first message of a topic is in."""
    message = topic.first()
    return "" if message is None else clean(message.header.frame_id)


def clean(frame: Any) -> str:
    """Return the name of a frame without the slash that ROS 1 had once."""
    return str(frame).removeprefix("/")


def stamp_of(header: Any) -> int:
    """Return a header's nanoseconds."""
    return int(header.stamp.sec) * NS_PER_SECOND + int(header.stamp.nanosec)


def numbers_of(told: Any) -> tuple[float, ...]:
    """Return x, y, z, qx, qy, qz, qw of a Transform or a Pose."""
    is_transform = hasattr(told, "translation")
    place = told.translation if is_transform else told.position
    turn = told.rotation if is_transform else told.orientation
    values: npt.NDArray[np.float64] = np.array(
        [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w], np.float64
    )
    return tuple(values.tolist())
