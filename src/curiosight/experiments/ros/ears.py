"""Topics that are listened to, and what is seen of each: who sends, how, and when last."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from curiosight.datasets.bags.transforms import stamp_of
from curiosight.experiments.ros.packages import Ros
from curiosight.robot.ros.missing import Quality, TopicSeen

SENSOR = Quality("best_effort", "volatile")
LATCHED = Quality("reliable", "transient_local")


@dataclass(slots=True)
class Ear:
    """A topic that is listened to."""

    name: str
    what: str
    kind: str
    asked: Quality
    is_once: bool = False
    n: int = 0
    last_at: float = 0.0
    last_stamp_ns: int | None = None
    policies: set[str] = field(default_factory=set)
    subscription: Any = None


class Ears:
    """Subscriptions of a node."""

    def __init__(self, ros: Ros, node: Any) -> None:
        self._ros, self._node = ros, node
        self.all: list[Ear] = []

    def close(self) -> None:
        """Listen no more."""
        for ear in self.all:
            self._node.destroy_subscription(ear.subscription)
        self.all = []

    def listen(
        self,
        name: str,
        what: str,
        kind: Any,
        asked: Quality,
        take: Callable[[Any], None],
        depth: int = 5,
    ) -> None:
        """Listen to a topic. what: for us; take: is given each message; depth: of the queue."""
        ros = self._ros
        package = kind.__module__.partition(".")[0]
        name = self._node.resolve_topic_name(name)
        ear = Ear(name, what, f"{package}/msg/{kind.__name__}", asked)
        ear.is_once = asked == LATCHED

        def hear(message: Any) -> None:
            ear.n += 1
            ear.last_at = time.monotonic()
            if hasattr(message, "header"):
                ear.last_stamp_ns = stamp_of(message.header)
            take(message)

        def refuse(event: Any) -> None:
            policy = ros.rclpy_qos.qos_policy_name_from_kind(event.last_policy_kind)
            ear.policies.add(policy)

        ear.subscription = self._node.create_subscription(
            kind,
            name,
            hear,
            profile(ros, asked, depth),
            event_callbacks=ros.rclpy_event_handler.SubscriptionEventCallbacks(
                incompatible_qos=refuse
            ),
        )
        self.all.append(ear)

    def seen(self, ear: Ear) -> TopicSeen:
        """Return what is seen of a topic now."""
        offers = self._node.get_publishers_info_by_topic(ear.name)
        now = time.monotonic()
        ahead = None
        if ear.last_stamp_ns is not None:
            ahead = (ear.last_stamp_ns - self._node.get_clock().now().nanoseconds) / 1e9
            ahead += now - ear.last_at
        return TopicSeen(
            ear.name,
            ear.what,
            ear.kind,
            ear.asked,
            sorted({one.topic_type for one in offers}),
            [quality_of(one.qos_profile) for one in offers],
            ear.n,
            now - ear.last_at if ear.n else None,
            sorted(ear.policies),
            ahead,
            ear.is_once,
        )


def quality_of(profile: Any) -> Quality:
    return Quality(profile.reliability.name.lower(), profile.durability.name.lower())


def profile(ros: Ros, quality: Quality, depth: int) -> Any:
    """Return a QoS profile that keeps the last so many messages."""
    qos = ros.rclpy_qos
    return qos.QoSProfile(
        depth=depth,
        history=qos.HistoryPolicy.KEEP_LAST,
        reliability=qos.ReliabilityPolicy[quality.reliability.upper()],
        durability=qos.DurabilityPolicy[quality.durability.upper()],
    )
