"""Run the node until it is to end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from curiosight.config import Config
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.ros.node import Asked, CuriosightNode
from curiosight.experiments.ros.packages import import_ros

TICK_S = 0.2
# What is said at the end has so long to arrive.
LAST_WORDS_S = 1.0


def run_node(
    config: Config,
    folder: OutputFolder,
    asked: Asked,
    is_wanted: Callable[[], bool],
    arguments: Sequence[str] = (),
) -> bool:
    """Spin the node until it is not wanted or was shut down; tell whether it could begin.

    arguments: for ROS, what follows --ros-args. Raises ValueError, in one line, where ROS or its
    messages are missing, or ROS does not understand the arguments.
    """
    ros = import_ros()
    rclpy = ros.rclpy
    try:
        rclpy.init(
            args=list(arguments), signal_handler_options=rclpy.signals.SignalHandlerOptions.NO
        )
    except Exception as error:  # of a kind of its own, by how they are wrong
        raise ValueError(f"--ros-args: {error}") from None
    try:
        owner = CuriosightNode(ros, config, folder, asked)
    except Exception as error:
        rclpy.try_shutdown()
        raise ValueError(f"--ros-args: {error}") from None
    executor = ros.rclpy_executors.SingleThreadedExecutor()
    executor.add_node(owner.node)
    has_begun = True
    try:
        if owner.values["autostart"]:
            has_begun = _begin(owner)
        while has_begun and is_wanted() and rclpy.ok() and not _is_over(owner):
            executor.spin_once(timeout_sec=TICK_S)
    finally:
        _stop_driving(owner, executor)
        owner.shutdown()
        executor.shutdown()
        owner.node.destroy_node()
        rclpy.try_shutdown()
    return has_begun


def _begin(owner: CuriosightNode) -> bool:
    success = owner.ros.rclpy_lifecycle.TransitionCallbackReturn.SUCCESS
    return bool(
        owner.node.trigger_configure() == success and owner.node.trigger_activate() == success
    )


def _stop_driving(owner: CuriosightNode, executor: Any) -> None:
    """Give up a drive that is under way, and let who asked for it hear that."""
    if owner.navigation is None or owner.navigation.exploring is None:
        return
    owner.navigation.stop_exploring()
    until = time.monotonic() + LAST_WORDS_S
    while time.monotonic() < until:
        executor.spin_once(timeout_sec=TICK_S)


def _is_over(owner: CuriosightNode) -> bool:
    """Tell whether somebody has shut the node down."""
    return bool(owner.node._state_machine.current_state[1] == "finalized")
