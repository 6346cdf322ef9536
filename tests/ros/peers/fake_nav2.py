"""A fake Nav2: NavigateToPose, which moves the robot in tf as it drives.

    fake_nav2.py [--seconds S] [--refuse-left-of X] [--fail-below Y]

A goal left of X is refused, one below Y aborted with error 9000. Prints a line of JSON for each.
"""

from __future__ import annotations

import argparse
import json
import time
from contextlib import suppress
from typing import Any

import rclpy
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor


def say(**what: Any) -> None:
    print(json.dumps(what), flush=True)


class Nav2:
    def __init__(self, given: argparse.Namespace) -> None:
        self.given = given
        self.node = rclpy.create_node("bt_navigator")
        self.server = ActionServer(
            self.node,
            NavigateToPose,
            "navigate_to_pose",
            self.drive,
            goal_callback=self.consider,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def consider(self, request: Any) -> Any:
        place = request.pose.pose.position
        is_refused = place.x < self.given.refuse_left_of
        frame = request.pose.header.frame_id
        say(event="goal", x=place.x, y=place.y, frame=frame, refused=is_refused)
        return GoalResponse.REJECT if is_refused else GoalResponse.ACCEPT

    def drive(self, goal: Any) -> Any:
        began = time.monotonic()
        place = goal.request.pose.pose.position
        result = NavigateToPose.Result()
        while time.monotonic() - began < self.given.seconds:
            if goal.is_cancel_requested:
                goal.canceled()
                say(event="canceled", x=place.x, y=place.y)
                return result
            goal.publish_feedback(NavigateToPose.Feedback(distance_remaining=1.0))
            time.sleep(0.05)
        if place.y < self.given.fail_below:
            result.error_code = 9000
            goal.abort()
            say(event="aborted", x=place.x, y=place.y)
        else:
            goal.succeed()
            say(event="reached", x=place.x, y=place.y)
        return result


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=0.3)
    parser.add_argument("--refuse-left-of", type=float, default=-1e9)
    parser.add_argument("--fail-below", type=float, default=-1e9)
    given = parser.parse_args()
    rclpy.init()
    nav2 = Nav2(given)
    executor = MultiThreadedExecutor(3)
    executor.add_node(nav2.node)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
