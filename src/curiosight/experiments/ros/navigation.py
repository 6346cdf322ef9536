"""Drive by Nav2, and be told to explore: an action client, and the action server above it."""

from __future__ import annotations

import threading
import time
from collections import deque
from functools import partial
from typing import Any, Protocol

import numpy as np

from curiosight.errors import DataError
from curiosight.experiments.ros.inputs import place_of
from curiosight.experiments.ros.packages import Ros
from curiosight.explorer.outcome import Outcome
from curiosight.robot.ros.exploring import Exploring, GoTo, Phase, Reason, Stop
from curiosight.robot.ros.goals import Place

PERIOD_S = 0.2
# So long without the action of the navigation, and what it was told is lost; or there is none.
AWAY_S, LOST_S = 2.0, 20.0
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


class Explorer(Protocol):
    """What begins an exploration."""

    def begin(self, home: Place | None, max_s: float) -> Exploring:
        """Return it, begun; raises ValueError, in words, where it cannot be."""
        ...

    def error(self) -> float | None: ...

    def name_of(self, region: int) -> str: ...


class Navigation:
    """The action client, the action server, and the timer that drives an `Exploring`.

    All but `look` runs in the executor's thread.
    """

    def __init__(self, ros: Ros, node: Any, values: dict[str, Any], explorer: Explorer) -> None:
        self._ros, self._node, self._explorer = ros, node, explorer
        self._world = values["world_frame"]
        self._lock = threading.Lock()
        self._looks: deque[tuple[int | None, Outcome, float]] = deque(maxlen=100)
        self.exploring: Exploring | None = None
        self._goal: Any = None
        self._done: Any = None
        self._drive: Any = None
        self._lost_since: float | None = None
        self._to_cancel: set[int] = set()
        self._place: Place | None = None
        action = ros.rclpy_action
        self._client = action.ActionClient(
            node, ros.nav2_msgs_action.NavigateToPose, values["navigate_action"]
        )
        self._server = action.ActionServer(
            node,
            ros.curiosight_msgs_action.Explore,
            "~/explore",
            self._explore,
            goal_callback=self._consider,
            cancel_callback=lambda _: action.CancelResponse.ACCEPT,
        )
        self._timer = node.create_timer(PERIOD_S, self._tick)

    def close(self) -> None:
        """Give up what is under way, and the actions."""
        self.stop_exploring()
        self._node.destroy_timer(self._timer)
        self._server.destroy()
        self._client.destroy()

    def stop_exploring(self) -> None:
        """Give up what is under way; the robot stays where it is."""
        if self.exploring is not None:
            self._obey(self.exploring.cancel())
        self._finish()

    def look(self, region: int | None, outcome: Outcome, taken_at: float) -> None:
        """Hear of a look; any thread may tell."""
        with self._lock:
            self._looks.append((region, outcome, taken_at))

    @property
    def place(self) -> Place | None:
        """Where it drives to."""
        exploring = self.exploring
        return None if exploring is None or exploring.phase is Phase.OVER else self._place

    def _consider(self, request: Any) -> Any:
        is_free = self.exploring is None
        response = self._ros.rclpy_action.GoalResponse
        frame = request.home.header.frame_id
        if frame not in ("", self._world):
            self._node.get_logger().warning(f"explore: home is in {frame}, not in {self._world}")
            return response.REJECT
        return response.ACCEPT if is_free else response.REJECT

    async def _explore(self, goal: Any) -> Any:
        """Explore as long as it takes, and return what came of it."""
        request, result = goal.request, self._ros.curiosight_msgs_action.Explore.Result()
        try:
            home = place_of(request.home.pose) if request.home.header.frame_id else None
            exploring = self._explorer.begin(home, float(request.max_seconds))
        except (ValueError, DataError) as error:
            self._node.get_logger().warning(f"explore: {error}")
            result.reason, result.text, result.error = result.NOWHERE_TO_GO, str(error), np.nan
            goal.abort()
            return result
        self._looks.clear()
        self._lost_since = None
        self.exploring, self._goal = exploring, goal
        self._done = self._ros.rclpy.task.Future()
        await self._done
        ending = exploring.ending
        assert ending is not None
        result.reason = list(Reason).index(ending.reason)
        result.text, result.is_home = ending.text, ending.is_home
        result.n_reached, result.n_failed = exploring.n_reached, exploring.n_failed
        result.error = _number(self._explorer.error())
        self._node.get_logger().info(f"explore: {ending.text}")
        if goal.is_cancel_requested:
            goal.canceled()
        elif ending.reason in (Reason.CANCELED, Reason.NO_NAVIGATION):
            goal.abort()
        else:
            goal.succeed()
        return result

    def _finish(self) -> None:
        self.exploring = None
        if self._done is not None and not self._done.done():
            self._done.set_result(None)

    def _tick(self) -> None:
        exploring = self.exploring
        if exploring is None:
            return
        now = time.monotonic()
        with self._lock:
            looks, self._looks = list(self._looks), deque(maxlen=100)
        for look in looks:
            exploring.look(*look)
        if self._goal is not None and self._goal.is_cancel_requested:
            self._obey(exploring.cancel())
        self._watch_navigation(exploring, now)
        if exploring.phase is not Phase.OVER and self._lost_since is None:
            self._obey(exploring.next(now))
        if exploring.phase is Phase.OVER:
            self._finish()
        else:
            self._tell(exploring)

    def _watch_navigation(self, exploring: Exploring, now: float) -> None:
        """Give up where the navigation is away for long."""
        if self._client.server_is_ready():
            self._lost_since = None
            return
        if self._lost_since is None:
            self._lost_since = now
            self._node.get_logger().warning("explore: no navigation answers")
        if now - self._lost_since > AWAY_S and exploring.phase in (Phase.ASKING, Phase.GOING):
            exploring.interrupted()
        if now - self._lost_since > LOST_S:
            exploring.lost_navigation()

    def _tell(self, exploring: Exploring) -> None:
        feedback = self._ros.curiosight_msgs_action.Explore.Feedback()
        target = exploring.target
        feedback.region = -1 if target is None else target.region
        feedback.name = "home" if target is None else self._explorer.name_of(target.region)
        feedback.why, feedback.error = exploring.why(), _number(self._explorer.error())
        feedback.n_reached, feedback.n_failed = exploring.n_reached, exploring.n_failed
        self._goal.publish_feedback(feedback)

    def _obey(self, command: GoTo | Stop | None) -> None:
        if isinstance(command, Stop):
            if self._drive is not None:
                self._drive.cancel_goal_async()
                self._drive = None
            else:
                self._to_cancel.add(command.number)
        elif isinstance(command, GoTo):
            self._send(command)

    def _send(self, command: GoTo) -> None:
        place = self._place = command.place
        goal = self._ros.nav2_msgs_action.NavigateToPose.Goal()
        goal.pose.header.frame_id = self._world
        goal.pose.header.stamp = self._node.get_clock().now().to_msg()
        goal.pose.pose.position.x, goal.pose.pose.position.y = place.x, place.y
        goal.pose.pose.orientation.z = float(np.sin(place.yaw / 2))
        goal.pose.pose.orientation.w = float(np.cos(place.yaw / 2))
        self._drive = None
        # An answer that never comes is the goal's timeout.
        future = self._client.send_goal_async(goal)
        future.add_done_callback(partial(self._answered, command.number))

    def _answered(self, number: int, future: Any) -> None:
        exploring, drive = self.exploring, _result(future)
        if drive is None:
            return
        if number in self._to_cancel or exploring is None:
            self._to_cancel.discard(number)
            if drive.accepted:
                drive.cancel_goal_async()
            return
        exploring.answered(number, drive.accepted)
        if drive.accepted:
            self._drive = drive
            drive.get_result_async().add_done_callback(partial(self._arrived, number))

    def _arrived(self, number: int, future: Any) -> None:
        exploring, found = self.exploring, _result(future)
        if exploring is None or found is None:
            return
        failure = ""
        if found.status != SUCCEEDED:
            code = getattr(found.result, "error_code", 0)
            words = getattr(found.result, "error_msg", "") or (f"error {code}" if code else "")
            what = "cancelled by others" if found.status == CANCELED else "not reached"
            failure = f"{what} ({words})" if words else what
        by_others = found.status == CANCELED
        exploring.arrived(number, time.monotonic(), failure=failure, by_others=by_others)


def _result(future: Any) -> Any:
    """Return what came of a call; None = nothing, as its server died."""
    return None if future.cancelled() or future.exception() else future.result()


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
