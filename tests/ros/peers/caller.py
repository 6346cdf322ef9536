"""Call services, parameters and the action of the node, as JSON lines from standard input say.

Each line {"do": …} is answered by one line: change_state, get_state, trigger, set_bool, set, get,
describe, explore (begins), explored (waits), cancel.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import rclpy
from curiosight_msgs.action import Explore
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

NODE = "/curiosight"
WAIT_S = 80.0


class Caller:
    def __init__(self) -> None:
        rclpy.init()
        self.node = rclpy.create_node("caller")
        self.explore = ActionClient(self.node, Explore, f"{NODE}/explore")
        self.feedback: list[dict[str, Any]] = []
        self.goal: Any = None

    def wait(self, future: Any, seconds: float = WAIT_S) -> Any:
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=seconds)
        if not future.done():
            raise TimeoutError("no answer")
        return future.result()

    def call(self, kind: Any, name: str, request: Any) -> Any:
        client = self.node.create_client(kind, f"{NODE}/{name}")
        if not client.wait_for_service(WAIT_S):
            raise TimeoutError(f"no service {name}")
        answer = self.wait(client.call_async(request))
        self.node.destroy_client(client)
        return answer

    def do(self, asked: dict[str, Any]) -> dict[str, Any]:
        what = asked.pop("do")
        return getattr(self, f"do_{what}")(**asked)

    def do_change_state(self, label: str) -> dict[str, Any]:
        request = ChangeState.Request()
        request.transition.label = label
        request.transition.id = {
            "configure": 1, "cleanup": 2, "activate": 3, "deactivate": 4,
            "unconfigured_shutdown": 5, "inactive_shutdown": 6, "active_shutdown": 7,
        }[label]  # fmt: skip
        request.transition.label = ""
        return {"success": self.call(ChangeState, "change_state", request).success}

    def do_get_state(self) -> dict[str, Any]:
        answer = self.call(GetState, "get_state", GetState.Request())
        return {"label": answer.current_state.label}

    def do_trigger(self, name: str) -> dict[str, Any]:
        answer = self.call(Trigger, name, Trigger.Request())
        return {"success": answer.success, "message": answer.message}

    def do_set_bool(self, name: str, value: bool) -> dict[str, Any]:
        answer = self.call(SetBool, name, SetBool.Request(data=value))
        return {"success": answer.success, "message": answer.message}

    def do_set(self, name: str, value: Any) -> dict[str, Any]:
        request = SetParameters.Request()
        request.parameters = [Parameter(name, value=value).to_parameter_msg()]
        (result,) = self.call(SetParameters, "set_parameters", request).results
        return {"success": result.successful, "message": result.reason}

    def do_get(self, name: str) -> dict[str, Any]:
        request = GetParameters.Request(names=[name])
        (value,) = self.call(GetParameters, "get_parameters", request).values
        return {"string": value.string_value, "double": value.double_value}

    def do_describe(self, name: str) -> dict[str, Any]:
        request = DescribeParameters.Request(names=[name])
        (one,) = self.call(DescribeParameters, "describe_parameters", request).descriptors
        spans = [*one.floating_point_range, *one.integer_range]
        span = [[span.from_value, span.to_value] for span in spans]
        return {"description": one.description, "range": span}

    def do_explore(self, max_seconds: float = 0.0, home: list[float] | None = None) -> Any:
        if not self.explore.wait_for_server(WAIT_S):
            raise TimeoutError("no action explore")
        goal = Explore.Goal(max_seconds=max_seconds)
        if home is not None:
            goal.home.header.frame_id = "map"
            goal.home.pose.position.x, goal.home.pose.position.y = home
        self.feedback = []
        self.goal = self.wait(self.explore.send_goal_async(goal, feedback_callback=self._hear))
        return {"accepted": self.goal.accepted}

    def _hear(self, message: Any) -> None:
        told = message.feedback
        names = ("region", "name", "why", "error", "n_reached", "n_failed")
        self.feedback.append({name: getattr(told, name) for name in names})

    def do_explored(self, seconds: float) -> dict[str, Any]:
        answer = self.wait(self.goal.get_result_async(), seconds)
        found = answer.result
        names = ("reason", "text", "is_home", "n_reached", "n_failed", "error")
        told = {name: getattr(found, name) for name in names}
        return {"status": answer.status, **told, "feedback": self.feedback[-50:]}

    def do_cancel(self) -> dict[str, Any]:
        answer = self.wait(self.goal.cancel_goal_async())
        return {"n": len(answer.goals_canceling)}

    def do_spin(self, seconds: float) -> dict[str, Any]:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            rclpy.spin_once(self.node, timeout_sec=0.1)
        return {"n_feedback": len(self.feedback)}


def main() -> None:
    caller = Caller()
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        try:
            answer = caller.do(json.loads(line))
        except Exception as error:  # told to the test
            answer = {"failure": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
