"""The node's parameters: names, ranges, and what they are for."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from curiosight.experiments.ros.packages import Ros
from curiosight.explorer.strategies import check_loadable

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
    Parameter("model", "", "run or model that maps are made by; read again by the service load",
              is_live=True),
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


NAMES = tuple(one.name for one in PARAMETERS)
BY_NAME = {one.name: one for one in PARAMETERS}


def declare(ros: Ros, node: Any, given: Mapping[str, Value]) -> dict[str, Any]:
    """Declare all on a node, with their ranges; return the values.

    given: defaults instead of the usual ones. Raises ValueError for a parameter that somebody sets
    and that there is none of: ROS would pass over it.
    """
    messages = ros.rcl_interfaces_msg
    for name in node._parameter_overrides:
        if name not in NAMES and name not in _OF_ROS:
            nearest = difflib.get_close_matches(name, NAMES, n=1)
            hint = f"; did you mean {nearest[0]}?" if nearest else ""
            raise ValueError(f"no parameter is called {name}{hint}")
    for one in PARAMETERS:
        described = messages.ParameterDescriptor(description=one.description)
        if one.least is not None and one.most is not None:
            if isinstance(one.default, int):
                ends = {"from_value": int(one.least), "to_value": int(one.most)}
                described.integer_range = [messages.IntegerRange(step=1, **ends)]
            else:
                span = messages.FloatingPointRange(from_value=one.least, to_value=one.most)
                described.floating_point_range = [span]
        node.declare_parameter(one.name, given.get(one.name, one.default), described)
    values = {name: node.get_parameter(name).value for name in NAMES}
    check(values, is_configured=False)
    return values


def check(values: Mapping[str, Any], *, is_configured: bool) -> None:
    """Raise ValueError, in words, for values that cannot be, or not now."""
    if "strategy" in values:
        check_loadable(values["strategy"])
    if values.get("reliability", "reliable") not in ("reliable", "best_effort"):
        found = values["reliability"]
        raise ValueError(f"reliability: expected best_effort or reliable, got {found!r}")
    fixed = [name for name in values if not BY_NAME[name].is_live]
    if is_configured and fixed:
        raise ValueError(f"{', '.join(fixed)}: can be changed while the node is not configured")


# Parameters that every node has.
_OF_ROS = ("use_sim_time", "start_type_description_service")
