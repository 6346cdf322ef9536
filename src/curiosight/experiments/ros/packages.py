"""ROS, imported when it is used, or one line that says what is missing."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace
from typing import Any

# What a node cannot do without, and how it is got.
NEEDED = (
    "rclpy",
    "rclpy.action",
    "rclpy.lifecycle",
    "rclpy.executors",
    "rclpy.event_handler",
    "rclpy.qos",
    "sensor_msgs.msg",
    "nav_msgs.msg",
    "geometry_msgs.msg",
    "visualization_msgs.msg",
    "diagnostic_msgs.msg",
    "std_srvs.srv",
    "rcl_interfaces.msg",
    "builtin_interfaces.msg",
    "tf2_msgs.msg",
    "vision_msgs.msg",
)
# For exploring only.
USEFUL = ("nav2_msgs.action", "curiosight_msgs.action")


class Ros(SimpleNamespace):
    """The modules of ROS by their names, dots as underscores; None = not there."""

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)


def import_ros() -> Ros:
    """Import what the node needs; raises ValueError, in one line, for what is missing."""
    found: dict[str, Any] = {}
    for name in (*NEEDED, *USEFUL):
        try:
            found[name.replace(".", "_")] = import_module(name)
        except ImportError as error:
            if name in NEEDED:
                raise ValueError(_remedy(name, error)) from None
            found[name.replace(".", "_")] = None
    return Ros(**found)


def _remedy(name: str, error: ImportError) -> str:
    package = name.partition(".")[0]
    if package == "rclpy":
        return (
            f"ros: rclpy cannot be imported ({error}); source ROS 2 first, as in `source "
            "/opt/ros/jazzy/setup.bash`, with a Python that is ROS's own"
        )
    debian = f"ros-$ROS_DISTRO-{package.replace('_', '-')}"
    return f"ros: {package} cannot be imported ({error}); install it: apt install {debian}"
