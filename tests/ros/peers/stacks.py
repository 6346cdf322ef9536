"""Three ways to publish on a ROS graph, with messages as dictionaries: each a DDS of its own."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol


class Advertised(Protocol):
    def send(self, message: dict[str, Any]) -> None: ...


class Stack(Protocol):
    def advertise(
        self, topic: str, kind: str, *, reliability: str, durability: str, depth: int
    ) -> Advertised: ...


def open_stack(name: str, domain: int) -> Stack:
    return {"rosless": Rosless, "rclpy": Rclpy, "cyclonedds": Cyclone}[name](domain)


class Rosless:
    def __init__(self, domain: int) -> None:
        import rosless

        self._node = rosless.Node(domain)

    def advertise(
        self, topic: str, kind: str, *, reliability: str, durability: str, depth: int
    ) -> Advertised:
        return self._node.advertise(
            topic, kind, reliability=reliability, durability=durability, depth=depth
        )


@dataclass
class _RclpyPublisher:
    publisher: Any
    kind: Any

    def send(self, message: dict[str, Any]) -> None:
        self.publisher.publish(self._fill(self.kind(), message))

    def _fill(self, target: Any, values: dict[str, Any]) -> Any:
        for name, value in values.items():
            if isinstance(value, dict):
                self._fill(getattr(target, name), value)
            elif isinstance(value, bytes):
                setattr(target, name, array("B", value))
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                kind = import_module("geometry_msgs.msg").TransformStamped
                setattr(target, name, [self._fill(kind(), one) for one in value])
            else:
                setattr(target, name, value)
        return target


class Rclpy:
    def __init__(self, domain: int) -> None:
        import rclpy

        rclpy.init(domain_id=domain)
        self._node = rclpy.create_node("fake_camera")

    def advertise(
        self, topic: str, kind: str, *, reliability: str, durability: str, depth: int
    ) -> Advertised:
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

        package, _, name = kind.split("/")
        message = getattr(import_module(f"{package}.msg"), name)
        profile = QoSProfile(
            depth=depth,
            reliability=ReliabilityPolicy[reliability.upper()],
            durability=DurabilityPolicy[durability.upper()],
        )
        return _RclpyPublisher(self._node.create_publisher(message, topic, profile), message)


class Cyclone:
    """Eclipse Cyclone DDS, with the types of `cyclone_types.py`."""

    def __init__(self, domain: int) -> None:
        from cyclonedds.domain import DomainParticipant

        self._participant = DomainParticipant(domain)

    def advertise(
        self, topic: str, kind: str, *, reliability: str, durability: str, depth: int
    ) -> Advertised:
        from cyclone_types import TYPES, filled
        from cyclonedds.core import Policy, Qos
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic

        is_reliable = reliability == "reliable"
        qos = Qos(
            Policy.Reliability.Reliable(10**9) if is_reliable else Policy.Reliability.BestEffort,
            Policy.Durability.TransientLocal
            if durability == "transient_local"
            else Policy.Durability.Volatile,
            Policy.History.KeepLast(depth),
        )
        made = TYPES[kind]
        writer = DataWriter(self._participant, Topic(self._participant, f"rt{topic}", made), qos)

        class Sender:
            def send(self, message: dict[str, Any]) -> None:
                writer.write(filled(made, message))

        return Sender()
