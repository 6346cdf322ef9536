"""What the node publishes: plain values made messages."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.experiments.ros.ears import LATCHED, profile, quality_of
from curiosight.experiments.ros.packages import Ros
from curiosight.robot.ros.detections import Detection
from curiosight.robot.ros.goals import Place
from curiosight.robot.ros.missing import Quality
from curiosight.robot.ros.squares import Squares

# Reliable, which those fit who want it and those who do not; the last only.
RESULT = Quality("reliable", "volatile")
OK, WARN, ERROR, STALE = 0, 1, 2, 3
NS = 1_000_000_000


class Outputs:
    """Publishers, made by `open`. Any thread may publish.

    Private names: saliency (mono8), saliency_float, labels, uncertainty, detections, vision_info,
    progress, regions; and /diagnostics.
    """

    def __init__(self, ros: Ros, node: Any) -> None:
        self._ros, self._node = ros, node
        self._publishers: dict[str, Any] = {}
        self._asked: dict[str, Quality] = {}
        self._policies: dict[str, set[str]] = {}
        self._diagnostics = node.create_publisher(
            ros.diagnostic_msgs_msg.DiagnosticArray, "/diagnostics", profile(ros, RESULT, 10)
        )

    def open(self) -> None:
        ros, images = self._ros, self._ros.sensor_msgs_msg.Image
        vision = ros.vision_msgs_msg
        for name in ("saliency", "saliency_float", "labels", "uncertainty"):
            self._publish_as(name, images, RESULT)
        self._publish_as("detections", vision.Detection2DArray, RESULT)
        self._publish_as("vision_info", vision.VisionInfo, LATCHED)
        self._publish_as("progress", ros.nav_msgs_msg.OccupancyGrid, LATCHED)
        self._publish_as("regions", ros.visualization_msgs_msg.MarkerArray, LATCHED)

    def close(self) -> None:
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers = {}

    def _publish_as(self, name: str, kind: Any, quality: Quality) -> None:
        ros = self._ros

        def refuse(event: Any) -> None:
            policy = ros.rclpy_qos.qos_policy_name_from_kind(event.last_policy_kind)
            self._policies.setdefault(name, set()).add(policy)

        self._asked[name] = quality
        self._publishers[name] = self._node.create_publisher(
            kind,
            f"~/{name}",
            profile(ros, quality, 1 if quality == LATCHED else 2),
            event_callbacks=ros.rclpy_event_handler.PublisherEventCallbacks(
                incompatible_qos=refuse
            ),
        )

    def is_wanted(self, name: str) -> bool:
        """Tell whether anybody listens."""
        publisher = self._publishers.get(name)
        return publisher is not None and publisher.get_subscription_count() > 0

    def refused(self) -> dict[str, str]:
        """Return what listeners ask for that we do not offer, by topic."""
        found: dict[str, str] = {}
        for name in self._policies:
            topic = self._publishers[name].topic_name if name in self._publishers else None
            if topic is None:
                continue
            for one in self._node.get_subscriptions_info_by_topic(topic):
                lacks = self._asked[name].lacks(quality_of(one.qos_profile))
                if lacks:
                    found[topic] = "; ".join(lacks)
        return found

    def _header(self, stamp_ns: int, frame: str) -> dict[str, Any]:
        ros = self._ros
        stamp = ros.builtin_interfaces_msg.Time(sec=stamp_ns // NS, nanosec=stamp_ns % NS)
        header = ros.sensor_msgs_msg.Image().header
        header.stamp, header.frame_id = stamp, frame
        return {"header": header}

    def image(
        self, name: str, pixels: npt.NDArray[Any], encoding: str, stamp_ns: int, frame: str
    ) -> None:
        """Publish (H, W) pixels of one channel."""
        message = self._ros.sensor_msgs_msg.Image(**self._header(stamp_ns, frame))
        message.height, message.width = pixels.shape
        message.encoding, message.step = encoding, pixels.shape[1] * pixels.itemsize
        message.is_bigendian = 0
        message.data = array("B", np.ascontiguousarray(pixels).tobytes())
        self._publishers[name].publish(message)

    def detections(self, found: Sequence[Detection], stamp_ns: int, frame: str) -> None:
        """Publish boxes, in their order; each one's id is its rank from 0."""
        vision = self._ros.vision_msgs_msg
        head = self._header(stamp_ns, frame)
        message = vision.Detection2DArray(**head)
        for rank, one in enumerate(found):
            x, y, width, height = one.box
            detection = vision.Detection2D(id=str(rank), **head)
            detection.bbox.center.position.x = x + (width - 1) / 2
            detection.bbox.center.position.y = y + (height - 1) / 2
            detection.bbox.size_x, detection.bbox.size_y = float(width), float(height)
            result = vision.ObjectHypothesisWithPose()
            result.hypothesis.class_id, result.hypothesis.score = "salient", one.score
            detection.results.append(result)
            message.detections.append(detection)
        self._publishers["detections"].publish(message)

    def vision_info(self, version: int, model: str, stamp_ns: int, frame: str) -> None:
        """Publish which model it is."""
        message = self._ros.vision_msgs_msg.VisionInfo(**self._header(stamp_ns, frame))
        message.method, message.database_location = "curiosight saliency", model
        message.database_version = version
        self._publishers["vision_info"].publish(message)

    def progress(self, squares: Squares, stamp_ns: int, world: str) -> None:
        """Publish by how much the error falls in each square of the floor, percent."""
        grid = squares.grid()
        if grid is None:
            return
        message = self._ros.nav_msgs_msg.OccupancyGrid(**self._header(stamp_ns, world))
        message.info.map_load_time = message.header.stamp
        message.info.resolution = grid.size
        message.info.height, message.info.width = grid.values.shape
        message.info.origin.position.x, message.info.origin.position.y = grid.origin
        message.info.origin.orientation.w = 1.0
        message.data = array("b", grid.values.tobytes())
        self._publishers["progress"].publish(message)

    def regions(
        self, squares: Squares, goal: Place | None, why: str, stamp_ns: int, world: str
    ) -> None:
        """Publish the squares, their names and errors, and where it goes."""
        kind = self._ros.visualization_msgs_msg.Marker
        message = self._ros.visualization_msgs_msg.MarkerArray()
        marker = partial(kind, action=kind.ADD, **self._header(stamp_ns, world))
        for number in range(len(squares)):
            square, (x, y) = squares[number], squares.centre(number)
            tile = marker(ns="regions", id=number, type=kind.CUBE)
            _put(tile, x, y, -0.02)
            tile.scale.x = tile.scale.y = 0.95 * squares.size
            tile.scale.z = 0.02
            _paint(tile, *_colour_of(square.error, square.left_alone))
            name = marker(ns="names", id=number, type=kind.TEXT_VIEW_FACING)
            _put(name, x, y, 0.1)
            name.scale.z = 0.15 * squares.size
            error = "" if square.error is None else f"\nerror {square.error:.2f}"
            name.text = square.name + error + (square.left_alone and f"\n{square.left_alone}")
            _paint(name, 1.0, 1.0, 1.0, 0.9)
            message.markers += [tile, name]
        arrow = marker(ns="goal", id=0, type=kind.ARROW)
        text = marker(ns="goal", id=1, type=kind.TEXT_VIEW_FACING, text=why)
        if goal is None:
            arrow.action = text.action = kind.DELETE
        else:
            _put(arrow, goal.x, goal.y, 0.1, goal.yaw)
            arrow.scale.x, arrow.scale.y, arrow.scale.z = 0.5, 0.1, 0.1
            _paint(arrow, 1.0, 0.6, 0.0, 1.0)
            _put(text, goal.x, goal.y, 0.4)
            text.scale.z = 0.15
            _paint(text, 1.0, 0.6, 0.0, 1.0)
        message.markers += [arrow, text]
        self._publishers["regions"].publish(message)

    def diagnostics(
        self, rows: Sequence[tuple[str, int, str, Mapping[str, Any]]], stamp_ns: int
    ) -> None:
        """Publish the node's state. rows: name, level, words, values."""
        messages = self._ros.diagnostic_msgs_msg
        message = messages.DiagnosticArray(**self._header(stamp_ns, ""))
        for name, level, text, values in rows:
            status = messages.DiagnosticStatus(level=bytes([level]), message=text)
            status.name = f"{self._node.get_name()}: {name}"
            status.hardware_id = self._node.get_fully_qualified_name()
            status.values = [
                messages.KeyValue(key=key, value=str(value)) for key, value in values.items()
            ]
            message.status.append(status)
        self._diagnostics.publish(message)


def _put(marker: Any, x: float, y: float, z: float, yaw: float = 0.0) -> None:
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = x, y, z
    marker.pose.orientation.z = float(np.sin(yaw / 2))
    marker.pose.orientation.w = float(np.cos(yaw / 2))


def _paint(marker: Any, *colour: float) -> None:
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = colour


def _colour_of(error: float | None, left_alone: str) -> tuple[float, float, float, float]:
    """Return from blue, known, to yellow, wrong; grey where nothing is known; red = left alone."""
    if left_alone:
        return 0.8, 0.1, 0.1, 0.6
    if error is None:
        return 0.5, 0.5, 0.5, 0.3
    share = min(1.0, max(0.0, error))
    return 0.1 + 0.8 * share, 0.2 + 0.6 * share, 0.8 - 0.7 * share, 0.6
