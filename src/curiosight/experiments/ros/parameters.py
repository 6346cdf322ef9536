"""The node's parameters: names, ranges, and what they are for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Value = bool | int | float | str


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter as ROS declares it. least, most: of a number; is_live: may change at any time.

    Others are read when the node is configured.
    """

    name: str
    default: Value
    description: str
    least: float | None = None
    most: float | None = None
    is_live: bool = False


PARAMETERS = (
    Parameter("color_topic", "/camera/camera/color/image_raw", "colour: Image, or CompressedImage "
              "where the name ends in /compressed"),
    Parameter("depth_topic", "/camera/camera/aligned_depth_to_color/image_raw", "depth, registered "
              "to colour or of a camera of its own; empty = maps only, nothing is learned"),
    Parameter("color_info_topic", "", "CameraInfo of colour; empty = camera_info beside it"),
    Parameter("depth_info_topic", "", "CameraInfo of depth; empty = camera_info beside it"),
    Parameter("map_topic", "/map", "occupancy grid of the floor that exploring chooses goals on"),
    Parameter("world_frame", "map", "frame of the poses, of goals and of the regions"),
    Parameter("base_frame", "base_link", "the robot's frame: what a goal is for"),
    Parameter("reliability", "best_effort", "of the image subscriptions: best_effort, which fits "
              "every camera, or reliable"),
    Parameter("max_stamp_gap", 0.02, "seconds between the stamps of colour and its depth",
              0.0, 1.0),
    Parameter("max_wait", 0.2, "seconds that a frame waits for its depth and tf before it is "
              "learned from", 0.0, 2.0),
    Parameter("depth_unit", 0.001, "metres per unit of whole numbers of depth", 1e-6, 1.0),
    Parameter("model", "", "run or model that maps are made by; read again by the service load"),
    Parameter("learn", False, "learn from what depth says"),
    Parameter("autostart", True, "configure and activate without a lifecycle manager"),
    Parameter("region_size", 1.5, "side of the squares of floor that regions are, metres",
              0.2, 20.0),
    Parameter("threshold", 0.5, "saliency from which on a spot is a detection", 0.0, 1.0,
              is_live=True),
    Parameter("strategy", "progress-rate", "what chooses where to explore next, as of `curiosight "
              "explore`", is_live=True),
    Parameter("navigate_action", "navigate_to_pose", "Nav2's action that goals are sent to"),
    Parameter("goal_spacing", 1.0, "metres between places that may be goals", 0.2, 10.0),
    Parameter("clearance", 0.35, "metres from a goal to what is not free", 0.0, 3.0),
    Parameter("headings", 4, "views from a place", 1, 16),
    Parameter("looks_per_goal", 3, "frames to look at before going on", 1, 100, is_live=True),
    Parameter("goal_timeout", 120.0, "seconds until a goal that is not reached is left alone",
              1.0, 3600.0, is_live=True),
    Parameter("patience", 60, "looks without a fall of the error that end exploring", 1, 100000,
              is_live=True),
    Parameter("min_fall", 0.01, "by which the mean error must come down to have fallen", 0.0, 1.0,
              is_live=True),
)  # fmt: skip


def unknown(values: dict[str, Any]) -> list[str]:
    """Return the names among some that are no parameters."""
    known = {one.name for one in PARAMETERS}
    return [name for name in values if name not in known]
